#include "study/junction_measure.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/element_kinds.hpp"

namespace bgsim {

std::shared_ptr<const Model> with_bonds_as_outputs(const Model& model) {
  auto result = std::make_shared<Model>(model);
  std::vector<SymbolId> symbols(2 * model.bonds.size());
  const auto place = [](BondId bond, Variable variable) {
    return 2 * bond.index() + (variable == Variable::flow ? 1 : 0);
  };
  for (std::size_t i = 0; i < model.symbols.size(); ++i)
    if (const ModelSymbol& symbol = model.symbols[i]; symbol.kind == ModelSymbol::Kind::bond_variable)
      symbols[place(symbol.bond, symbol.variable)] = SymbolId(i);
  for (std::size_t b = 0; b < model.bonds.size(); ++b)
    for (const Variable variable : {Variable::effort, Variable::flow}) {
      SymbolId& known = symbols[place(BondId(b), variable)];
      if (!known.valid()) {
        ModelSymbol symbol;
        symbol.kind = ModelSymbol::Kind::bond_variable;
        symbol.bond = BondId(b);
        symbol.variable = variable;
        known = SymbolId(result->symbols.size());
        result->symbols.push_back(symbol);
      }
      Output output;
      output.name = symbol_name(*result, known);
      output.value = result->pool.symbol(known);
      result->outputs.push_back(std::move(output));
    }
  return result;
}

JunctionMeasure::JunctionMeasure(const BondGraph& graph, const Trace& trace, std::size_t outputs) : graph_(graph) {
  const auto rms = [&](std::size_t column) {
    double root = 0.0;  // squares may be beyond the range of double precision
    for (const double value : trace.columns[column]) root = std::hypot(root, value);
    return root / std::sqrt(static_cast<double>(std::max<std::size_t>(1, trace.times.size())));
  };
  for (std::size_t b = 0; b < graph.bonds.size(); ++b) {
    efforts_.push_back(rms(outputs + 2 * b));
    flows_.push_back(rms(outputs + 2 * b + 1));
  }
}

double JunctionMeasure::largest_at(ElementId junction, const std::vector<double>& size) const {
  double largest = 0.0;
  for (std::size_t k = 0; k < graph_.port_count(junction); ++k)
    largest = std::max(largest, size[graph_[graph_.port(junction, k)].bond.index()]);
  return largest;
}

CutKind JunctionMeasure::first_choice(ElementId element) const {
  const PortId port = graph_.port(element, 0);
  const ElementId junction = graph_[graph_.opposite(port)].element;
  const ElementKind kind = graph_.kinds[junction.index()];
  const auto shared = shared_variable(kind);
  if (!shared) return CutKind::zero_effort;
  const bool common_flow = *shared == Variable::flow;
  const std::vector<double>& own = common_flow ? efforts_ : flows_;
  const std::vector<double>& common = common_flow ? flows_ : efforts_;
  const std::size_t bond = graph_[port].bond.index();
  const auto ratio = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };

  const double own_ratio = ratio(own[bond], largest_at(junction, own));
  double beside = common[bond];
  for (std::size_t k = 0; k < graph_.port_count(junction); ++k) {
    const ElementId next = graph_[graph_.opposite(graph_.port(junction, k))].element;
    const ElementKind next_kind = graph_.kinds[next.index()];
    if (is_junction(next_kind) && next_kind != kind) beside = std::max(beside, largest_at(next, common));
  }
  const double common_ratio = ratio(common[bond], beside);
  const bool cut_own = own_ratio <= common_ratio;
  return cut_own == common_flow ? CutKind::zero_effort : CutKind::zero_flow;
}

}  // namespace bgsim
