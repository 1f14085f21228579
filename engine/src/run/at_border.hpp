/// Laws of resistors that are at a border of theirs: dry friction at rest, a relief valve at its level.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// A border that the law of a resistor may hold (see Stiction), in the network of the diodes: there the law is linear
/// between its two sides, with a place from 0, below the guard's 0, to 1, above it, that takes whatever keeps it there.
struct NetworkBorder {
  ElementId element;
  std::string name;
};

struct AtBorder {
  ElementId resistor;
  /// Of the sign of the law (see use_own_borders), from -1 to 1; not finite where that is not known.
  double mode = std::numeric_limits<double>::quiet_NaN();
};

/// Sets Element::share of those that a program has no equation for what holds them, since diodes lock what moves there;
/// and those of all others to 0.
void put_shares(const Program& program, const std::vector<AtBorder>& laws, std::vector<double>& parameters);

}  // namespace bgsim
