#include "draw/plan.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

Hangs hangs(ElementKind kind) { return kind_row(kind).hangs; }

/// The bonds of an element.
struct Around {
  std::size_t entering = 0, leaving = 0;              ///< half-arrows
  std::size_t chain_entering = 0, chain_leaving = 0;  ///< those from and to junctions and two-ports
  std::size_t sources = 0;                            ///< half-arrows from one-ports
  std::size_t fields_before = 0;                      ///< those to further ports of fields, counted as entering too
  [[nodiscard]] std::size_t bonds() const { return entering - fields_before + leaving; }
  /// Whether something other than @p leaves one-ports is right of it, or several bonds meet in it from the left.
  [[nodiscard]] bool goes_on(std::size_t leaves) const {
    return leaving - fields_before > leaves || chain_entering > 1 || (chain_entering == 1 && sources > 0);
  }
};

std::vector<Around> arounds(const Model& model) {
  std::vector<Around> around(model.elements.size());
  for (const ModelBond& bond : model.bonds) {
    Around &from = around[bond.from.element.index()], &to = around[bond.to.element.index()];
    const Element &tail = model.elements[bond.from.element.index()], &head = model.elements[bond.to.element.index()];
    ++from.leaving;
    ++to.entering;
    from.chain_leaving += passes_power(head.kind) ? 1U : 0U;
    to.chain_entering += passes_power(tail.kind) ? 1U : 0U;
    to.sources += !is_junction(tail.kind) && port_count(tail) == 1 ? 1U : 0U;
    // A field comes before the junctions at its further ports, though their half-arrows enter it.
    if (!is_field(head.kind) || bond.to.port.value_or(0) == 0) continue;
    ++from.fields_before;
    ++from.entering;
  }
  return around;
}

double name_width(const Element& element) { return text_width(local_name(element.name), kNameSize); }

/// By signal with memory: what it reads where it is sampled or latched.
using Memories = std::map<SignalId, std::vector<ExprId>>;

Memories memories_of(const Model& model) {
  Memories memories;
  for (const ModelEvent& event : model.events)
    for (const ModelEvent::Set& set : event.sets) {
      if (!event.at_start || !set.signal.valid()) continue;
      memories[set.signal].insert(memories[set.signal].end(), {event.when, set.value});
    }
  return memories;
}

/// What an element reads, followed through signals.
class Reading {
 public:
  Reading(const Model& model, const Memories& memories, ElementId to, std::vector<ReadSignal>& found)
      : model_(model), memories_(memories), to_(to), found_(found) {}

  void follow(std::vector<ExprId> roots) {
    std::erase_if(roots, [](ExprId root) { return !root.valid(); });
    std::vector<std::pair<ExprId, std::string>> waiting;
    for (const ExprId root : roots) waiting.emplace_back(root, "");
    while (!waiting.empty()) {
      const auto [root, through] = waiting.back();
      waiting.pop_back();
      for (const SymbolId symbol : symbols_in(model_.pool, std::vector{root})) {
        const ModelSymbol& at = model_.symbols[symbol.index()];
        if (at.kind == ModelSymbol::Kind::signal) {
          const Signal& signal = model_.signals[at.signal.index()];
          if (!seen_.insert(at.signal).second) continue;
          const std::string name = through.empty() ? local_name(signal.name) : through;
          waiting.emplace_back(signal.delay ? signal.delay->value : signal.value, name);
          if (const auto memory = memories_.find(at.signal); memory != memories_.end())
            for (const ExprId read : memory->second) waiting.emplace_back(read, name);
        } else if (at.kind == ModelSymbol::Kind::port_variable || at.kind == ModelSymbol::Kind::bond_variable ||
                   at.kind == ModelSymbol::Kind::mode) {
          add(at, symbol, through);
        }
      }
    }
  }

 private:
  void add(const ModelSymbol& at, SymbolId symbol, const std::string& through) {
    if (at.element == to_) return;
    ReadSignal signal;
    if (at.element.valid())
      signal.from = at.element;
    else
      signal.from_bond = at.bond;
    signal.to = to_;
    const std::string name = symbol_name(model_, symbol);
    if (!sources_.insert({signal.from, signal.from_bond}).second) return;
    const std::string owner =
        signal.from.valid() ? model_.elements[at.element.index()].name : model_.bonds[at.bond.index()].name;
    const bool mode = at.kind == ModelSymbol::Kind::mode;
    signal.label = !through.empty() ? through : mode ? "mode" : name.substr(owner.size() + 1);
    signal.about =
        model_.elements[to_.index()].name + " reads " + name + (through.empty() ? "" : " through " + through);
    found_.push_back(std::move(signal));
  }

  const Model& model_;
  const Memories& memories_;
  ElementId to_;
  std::vector<ReadSignal>& found_;
  std::set<SignalId> seen_;
  std::set<std::pair<ElementId, BondId>> sources_;
};

}  // namespace

