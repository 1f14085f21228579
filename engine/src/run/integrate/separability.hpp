/// Whether a system can be split into two halves that move each other: what Störmer-Verlet needs.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/equations.hpp"
#include "bgsim/model.hpp"
#include "bgsim/program.hpp"

namespace bgsim {

/// By state: true where it is kicked (half a step, a whole step of the others, half a step). The rate of a kicked state
/// depends on drifting states and time only, and the other way round. In a lossless graph of C and I in integral
/// causality these are the momenta and the displacements; gyrators may mix them.
using Halves = std::vector<bool>;

/// What prevents it.
struct NotSeparable {
  std::size_t state = 0, other = 0;  ///< the rate of `state` depends on `other`, which is itself or of the same half
  std::vector<std::string> losses;   ///< names of the resistors (R, RR)
};

/// By colouring the graph of which rate depends on which state with two colours; time linear in its edges.
std::optional<Halves> separate(const Program& program, NotSeparable& obstacle);

/// BG610.
Diagnostic not_separable_failure(const Program& program, const NotSeparable& obstacle);

}  // namespace bgsim
