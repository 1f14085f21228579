#include "bgsim/bond_graph.hpp"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/connected_components.hpp>
#include <stdexcept>

#include "base/text.hpp"
#include "graph/graph_faults.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// One end of a bond; a default-made one marks a port that no bond has taken yet.
struct End {
  BondId bond;
  bool head = false;
  bool by_arrow = false;  // the half-arrow chose this port of a TF or GY, the text names none
};

class GraphBuilder {
 public:
  explicit GraphBuilder(const Model& model) : model_(model), ends_(model.elements.size()) {
    for (std::size_t i = 0; i < model.elements.size(); ++i)
      if (!is_junction(model.elements[i].kind)) ends_[i].resize(model.elements[i].ports.size());
  }

  BondGraph build() {
    attach_all();
    refuse_acting_detectors();
    refuse_unbonded({});
    if (!problems_.empty()) throw ModelError(std::move(problems_), model_.sources);
    return numbered();
  }

  std::vector<Diagnostic> faults(const BondedElsewhere& elsewhere) {
    attach_all();
    refuse_acting_detectors();
    if (!elsewhere.any) refuse_unbonded(elsewhere.elements);
    return std::move(problems_);
  }

 private:
  const ModelBond& bond(const End& end) const { return model_.bonds[end.bond.index()]; }
  const BondEndText& text(const End& end) const { return end.head ? bond(end).to : bond(end).from; }

