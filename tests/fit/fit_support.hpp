/// Models and data for tests of fits.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bgsim/fit.hpp"
#include "support/run.hpp"

namespace bgsim::test {

/// A capacitor that is charged through a resistor: u = U + (q0/C - U) exp(-t/(R C)).
inline std::string capacitor(const std::string& scene = R"("stop": 2, "samples": 11, "relative": 1e-11)") {
  return model_text(R"x("parameters": { "R": 2, "C": 0.5, "U": 3, "tau": "R*C" },
    "elements": { "s": { "kind": "Se", "effort": "U" }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
      "c": { "kind": "C", "capacitance": "C", "initial": { "q": 0.25 } } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "u": { "value": "c.e", "unit": "V" }, "i": "r.f", "s": "s.e" }, "scenes": { "charge": {)x" +
                    scene + "} }");
}

/// "t,u" and a row for each time.
inline FitData measured(const std::vector<double>& times, const std::function<double(double)>& u,
                        const std::string& scene = {}) {
  FitData data;
  data.scene = scene;
  data.name = "data.csv";
  data.cells.table.names = {"t", "u"};
  data.cells.table.columns.resize(2);
  data.cells.faults.resize(2);
  for (const double t : times) {
    data.cells.lines.push_back(data.cells.lines.size() + 2);
    data.cells.table.columns[0].push_back(t);
    data.cells.table.columns[1].push_back(u(t));
  }
  return data;
}

/// @p count times from @p begin to @p end.
inline std::vector<double> times(double begin, double end, std::size_t count) {
  std::vector<double> list;
  for (std::size_t i = 0; i < count; ++i)
    list.push_back(begin + (end - begin) * static_cast<double>(i) / static_cast<double>(count - 1));
  return list;
}

/// Of "u" to the column "u".
inline FitPlan plan_of(const std::vector<std::string>& vary, std::vector<FitData> data, double sigma = 0.0) {
  FitPlan plan;
  for (const std::string& each : vary) plan.vary.push_back(parse_fit_variation(each));
  plan.matches = {{"u", "u", sigma}};
  plan.data = std::move(data);
  return plan;
}

}  // namespace bgsim::test
