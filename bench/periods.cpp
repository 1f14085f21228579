// A lossless oscillator over very many periods: what each method does to its energy and phase, and at what price. The
// table of docs/performance.md, as Markdown.
//   bench_periods [PERIODS]      default: 1000000
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "two_states_plain.hpp"

namespace {

using namespace bgsim;

struct Row {
  Method method;
  double relative = 0.0;           ///< of error-controlled methods
  double steps_in_a_period = 0.0;  ///< of fixed-step methods
};

const std::vector<Row> kRows{
    {Method::bdf, 1e-8, 0.0},    {Method::bdf, 1e-10, 0.0},    {Method::adams, 1e-8, 0.0}, {Method::adams, 1e-10, 0.0},
    {Method::adams, 1e-12, 0.0}, {Method::erk5, 1e-8, 0.0},    {Method::erk8, 1e-8, 0.0},  {Method::erk8, 1e-10, 0.0},
    {Method::erk8, 1e-12, 0.0},  {Method::dirk5, 1e-8, 0.0},   {Method::rk4, 0.0, 40.0},   {Method::rk4, 0.0, 200.0},
    {Method::verlet, 0.0, 20.0}, {Method::verlet, 0.0, 200.0},
};

}  // namespace

int main(int argc, char** argv) {
  const double periods = argc > 1 ? std::strtod(argv[1], nullptr) : 1e6;
  if (!(periods >= 1.0)) {
    std::fprintf(stderr, "usage: bench_periods [PERIODS]\n");
    return 2;
  }
  const double period = 2.0 * std::numbers::pi;
  const Simulation compiled =
      Study::from_text(R"({ "bgsim": 1, "name": "oscillator", "elements": { "loop": { "kind": "1" },
        "l": { "kind": "I", "inertance": 1 }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } },
        "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" } ],
        "outputs": { "q": "c.q", "p": "l.p" }, "scenes": { "run": { "stop": 1, "samples": 2 } } })")
          .scene("", {}, {.energy_audit = false});
  RunInputs inputs = compiled.inputs();
  inputs.start = 0.0;
  inputs.stop = periods * period;
  inputs.output_times = {inputs.stop};
  SimulateOptions how;
  how.energy_audit = false;
  how.error_estimate = false;

  std::printf("| method | setting | steps in a period | change of energy | phase, rad | processor time, s |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const Row& row : kRows) {
    inputs.method = row.method;
    char setting[60];
    if (row.relative > 0.0) {
      inputs.relative = row.relative;
      inputs.step = 0.0;
      std::snprintf(setting, sizeof setting, "relative %g", row.relative);
    } else {
      inputs.step = period / row.steps_in_a_period;
      std::snprintf(setting, sizeof setting, "%g steps in a period", row.steps_in_a_period);
    }
    const double begin = bench::cpu_seconds();
    const RunResult result = compiled.simulate(inputs, how);
    const double seconds = bench::cpu_seconds() - begin;
    if (result.stop != StopReason::completed) {
      std::printf("| `%s` | %s | | | %s | |\n", method_name(row.method).c_str(), setting,
                  result.failure->situation.c_str());
      continue;
    }
    // the state turns clockwise from (1, 0): after whole periods it should be there again
    const double q = result.trace.columns[0].front(), p = result.trace.columns[1].front();
    std::printf("| `%s` | %s | %.0f | %.1e | %.1e | %.1f |\n", method_name(row.method).c_str(), setting,
                static_cast<double>(result.report.steps) / periods, q * q + p * p - 1.0, std::abs(std::atan2(p, q)),
                seconds);
    std::fflush(stdout);
  }
  return 0;
}