  void attach_all() {
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      const ModelBond& bond = model_.bonds[i];
      if (bond.from.element == bond.to.element && bond.from.element.valid()) {
        refuse_self_bond(bond);
      } else {
        attach(BondId(i), false);
        attach(BondId(i), true);
      }
    }
  }

  void attach(BondId id, bool head) {
    End end{id, head};
    if (!text(end).element.valid()) return;  // of a model with faults, see graph_faults
    const std::size_t index = text(end).element.index();
    const Element& element = model_.elements[index];
    std::size_t port = text(end).port.value_or(0);
    if (is_junction(element.kind)) {
      ends_[index].push_back(end);
      return;
    }
    if (!text(end).port && is_two_port(element.kind)) {
      end.by_arrow = true;
      port = head ? 0 : 1;
    } else if (port >= element.ports.size() || (!text(end).port && element.ports.size() > 1)) {
      throw std::invalid_argument("bond " + bond(end).name + " names no port of " + element.name);
    }
    End& taken = ends_[index][port];
    if (taken.bond.valid())
      refuse_second(taken, end, element, port);
    else
      taken = end;
  }

  /// A detector keeps its own flow or effort at zero. Anywhere but at the junction that shares the other variable, that
  /// would act on the model.
  void refuse_acting_detectors() {
    for (const ModelBond& bond : model_.bonds) {
      if (!bond.from.element.valid() || !bond.to.element.valid()) continue;
      for (const auto& [own, other] : {std::pair(&bond.from, &bond.to), std::pair(&bond.to, &bond.from)}) {
        const Element& detector = model_.elements[own->element.index()];
        if (!is_detector(detector.kind)) continue;
        const bool effort = imposed_variable(detector.kind) == Variable::flow;
        const Element& at = model_.elements[other->element.index()];
        if (shared_variable(at.kind) == (effort ? Variable::effort : Variable::flow)) continue;
        problems_.push_back(
            {.code = "BG207",
             .situation = "the detector " + in_quotes(detector.name) + " is bonded to " + in_quotes(at.name) +
                          ", which is " + (effort ? "no 0-junction" : "no 1-junction"),
             .place = bond.place,
             .notes = {},
             .rule = effort ? "a De takes no flow: at a 0-junction that changes nothing, elsewhere it "
                              "would hold the flow at 0"
                            : "a Df takes no effort: at a 1-junction that changes nothing, elsewhere it "
                              "would hold the effort at 0",
             .help = std::string("put a ") + (effort ? "0" : "1") +
                     "-junction where it is to measure, and bond it to that"});
      }
    }
  }

  void refuse_self_bond(const ModelBond& at) {
    const std::string& name = model_.elements[at.from.element.index()].name;
    problems_.push_back({.code = "BG205",
                         .situation = "bond " + in_quotes(at.name) + " joins " + in_quotes(name) + " to itself",
                         .place = at.place,
                         .notes = {},
                         .rule = "a bond carries power between two different elements",
                         .help = "name another element in \"from\" or \"to\", or leave the bond out"});
    self_bonded_.push_back(at.from.element);
  }

  void refuse_second(const End& first, const End& second, const Element& element, std::size_t port) {
    const bool untold = first.by_arrow || second.by_arrow;
    const bool others_free = untold && !ends_[text(second).element.index()][1 - port].bond.valid();
    Diagnostic problem;
    problem.place = text(second).place;
    problem.notes = {{text(first).place, "bond " + in_quotes(bond(first).name) + " already ends there"}};
    if (others_free) {
      // Two half-arrows that both enter or both leave: complete, but for which bond is which.
      problem.code = "BG203";
      problem.situation = "the half-arrows of bonds " + in_quotes(bond(first).name) + " and " +
                          in_quotes(bond(second).name) + " do not distinguish the ports of " + in_quotes(element.name);
      problem.rule = "port 1 of a TF or GY takes the bond whose half-arrow enters, port 2 the one that leaves";
      problem.help = "write " + in_quotes(element.name + ".1") + " and " + in_quotes(element.name + ".2") +
                     " in the two bonds, or reverse one half-arrow";
      untold_.push_back(text(second).element);
    } else {
      problem.code = "BG201";
      problem.situation = "bond " + in_quotes(bond(second).name) + " ends at " + in_quotes(port_name(element, port)) +
                          ", which already has a bond";
      problem.rule = "a port carries one bond";
      problem.help = "put a 0-junction (same effort) or a 1-junction (same flow) between " + in_quotes(element.name) +
                     " and its bonds";
    }
    problems_.push_back(std::move(problem));
  }

  void refuse_unbonded(const std::unordered_set<std::uint32_t>& elsewhere) {
    // An element whose bond was refused above is not reported a second time for lack of it.
    std::vector<bool> known(model_.elements.size());
    for (const std::uint32_t index : elsewhere) known[index] = true;
    for (const ElementId id : self_bonded_) known[id.index()] = true;
    for (const ElementId id : untold_) known[id.index()] = true;
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      std::vector<std::string> open;
      std::size_t bonded = 0;
      for (std::size_t port = 0; port < ends_[i].size(); ++port) {
        if (ends_[i][port].bond.valid())
          ++bonded;
        else
          open.push_back(port_name(element, port));
      }
      if (known[i] || (open.empty() && bonded > 0)) continue;
      if (bonded == 0)
        problems_.push_back({.code = "BG204",
                             .situation = in_quotes(element.name) + " has no bonds",
                             .place = element.place,
                             .notes = {},
                             .rule = "every element has a bond",
                             .help = "add a bond from or to " + in_quotes(element.name) + ", or leave it out"});
      for (std::size_t k = 0; bonded > 0 && k < open.size(); ++k)
        problems_.push_back({.code = "BG202",
                             .situation = "port " + in_quotes(open[k]) + " has no bond",
                             .place = element.place,
                             .notes = {},
                             .rule = "every port carries one bond",
                             .help = "add a bond from or to " + in_quotes(open[k])});
    }
  }

  BondGraph numbered() const {
    BondGraph graph;
    graph.kinds.reserve(model_.elements.size());
    graph.first_port.reserve(model_.elements.size() + 1);
    graph.bonds.resize(model_.bonds.size());
    graph.ports.reserve(2 * model_.bonds.size());
    graph.first_port.push_back(0);
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      graph.kinds.push_back(model_.elements[i].kind);
      for (std::size_t number = 0; number < ends_[i].size(); ++number) {
        const End& end = ends_[i][number];
        const PortId id(graph.ports.size());
        graph.ports.push_back({ElementId(i), static_cast<std::uint32_t>(number), end.bond, end.head});
        Bond& at = graph.bonds[end.bond.index()];
        (end.head ? at.head : at.tail) = id;
      }
      graph.first_port.push_back(static_cast<std::uint32_t>(graph.ports.size()));
    }
    return graph;
  }

  const Model& model_;
  std::vector<std::vector<End>> ends_;  // by element, by port (junctions: as they come)
  std::vector<ElementId> self_bonded_, untold_;
  std::vector<Diagnostic> problems_;
};

}  // namespace

BondGraph build_bond_graph(const Model& model) { return GraphBuilder(model).build(); }

std::vector<Diagnostic> graph_faults(const Model& model, const BondedElsewhere& elsewhere) {
  return GraphBuilder(model).faults(elsewhere);
}

std::vector<std::vector<ElementId>> connected_parts(const BondGraph& graph) {
  boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS> neighbours(graph.kinds.size());
  for (const Bond& bond : graph.bonds)
    boost::add_edge(graph[bond.tail].element.index(), graph[bond.head].element.index(), neighbours);
  std::vector<std::size_t> part_of(graph.kinds.size());
  const std::size_t count = part_of.empty() ? 0 : boost::connected_components(neighbours, part_of.data());
  // Parts are numbered in the order in which their first elements stand in the model.
  std::vector<std::vector<ElementId>> parts(count);
  for (std::size_t i = 0; i < part_of.size(); ++i) parts[part_of[i]].push_back(ElementId(i));
  return parts;
}

}  // namespace bgsim
