/// Linear systems that a few Gauss-Seidel sweeps solve well enough to know how large their solution is.
#pragma once

#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Solves A x = b to a tenth of each component, by sweeps there and back. False where these do not converge fast (or a
/// diagonal entry is 0): then x is anything. No entry fills in, and short steps' matrices I - hJ need three or four
/// sweeps, where KLU factors. The error is what is left of a geometric series: each sweep must change x by less than
/// seven tenths of what the one before did, largest over the components relative to these.
/// @param entries  of the pattern, by columns. @cite varga1962 (Gauss-Seidel sweeps)
bool solve_by_sweeps(const Sparsity& pattern, const std::vector<double>& entries, const double* b,
                     std::vector<double>& x);

}  // namespace bgsim
