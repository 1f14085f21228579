/// What a mode of switches and diodes leaves indefinite.
#pragma once

#include <string>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

struct Indefinite {
  std::vector<std::string> outputs;  ///< names of those that depend on it, in order
  std::vector<ElementId> diodes;  ///< that have one of the efforts, or flows, that they may have, besides idle switches
};

/// The effort or flow that an idle switch is taken not to have (with_idle_switches()) may have any value, and so may
/// that of some diodes. Of diodes in series that block, one is on the conducting side, since a part of the graph that
/// all of them cut off would have no effort: no flow comes to it by the equations, and its effort may be anything below
/// its threshold that the others allow. Of diodes in parallel that conduct, all but one are on the blocking side, and
/// how the flow divides is not known. Which diodes these are is seen at random values of all that is given
/// (RandomPoint), so it is wrong with a probability of some 1e-9.
///
/// A diode beside which a closed switch leaves no effort is taken to carry nothing: that is no choice among diodes.
///
/// Cost: some passes over the equations' pool; none where no output depends on a diode's or an idle switch's side.
Indefinite indefinite_outputs(const Model& model, const BondGraph& graph, const EquationSystem& system);

}  // namespace bgsim
