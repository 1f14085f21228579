/// slice: only what the recorded outputs depend on.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/bond_graph.hpp"
#include "bgsim/ordering.hpp"

namespace bgsim {

/// The equations and their order without what is left out; ids of symbols, expressions and outputs stay as they were.
struct Slice {
  EquationSystem system;  ///< `left_out` says what is missing
  BlockOrder order;
};

/// Leaves out what @p outputs (positions in EquationSystem::outputs) do not depend on through states, equations,
/// moduli, conditions, dependent stores and loops. The outputs that remain are the same, exactly: only the integrator's
/// steps, hence its errors within the tolerances, may differ.
///
/// The energy balance (if @p audit) is that of the elements whose powers are still known. Where a bond leads from
/// them to an element whose power cannot, what flows over it counts as supplied, in the name of that element.
///
/// @return  none if nothing can be left out.
/// @note Time linear in the equations.
std::optional<Slice> slice(const Model& model, const BondGraph& graph, const EquationSystem& system,
                           const BlockOrder& order, const std::vector<std::size_t>& outputs, bool audit);

/// The elements, junctions among them, none of whose equations @p outputs depend on: those that could as well not be
/// there. In model order.
std::vector<ElementId> unobserved_elements(const Model& model, const EquationSystem& system,
                                           const std::vector<std::size_t>& outputs);

}  // namespace bgsim
