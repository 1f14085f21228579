#include "equations/junctions.hpp"

#include <algorithm>

#include "base/codes.hpp"
#include "graph/junction_rank.hpp"
#include "graph/modulus_residues.hpp"

namespace bgsim {

std::vector<JunctionSolution> solve_junctions(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                                              const JunctionPart& part, ExprPool& pool,
                                              const std::function<ExprId(ElementId)>& modulus,
                                              const std::function<ExprId(BondId, Variable)>& given) {
  ModulusResidues residues(model);
  const auto factor = [&](ElementId id) {
    return Coefficient{residues(model.elements[id.index()].coefficient), modulus(id)};
  };
  JunctionRank rank(graph, part, factor, &pool);
  std::map<std::uint32_t, ExprId> inputs;
  for (const PortId port : part.outer) {
    const Gives gives = causal.gives(graph, port);
    const std::uint32_t variable = rank.variable(port, gives);
    rank.take(variable);
    inputs[variable] = given(graph[port].bond, gives == Gives::effort ? Variable::effort : Variable::flow);
  }
  const std::vector<std::optional<JunctionRank::Row>> solutions = rank.solutions();
  std::vector<JunctionSolution> result;
  const auto add = [&](BondId bond, Variable variable, PortId inside) {
    const std::uint32_t at = rank.variable(bond, variable);
    if (inputs.contains(at)) return;
    JunctionSolution solution{bond, variable, graph[inside].element, {}};
    if (solutions[at]) {
      solution.value = pool.constant(0.0);
      for (const auto& [input, coefficient] : *solutions[at]) {
        const ExprId value = inputs.at(input);
        // subtractions are easier to read than sums of negative terms
        solution.value = pool.is_constant(coefficient.expression, -1.0)
                             ? pool.sub(solution.value, value)
                             : pool.add(solution.value, pool.mul(coefficient.expression, value));
      }
    }
    result.push_back(solution);
  };
  for (const BondId bond : part.inner)
    for (const Variable variable : {Variable::effort, Variable::flow}) add(bond, variable, graph[bond].tail);
  for (const PortId port : part.outer)
    for (const Variable variable : {Variable::effort, Variable::flow})
      add(graph[port].bond, variable, graph.opposite(port));
  return result;
}

Diagnostic undetermined_fault(const Model& model, ElementId junction, const std::string& what, const Place& asked) {
  const Element& element = model.elements[junction.index()];
  const std::string name = "\"" + element.name + "\"";
  return diagnostic_of("BG411", "nothing determines " + what + ": it runs round the ring of junctions at " + name,
                       asked, "a quantity that is asked for must follow from sources and stores",
                       "ask for one of an element outside of the ring, or give the ring an R or a store of its own",
                       {{element.place, "the ring runs through " + name}});
}

}  // namespace bgsim
