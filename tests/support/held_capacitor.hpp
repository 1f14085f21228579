/// A capacitor charged through a resistor until a switch opens: u = U (1 - exp(-a/(R C))) from a on.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "bgsim/study.hpp"

namespace bgsim::test {

struct HeldCapacitor {
  double U = 3, R = 2, C = 0.4, a = 0.7;  ///< a before the scene's end, 1
  std::vector<std::string> parameters = {"U", "R", "C", "a"};

  [[nodiscard]] Study study() const {
    return Study::from_text(R"x({ "bgsim": 1, "name": "held", "parameters": { "U": 3, "R": 2, "C": 0.4, "a": 0.7 },
    "elements": { "s": { "kind": "Se", "effort": "U" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": "R" }, "k": { "kind": "Sw", "closed": "t < a" },
      "c": { "kind": "C", "capacitance": "C" } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "k" },
      { "from": "loop", "to": "c" } ],
    "outputs": { "u": "c.e" }, "scenes": { "run": { "stop": 1, "samples": 3 } } })x");
  }
  /// What is left of U at the resistor when the switch opens, as a part of it.
  [[nodiscard]] double rest() const { return std::exp(-a / (R * C)); }
  /// Derivatives of u at the end, by parameter.
  [[nodiscard]] std::vector<double> derivatives() const {
    const double e = rest();
    return {1 - e, -U * e * a / (R * R * C), -U * e * a / (R * C * C), U * e / (R * C)};
  }
};

}  // namespace bgsim::test
