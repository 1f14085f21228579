/// The equations of parts of the junction structure that are solved as a whole (CausalGraph::ranked).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// A bond's variable in such a part as a sum over what is given at the part's outer ports.
struct JunctionSolution {
  BondId bond;
  Variable variable = Variable::effort;
  ElementId element;  ///< which gives it: a junction, TF or GY
  ExprId value;       ///< none if nothing determines it
};

/// @param modulus   the modulus of a TF or GY in @p pool.
/// @param given     an effort or flow of a bond as an expression of @p pool.
std::vector<JunctionSolution> solve_junctions(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                                              const JunctionPart& part, ExprPool& pool,
                                              const std::function<ExprId(ElementId)>& modulus,
                                              const std::function<ExprId(BondId, Variable)>& given);

/// BG411: the line at @p asked wants what runs round the ring at @p junction and comes out nowhere.
Diagnostic undetermined_fault(const Model& model, ElementId junction, const std::string& what, const Place& asked);

}  // namespace bgsim
