/// Exact partial derivatives of a system's rates, loops and outputs at a point, and where there are none.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bgsim/linear.hpp"

namespace bgsim {

/// A point of a system.
struct LinearizationPoint {
  double t = 0.0;
  std::span<const double> parameters, x;
  std::span<const double> errors;  ///< by state: how far it can be off; empty: not at all
};

/// Partials by the states, then the loops' variables.
struct PointPartials {
  LinearMatrix rates, loops, outputs;
  std::vector<double> rate, output, loop;  ///< values; the loops' variables
  std::vector<std::string> loop_names;
  std::vector<std::string> notes;  ///< loops with other solutions
};

/// @param edges  whether kinks, jumps and borders of conditions at the point are refused.
/// @throws ModelError BG407 no finite value or slope; BG408.
PointPartials partials_at(const std::shared_ptr<const Model>& model, const EquationSystem& system,
                          const BlockOrder& order, const LinearizationPoint& point, bool edges);

/// That events, samples and latches have no part in what is said of a point; empty where there are none.
std::vector<std::string> events_left_out(const Model& model);

/// "the loop through a, b has no solution", "sqrt(x) with x = -1 is not a finite number"
std::string words_of(const Fault& fault);

}  // namespace bgsim
