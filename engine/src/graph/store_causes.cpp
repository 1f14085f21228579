#include "graph/store_causes.hpp"

#include <algorithm>

#include "graph/causal_explanation.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// Some of the elements behind a stroke. Strokes with one cause share their cause's set, so that all sets together
/// stay linear in the graph.
struct Causes {
  std::vector<ElementId> elements;
  bool more = false;

  void add(ElementId element) {
    const auto place = std::lower_bound(elements.begin(), elements.end(), element);
    if (place != elements.end() && *place == element) return;
    elements.insert(place, element);
    if (elements.size() > kNamedCauses) {
      elements.pop_back();
      more = true;
    }
  }
};

}  // namespace

void list_stores(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                 std::span<const BondId> trail, const std::unordered_map<BondId, std::set<BondId>>& eliminated,
                 CausalGraph& causal) {
  std::vector<Causes> sets;
  std::vector<std::uint32_t> set_of(strokes.size());
  const auto causes_of = [&](BondId bond) {
    const Stroke& stroke = strokes[bond.index()];
    Causes causes;
    const auto add = [&](BondId cause) {
      const Causes& set = sets[set_of[cause.index()]];
      for (const ElementId element : set.elements) causes.add(element);
      causes.more = causes.more || set.more;
    };
    if (stroke.reason == StrokeReason::by_elimination)
      for (const BondId cause : eliminated.at(bond)) add(cause);
    else if (stroke.reason == StrokeReason::propagated)
      for (const BondId cause : direct_causes(graph, strokes, bond)) add(cause);
    else
      causes.add(stroke.element);
    return causes;
  };
  for (const BondId bond : trail) {
    const BondId cause = strokes[bond.index()].cause;
    if (cause.valid()) {
      set_of[bond.index()] = set_of[cause.index()];
    } else {
      Causes causes = causes_of(bond);
      set_of[bond.index()] = static_cast<std::uint32_t>(sets.size());
      sets.push_back(std::move(causes));
    }
  }
  for (std::size_t i = 0; i < graph.ports.size(); ++i) {
    const PortId port(i);
    const ElementKind kind = graph.kinds[graph[port].element.index()];
    if (!is_store(kind)) continue;
    if (stroke_at(graph, strokes, port) !=
        stores_displacement(model.elements[graph[port].element.index()], graph[port].number)) {
      causal.integral.push_back(port);
    } else {
      const Causes& causes = sets[set_of[graph[port].bond.index()]];
      causal.dependent.push_back({graph[port].element, graph[port].number, causes.elements, causes.more});
    }
  }
}

}  // namespace bgsim
