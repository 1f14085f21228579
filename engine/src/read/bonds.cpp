#include <algorithm>
#include <array>

#include "read/reader.hpp"

namespace bgsim {

void Reader::declare_bonds(std::size_t scope) {
  const NodeId array = section(scopes_[scope], "bonds", JsonKind::array);
  if (!array.valid()) {
    lost_bonds_ = lost_bonds_ || unreadable(scopes_[scope], "bonds");
    return;
  }
  std::size_t index = model_.bonds.size();
  NodeId at_fault;  // one message for all copies
  for (const BondText& bond : name_bonds(scope, array)) {
    if (bond.node != at_fault && !declare_bond_ends(scope, bond, index)) at_fault = bond.node;
    ++index;
  }
  bond_junction_switches(scope);
}

/// All bonds get their names before any end is looked at: first those that the file gives, then, for the others, names
/// that nothing in the file has.
std::vector<Reader::BondText> Reader::name_bonds(std::size_t scope, NodeId array) {
  static constexpr std::array<std::string_view, 5> kKeys{"from", "to", "name", "about", "repeat"};
  const Document& file = document(scopes_[scope]);
  std::vector<BondText> bonds;
  struct Nameless {
    std::size_t first, count, position;
  };
  std::vector<Nameless> nameless;  // the first bond, how many, and where in the file
  std::size_t position = 0;
  for (NodeId node = file[array].first_child; node.valid(); node = file[node].next_sibling) {
    ++position;
    if (!expect(file, node, JsonKind::object, "a bond")) {
      lost_bonds_ = true;
      continue;
    }
    check_keys(file, node, kKeys, "a bond");
    text_of(file, node, "about");
    const NodeId given = file.find(node, "name");
    const bool named = given.valid() && expect(file, given, JsonKind::string, "a bond's name") &&
                       valid_name(file[given].text, file.place(given), "a bond");
    const std::optional<std::vector<IndexValues>> copies = copies_of_bond(scope, node);
    if (!copies) {
      lost_bonds_ = true;
      broken_.insert(scopes_[scope].prefix + (named ? std::string(file[given].text) : automatic_name(scope, position)));
      continue;
    }
    if (!named) nameless.push_back({model_.bonds.size(), copies->size(), position});
    if (named && copies->front().any())
      claim_repeated(scopes_[scope].prefix + std::string(file[given].text), range_of(copies->front(), copies->back()),
                     file.place(given));
    for (const IndexValues& indices : *copies) {
      ModelBond bond;
      bond.place = file.place(node);
      if (named) {
        bond.name = scopes_[scope].prefix + std::string(file[given].text) + index_text(indices);
        claim(bond.name, {Entity::Kind::bond, static_cast<std::uint32_t>(model_.bonds.size()), file.place(given)});
      }
      model_.bonds.push_back(std::move(bond));
      bonds.push_back({node, indices});
    }
  }
  const std::size_t first = model_.bonds.size() - bonds.size();
  for (const Nameless& each : nameless) {
    const std::string name = scopes_[scope].prefix + automatic_name(scope, each.position);
    for (std::size_t index = each.first; index < each.first + each.count; ++index) {
      ModelBond& bond = model_.bonds[index];
      bond.name = name + index_text(bonds[index - first].indices);
      names_.try_emplace(bond.name, Entity{Entity::Kind::bond, static_cast<std::uint32_t>(index), bond.place});
    }
  }
  return bonds;
}

/// "b3", or "b3_" where something in the file is called b3.
std::string Reader::automatic_name(std::size_t scope, std::size_t position) {
  const Document& file = document(scopes_[scope]);
  const NodeId ports = file.find(Document::root(), "ports");
  const bool has_ports = ports.valid() && file[ports].kind == JsonKind::object;
  std::string name = "b" + std::to_string(position);
  while (names_.contains(scopes_[scope].prefix + name) || broken_.contains(scopes_[scope].prefix + name) ||
         (has_ports && file.find(ports, name).valid()))
    name += '_';
  return name;
}

bool Reader::declare_bond_ends(std::size_t scope, const BondText& bond, std::size_t index) {
  const auto from = bond_end(scope, bond, "from");
  const auto to = bond_end(scope, bond, "to");
  if (from) model_.bonds[index].from = *from;
  if (to) model_.bonds[index].to = *to;
  return from && to;
}

std::optional<BondEndText> Reader::bond_end(std::size_t scope, const BondText& bond, std::string_view key) {
  const Document& file = document(scopes_[scope]);
  const NodeId value = file.find(bond.node, key);
  lost_bonds_ = lost_bonds_ || !value.valid() || file[value].kind != JsonKind::string;
  if (!value.valid()) {
    missing(file, bond.node, "a bond has no " + in_quotes(key), file.place(bond.node), {},
            "the half-arrow of a bond points \"from\" one element \"to\" another");
    return std::nullopt;
  }
  if (!expect(file, value, JsonKind::string, in_quotes(key))) return std::nullopt;
  return bond_end_at(scope, value,
                     indices_put_in(file[value].text, bond.indices).value_or(std::string(file[value].text)));
}

/// "element", "element.port", or "submodel.port".
std::optional<BondEndText> Reader::bond_end_at(std::size_t scope, NodeId value, std::string_view text) {
  const Document& file = document(scopes_[scope]);
  const Place place = file.place(value);
  const auto dot = text.find('.');
  if (is_broken(scope, text.substr(0, dot))) return std::nullopt;
  if (dot != std::string_view::npos) return inner_bond_end(scope, value, text.substr(0, dot), text.substr(dot + 1));
  const auto found = names_.find(scopes_[scope].prefix + std::string(text));
  if (found == names_.end()) return no_element(scope, value, text);
  if (found->second.kind == Entity::Kind::instance) {
    lost_bonds_ = true;
    problem("BG131", in_quotes(text) + " is a submodel: a bond must name one of its ports", place,
            "write " + in_quotes(std::string(text) + ".port") + " with a name from \"ports\" in its file");
    return std::nullopt;
  }
  if (found->second.kind == Entity::Kind::repeated) return no_element(scope, value, text);
  if (found->second.kind != Entity::Kind::element) {
    lost_bonds_ = true;
    problem("BG130", in_quotes(text) + " is not an element", place, {}, "bonds join elements",
            {{found->second.place, "this is what has the name"}});
    return std::nullopt;
  }
  const ElementId element(found->second.index);
  if (is_field(model_.elements[element.index()].kind)) {
    std::vector<std::string> ports;
    for (const std::string& port : model_.elements[element.index()].ports)
      ports.push_back(std::string(text) + "." + port);
    meant_.insert(element.value);
    problem("BG131", in_quotes(text) + " has several ports: the bond must name one of them", place,
            "write " + list_of(ports));
    return std::nullopt;
  }
  return BondEndText{element, std::nullopt, place};
}

std::optional<BondEndText> Reader::inner_bond_end(std::size_t scope, NodeId value, std::string_view base,
                                                  std::string_view port) {
  const Document& file = document(scopes_[scope]);
  const Place place = file.place(value);
  const std::string full = scopes_[scope].prefix + std::string(base);
  const auto found = names_.find(full);
  if (found == names_.end()) return no_element(scope, value, base);
  const auto refuse_port = [&](const std::string& situation, const std::string& help) -> std::optional<BondEndText> {
    if (found->second.kind == Entity::Kind::element)
      meant_.insert(found->second.index);
    else
      lost_bonds_ = true;
    problem("BG131", situation, place, help);
    return std::nullopt;
  };
  if (found->second.kind == Entity::Kind::instance) {
    if (const auto inner = exports_.find(full + "." + std::string(port)); inner != exports_.end())
      return BondEndText{inner->second, std::nullopt, place};
    const Scope& inner = scopes_[found->second.index];
    if (broken_.contains(full + "." + std::string(port)) || unreadable(inner, "ports")) {
      lost_bonds_ = true;
      return std::nullopt;
    }
    std::vector<std::string> candidates;
    if (const NodeId ports = section(inner, "ports", JsonKind::object); ports.valid())
      for (const NodeId child : document(inner).children(ports))
        candidates.push_back(std::string(base) + "." + std::string(document(inner)[child].key));
    std::string help = suggestion(file[value].text, candidates);
    if (help.empty())
      help = candidates.empty() ? "list the junction under \"ports\" in " + in_quotes(document(inner).path())
                                : "it has " + list_of(candidates, " and ");
    return refuse_port("the submodel " + in_quotes(base) + " has no port " + in_quotes(port), help);
  }
  if (found->second.kind != Entity::Kind::element) return no_element(scope, value, base);
  const Element& element = model_.elements[found->second.index];
  if (is_junction(element.kind))
    return refuse_port(in_quotes(base) + " is a junction: it has as many bonds as it needs, but no named ports",
                       "write " + in_quotes(base));
  if (element.ports.size() < 2)
    return refuse_port(in_quotes(base) + " has one port only, without a name", "write " + in_quotes(base));
  const auto at = std::find(element.ports.begin(), element.ports.end(), port);
  if (at == element.ports.end())
    return refuse_port(in_quotes(base) + " has no port " + in_quotes(port),
                       "its ports are " + list_of(element.ports, " and "));
  return BondEndText{ElementId(found->second.index), static_cast<std::uint32_t>(at - element.ports.begin()), place};
}

std::optional<BondEndText> Reader::no_element(std::size_t scope, NodeId value, std::string_view base) {
  const Document& file = document(scopes_[scope]);
  if (const std::string advice = index_advice(scope, base); !advice.empty()) {
    lost_bonds_ = true;
    problem("BG130", "there is no element " + in_quotes(base) + " to bond to", file.place(value), advice,
            "a repeated element is named with its index");
    return std::nullopt;
  }
  std::vector<std::string> candidates;
  if (const NodeId elements = section(scopes_[scope], "elements", JsonKind::object);
      elements.valid() && !enough_problems())
    for (NodeId child = file[elements].first_child; child.valid() && candidates.size() < kMostSearched;
         child = file[child].next_sibling)
      candidates.emplace_back(file[child].key);
  const auto near = names_.find(scopes_[scope].prefix + nearest_name(std::string(base), candidates));
  if (near != names_.end() && near->second.kind == Entity::Kind::element)
    meant_.insert(near->second.index);
  else
    lost_bonds_ = true;
  if (unreadable(scopes_[scope], "elements")) return std::nullopt;
  std::string help = suggestion(base, candidates);
  if (help.empty() && !candidates.empty()) help = "the elements are " + list_of(candidates, " and ");
  problem("BG130", "there is no element " + in_quotes(base) + " to bond to", file.place(value), help,
          "a bond's ends are elements, written element or element.port");
  return std::nullopt;
}

}  // namespace bgsim
