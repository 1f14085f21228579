/// Laws of resistors that are at a border of theirs: dry friction at rest, a relief valve at its level.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// A border that the law of a resistor may hold (see Stiction), in the network of the diodes: there the law is linear
/// between its two sides, with a place from 0, below the guard's 0, to 1, above it, that takes whatever keeps it there.
struct NetworkBorder {
  ElementId element;
  std::string name;
  double at_border = 0.5;  ///< the place that the law has for a guard that is 0
  struct Mode {
    double below, at, above;
  };
  /// Of the law's sign, step or comparison where the guard is below 0, 0 and above; none where there are several.
  std::optional<Mode> mode;
};

struct AtBorder {
  ElementId resistor;
  /// Of the law's sign, step or comparison, between those of its sides; not finite where that is not known.
  double mode = std::numeric_limits<double>::quiet_NaN();
  double share = 0.0;  ///< that less the mode of a guard of 0
};

/// With its place between the two sides.
AtBorder law_at(const NetworkBorder& border, double place);

/// Sets Element::share of those that a program has no equation for what holds them, since diodes lock what moves there;
/// and those of all others to 0.
void put_shares(const Program& program, const std::vector<AtBorder>& laws, std::vector<double>& parameters);

}  // namespace bgsim
