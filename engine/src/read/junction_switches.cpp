/// "on" of a junction: a condition that connects what is bonded to it. Off, a 0-junction has no effort and a 1-junction
/// no flow (Mosterman's controlled junctions). An ideal switch at the junction does just that, so that is what it
/// becomes.
#include <algorithm>

#include "read/reader.hpp"

namespace bgsim {

void Reader::declare_junction_switch(std::size_t scope, NodeId node) {
  const Document& file = document(scopes_[scope]);
  const std::string name = scopes_[scope].prefix + std::string(file[node].key);
  const std::string index = index_text(scopes_[scope].indices);
  const auto junction = names_.find(name + index);
  if (junction == names_.end() || junction->second.kind != Entity::Kind::element) return;
  Element element;
  element.name = name + "_on" + index;
  element.kind = written_kind("Sw")->row->kind;
  element.place = file.key_place(file.find(node, "on"));
  element.ports = {""};
  junction_switches_[model_.elements.size()] = junction->second.index;
  add_element(scope, node, std::move(element));
}

/// One bond each, after those of the file.
void Reader::bond_junction_switches(std::size_t scope) {
  std::vector<std::pair<std::size_t, std::size_t>> here;
  for (const auto& [index, junction] : junction_switches_)
    if (declaring(element_text_[index].names) == scope) here.emplace_back(index, junction);
  std::sort(here.begin(), here.end());
  const NodeId array = section(scopes_[scope], "bonds", JsonKind::array);
  std::size_t position = array.valid() ? document(scopes_[scope])[array].child_count : 0;
  for (const auto& [index, junction] : here) {
    const Place place = model_.elements[index].place;
    ModelBond bond;
    bond.name = scopes_[scope].prefix + automatic_name(scope, ++position);
    names_.try_emplace(bond.name, Entity{Entity::Kind::bond, static_cast<std::uint32_t>(model_.bonds.size()), place});
    bond.place = place;
    bond.from = {ElementId(junction), std::nullopt, place};
    bond.to = {ElementId(index), std::nullopt, place};
    model_.bonds.push_back(std::move(bond));
  }
}

void Reader::parse_junction_switch(std::size_t index) {
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  const NodeId on = file.find(node, "on");
  const ExprId connects = condition({scope, nullptr, nullptr}, on, "\"on\"");
  Element& element = model_.elements[index];
  element.coefficient = model_.pool.constant(0.0);
  element.coefficient_place = file.place(on);
  if (!connects.valid()) return;
  // In a 1-junction the switch is in series and closed while it is on, in a 0-junction beside all others and open.
  const bool series = shared_variable(model_.elements[junction_switches_.at(index)].kind) == Variable::flow;
  const ExprId parts = model_.pool.make(Op::logical_not, connects);
  SwitchLaw law;
  law.closes = series ? connects : parts;
  law.opens = series ? parts : connects;
  law.closes_place = law.opens_place = file.place(on);
  element.switches = law;
}

}  // namespace bgsim