std::vector<Standing> standings(const Model& model) {
  const std::vector<Around> around = arounds(model);
  std::vector<std::vector<ElementId>> hanging(model.elements.size());
  for (const ModelBond& bond : model.bonds)
    for (const auto& [junction, leaf] :
         {std::pair(bond.from.element, bond.to.element), std::pair(bond.to.element, bond.from.element)}) {
      const Element& at = model.elements[junction.index()];
      const Element& one_port = model.elements[leaf.index()];
      if (is_junction(at.kind) && around[junction.index()].bonds() > 2 && hangs(one_port.kind) != Hangs::nowhere &&
          around[leaf.index()].bonds() == 1 && scope_of(at.name) == scope_of(one_port.name))
        hanging[junction.index()].push_back(leaf);
    }
  std::vector<Standing> standing(model.elements.size());
  for (std::size_t i = 0; i < standing.size(); ++i) standing[i].host = ElementId(i);
  const auto kind = [&](ElementId id) { return model.elements[id.index()].kind; };
  for (std::size_t i = 0; i < hanging.size(); ++i) {
    auto& leaves = hanging[i];
    // There are two places; what takes power comes first.
    if (leaves.size() > 2) std::erase_if(leaves, [&](ElementId leaf) { return is_detector(kind(leaf)); });
    std::sort(leaves.begin(), leaves.end(),
              [&](ElementId a, ElementId b) { return std::pair(hangs(kind(a)), a) < std::pair(hangs(kind(b)), b); });
    // Where nothing else does, one of them goes on to the right: of two the R, if there is one.
    if (!leaves.empty() && !around[i].goes_on(leaves.size()) && leaves.size() < 3)
      leaves.erase(leaves.size() == 2 && hangs(kind(leaves.front())) == Hangs::between ? leaves.begin()
                                                                                       : leaves.end() - 1);
    if (leaves.empty()) continue;
    const bool low = leaves.size() > 1 || hangs(kind(leaves.back())) == Hangs::below;
    if (low) standing[leaves.back().index()] = {ElementId(i), Side::below};
    if (!low || leaves.size() > 1) standing[leaves.front().index()] = {ElementId(i), Side::above};
  }
  return standing;
}

std::vector<Hand> hands(const Model& model) {
  const std::vector<Around> around = arounds(model);
  std::vector<Hand> hands(model.elements.size(), Hand::none);
  std::vector<char> first_of_two(model.elements.size(), 1);
  for (const ModelBond& bond : model.bonds)
    for (const bool leaves : {true, false}) {
      const ElementId at = leaves ? bond.from.element : bond.to.element;
      const ElementId at_other = leaves ? bond.to.element : bond.from.element;
      const Element &element = model.elements[at.index()], &neighbour = model.elements[at_other.index()];
      const Around& other = around[at_other.index()];
      if (is_junction(element.kind) || port_count(element) > 1 || around[at.index()].bonds() != 1) continue;
      // One of two at a junction alone is on its left.
      const bool alone = is_junction(neighbour.kind) && other.chain_leaving == 0 &&
                         std::exchange(first_of_two[at_other.index()], 0) != 0;
      const bool first = !leaves && other.entering == 0 && (other.chain_leaving > 0 || alone);
      const bool last = leaves && other.chain_entering > 0 && other.chain_leaving == 0;
      hands[at.index()] = (leaves && !last) || first ? Hand::left : Hand::right;
    }
  return hands;
}

std::vector<Extent> extents(const Model& model, const std::vector<Standing>& standings, const std::vector<Hand>& hand) {
  std::vector<Extent> extents(model.elements.size());
  for (std::size_t i = 0; i < extents.size(); ++i) {
    const Element& element = model.elements[i];
    const double half = capsule(element, {}).box().width() / 2;
    const bool fields = port_count(element) > 1;
    Extent& extent = extents[i];
    extent = {half, half, 14.0, 14.0};
    if (is_junction(element.kind)) {
      extent.top = 24.0;
    } else if (fields) {
      extent.left = extent.right = std::max(half, name_width(element) / 2);
      extent.bottom = 30.0;
    } else {
      (hand[i] == Hand::left ? extent.left : extent.right) += name_width(element) + 8.0;
    }
  }
  for (std::size_t i = 0; i < extents.size(); ++i) {
    const auto [host, side] = standings[i];
    if (side == Side::none) continue;
    Extent& extent = extents[host.index()];
    (side == Side::above ? extent.top : extent.bottom) = kDrop + 30.0;
    const double half = std::max(14.0, name_width(model.elements[i]) / 2 + 2.0);
    extent.left = std::max(extent.left, half);
    extent.right = std::max(extent.right, half);
  }
  return extents;
}

std::vector<ReadSignal> read_signals(const Model& model) {
  std::vector<ReadSignal> found;
  const Memories memories = memories_of(model);
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const Element& element = model.elements[i];
    std::vector<ExprId> roots{element.coefficient, element.energy};
    for (const Law& law : element.laws) roots.push_back(law.right);
    if (element.switches) roots.insert(roots.end(), {element.switches->closes, element.switches->opens});
    if (element.diode) roots.push_back(element.diode->fire);
    Reading(model, memories, ElementId(i), found).follow(std::move(roots));
  }
  return found;
}

}  // namespace bgsim
