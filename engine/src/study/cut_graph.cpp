#include "study/cut_graph.hpp"

#include <stdexcept>

#include "model/element_kinds.hpp"

namespace bgsim {

CutGraph::CutGraph(const BondGraph& graph, const std::vector<Cut>& cuts, const std::vector<ElementId>& dropped)
    : cut_(graph.kinds.size(), false),
      gone_element_(graph.kinds.size(), false),
      gone_bond_(graph.bonds.size(), false),
      used_(graph.kinds.size(), false) {
  for (const Cut& cut : cuts) {
    if (!is_passive_one_port(graph.kinds[cut.element.index()]))
      throw std::invalid_argument("only R, C and I can be cut out");
    cut_[cut.element.index()] = true;
    const PortId port = graph.port(cut.element, 0);
    const ElementKind joint = graph.kinds[graph[graph.opposite(port)].element.index()];
    // What is cut changes nothing at a junction that shares its other variable.
    if (shared_variable(joint) != (cut.kind == CutKind::zero_effort ? Variable::flow : Variable::effort)) continue;
    gone_element_[cut.element.index()] = true;
    gone_bond_[graph[port].bond.index()] = true;
  }
  for (const ElementId element : dropped) {
    gone_element_[element.index()] = true;
    for (std::size_t k = 0; k < graph.port_count(element); ++k)
      gone_bond_[graph[graph.port(element, k)].bond.index()] = true;
  }
}

std::vector<ElementId> CutGraph::drop_dangling(const BondGraph& graph) {
  std::vector<std::uint32_t> bonds(graph.kinds.size(), 0);
  for (std::size_t b = 0; b < graph.bonds.size(); ++b) {
    if (gone_bond_[b]) continue;
    ++bonds[graph[graph.bonds[b].tail].element.index()];
    ++bonds[graph[graph.bonds[b].head].element.index()];
  }
  std::vector<ElementId> dropped, open;
  // Only what cuts have bared: a junction that dangles in the model as written stays as it is.
  for (std::size_t b = 0; b < graph.bonds.size(); ++b)
    if (gone_bond_[b])
      for (const PortId end : {graph.bonds[b].tail, graph.bonds[b].head}) open.push_back(graph[end].element);
  while (!open.empty()) {
    const ElementId at = open.back();
    open.pop_back();
    const bool candidate = is_junction(graph.kinds[at.index()]) && !gone_element_[at.index()] && !used_[at.index()];
    if (!candidate || bonds[at.index()] > 1) continue;
    ElementId neighbour;
    BondId last;
    for (std::size_t k = 0; k < graph.port_count(at); ++k) {
      const PortId port = graph.port(at, k);
      if (gone_bond_[graph[port].bond.index()]) continue;
      last = graph[port].bond;
      neighbour = graph[graph.opposite(port)].element;
    }
    if (last.valid()) {
      if (graph.kinds[neighbour.index()] != graph.kinds[at.index()]) continue;
      gone_bond_[last.index()] = true;
      --bonds[neighbour.index()];
      open.push_back(neighbour);
    }
    gone_element_[at.index()] = true;
    dropped.push_back(at);
  }
  return dropped;
}

}  // namespace bgsim
