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

/// The parameters Element::own_border and share, with the value 0, for each of these laws.
void add_own_borders(Model& model);

/// Adds these parameters to the guards and values of these laws. So each law has a border of its own: of two clutches
/// between the same shafts each has its own part of what holds both, and one between shafts that diodes lock carries
/// what it is given, where no equation says what that is.
void use_own_borders(Model& model);

}  // namespace bgsim
