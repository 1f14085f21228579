/// Modes in which switches set what other switches set already.
#pragma once

#include "bgsim/equations.hpp"

namespace bgsim {

/// Two switches that are open in series set one flow twice, two that are closed in parallel one effort. The graph does
/// not allow that, although only the effort (the flow) between them is indefinite: that of the other follows. So of
/// such switches, in model order, those with which the equations have no order any more are made idle (Element::idle):
/// of the other side's kind, which sets what is indefinite to 0.
///
/// A model that the graph allows as it is comes back unchanged, and so does one that it refuses for another reason: an
/// idle switch must have, by the equations, the 0 that it would set; and nothing may depend on what is indefinite but
/// outputs and powers (indefinite_outputs()). Both are looked for at random values of all that is given, so a model
/// that passes fails to be so with a probability of some 1e-9.
/// @note As many derivations as the logarithm of the number of switches for each idle one; one where none is.
Model with_idle_switches(Model model);

[[nodiscard]] bool has_idle_switches(const Model& model);

/// The effort or flow that the side of a switch, diode or contact imposes, or the other one of its bond.
SymbolId side_variable(const Model& model, const BondGraph& graph, const EquationSystem& system, ElementId id,
                       bool imposed);

}  // namespace bgsim
