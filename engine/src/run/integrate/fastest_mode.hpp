/// The mode that an explicit method is held by.
#pragma once

#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

struct FastestMode {
  double rate = 0.0;   ///< |lambda| of the largest eigenvalue, per unit of time
  double angle = 0.0;  ///< of it, radians from the negative real axis: 0 decays, pi/2 oscillates, pi grows
};

/// Of a Jacobian, to some tenths: by power iteration from a vector that is always the same, and the recurrence of
/// second order that its last three vectors come nearest to. (No bound: it may stay below, by what the vector has not
/// of the mode.) Infinite where entries are not finite. Cost: some thirty products with a vector. @cite hairer1996
/// (IV.2, stiffness detection)
FastestMode fastest_mode(const Sparsity& pattern, const std::vector<double>& entries);

}  // namespace bgsim
