/// Laws that hold at a border (dry friction, a relief valve), as the network of the diodes has them.
#pragma once

#include <vector>

#include "bgsim/model.hpp"
#include "run/diodes.hpp"

namespace bgsim {

struct TakenBorder {
  NetworkBorder border;
  ExprId guard;
};

/// Makes each law of a resistor that has signs, steps or comparisons, all of one guard, linear between what it is where
/// the guard is below 0 and above: between the two its place takes whatever keeps the guard at 0 (see Stiction).
/// Resistors with several guards stay as they are, since their places would be multiplied by each other, and so do laws
/// that may have no value or slope at the border (a root), or that do not jump there.
///
/// The place is an integral whose rate is 0.
std::vector<TakenBorder> take_borders(Model& model);

}  // namespace bgsim
