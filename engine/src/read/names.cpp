#include <algorithm>
#include <array>

#include "expression/text_form.hpp"
#include "read/reader.hpp"

namespace bgsim {

/// Declares the model and, where its elements stand, the submodels; with a stack of its own, outermost scope first.
void Reader::declare_all() {
  struct Frame {
    std::size_t scope;
    bool begun = false;
    NodeId next{};  ///< the element to be declared next
  };
  std::vector<Frame> frames{{0}};
  while (!frames.empty()) {
    Frame& frame = frames.back();
    const std::size_t scope = frame.scope;
    if (!frame.begun) {
      frame.begun = true;
      unfolding_.push_back(scope);
      begin_scope(scope);
      const NodeId elements = section(scopes_[scope], "elements", JsonKind::object);
      const Document& file = document(scopes_[scope]);
      if (elements.valid()) frame.next = file[elements].first_child;
      if (elements.valid() && !frame.next.valid())
        problem("BG112", "the model has no elements", file.place(elements), "add at least one element");
    }
    if (const NodeId node = frame.next; node.valid()) {
      frame.next = document(scopes_[scope])[node].next_sibling;
      const std::size_t before = scopes_.size();
      declare_element(scope, node);
      const std::string full = scopes_[scope].prefix + std::string(document(scopes_[scope])[node].key);
      if (!names_.contains(full)) broken_.insert(full);
      // Submodels, the first on top; a scope of one copy's indices declares nothing.
      for (std::size_t inner = scopes_.size(); inner-- > before;)
        if (!scopes_[inner].copy_in) frames.push_back({inner});
      continue;
    }
    end_scope(scope);
    unfolding_.pop_back();
    frames.pop_back();
  }
}

void Reader::begin_scope(std::size_t scope) {
  check_root(scopes_[scope]);
  declare_quantities(scope, false);
  declare_quantities(scope, true);
  if (scopes_[scope].instance.valid()) apply_overrides(scope);
}

void Reader::end_scope(std::size_t scope) {
  declare_bonds(scope);
  declare_exports(scope);
}

bool Reader::claim(const std::string& full_name, const Entity& entity) {
  const auto [there, is_new] = names_.try_emplace(full_name, entity);
  if (is_new) return true;
  broken_.insert(full_name);
  const std::string name = full_name.substr(scopes_[unfolding_.back()].prefix.size());
  problem("BG116", "the name " + in_quotes(name) + " is used twice", entity.place, "rename one of the two",
          "parameters, signals, elements and bonds of a model share one namespace",
          {{there->second.place, "it is used here first"}});
  return false;
}

SymbolId Reader::add_symbol(ModelSymbol symbol) {
  model_.symbols.push_back(symbol);
  return SymbolId(model_.symbols.size() - 1);
}

/// What an object among the parameters or signals says: { value } or, among signals, { integral, initial }.
Reader::QuantityKeys Reader::quantity_keys(const Document& file, NodeId node, bool signal) {
  static constexpr std::array<std::string_view, 6> kKeys{"value", "unit", "about", "source", "integral", "initial"};
  const std::string what = signal ? "a signal" : "a parameter", name = in_quotes(file[node].key);
  check_keys(file, node, std::span(kKeys).first(signal ? 6 : 4), what);
  QuantityKeys keys{file.find(node, "value"), {}, Signal::Kind::value};
  if (!signal) return keys;
  const NodeId integral = file.find(node, "integral");
  keys.initial = file.find(node, "initial");
  if (keys.value.valid() && integral.valid())
    problem("BG112", "the signal " + name + " has both \"value\" and \"integral\"", file.key_place(integral),
            "keep one of them", "a signal is given by its value or by its rate");
  if (keys.value.valid() && keys.initial.valid())
    problem("BG111", "a signal with a \"value\" has no key \"initial\"", file.key_place(keys.initial),
            "leave it out, or write \"integral\" if the expression is the signal's rate");
  if (integral.valid()) keys = {integral, keys.initial, Signal::Kind::integral};
  return keys;
}

/// "parameters" or "signals": name -> value, or name -> { value, unit, about, source }.
void Reader::declare_quantities(std::size_t scope, bool signals) {
  const NodeId object = section(scopes_[scope], signals ? "signals" : "parameters", JsonKind::object);
  if (!object.valid()) return;
  const Document& file = document(scopes_[scope]);
  const std::string what = signals ? "a signal" : "a parameter";
  for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) {
    const std::string name(file[node].key);
    if (!valid_name(name, file.key_place(node), what)) {
      broken_.insert(scopes_[scope].prefix + name);
      continue;
    }
    if (signals && is_delay(file, node)) {
      declare_delay(scope, node);
      continue;
    }
    if (signals && is_memory(file, node)) {
      declare_memory(scope, node);
      continue;
    }
    QuantityKeys keys{node, {}, Signal::Kind::value};
    std::string unit, about;
    Place unit_place;
    if (file[node].kind == JsonKind::object) {
      keys = quantity_keys(file, node, signals);
      unit = text_of(file, node, "unit");
      if (!unit.empty()) unit_place = file.place(file.find(node, "unit"));
      about = text_of(file, node, "about");
      text_of(file, node, "source");
      if (!keys.value.valid())
        missing(
            file, node, what.substr(2) + " " + in_quotes(name) + " has no \"value\"", file.key_place(node),
            std::string("add \"value\": a number or an expression") + (signals ? ", or \"integral\": its rate" : ""));
    }
    const NodeId value = keys.value;
    if (signals && keys.kind == Signal::Kind::value && value.valid() && file[value].kind == JsonKind::string &&
        is_condition_text(file[value].text)) {
      if (!unit.empty())
        problem("BG113", "the signal " + in_quotes(name) + " is a condition and has no unit", unit_place,
                "leave it out");
      declare_condition(scope, node, value);
      continue;
    }
    const std::size_t index = signals ? model_.signals.size() : model_.parameters.size();
    const auto kind = signals ? Entity::Kind::signal : Entity::Kind::parameter;
    if (!claim(scopes_[scope].prefix + name, {kind, static_cast<std::uint32_t>(index), file.key_place(node)})) continue;
    ModelSymbol symbol;
    symbol.kind = signals ? ModelSymbol::Kind::signal : ModelSymbol::Kind::parameter;
    const Written written{static_cast<std::uint32_t>(scope), value};
    const Place place = value.valid() ? file.place(value) : file.key_place(node);
    if (signals) {
      symbol.signal = SignalId(index);
      signal_text_.push_back({written, {written.names, keys.initial}});
      model_.signals.push_back({scopes_[scope].prefix + name,
                                {},
                                add_symbol(symbol),
                                unit,
                                about,
                                place,
                                unit_place,
                                keys.kind,
                                {},
                                keys.initial.valid() ? file.place(keys.initial) : Place{},
                                {},
                                {},
                                {}});
    } else {
      parameter_text_.push_back(written);
      symbol.parameter = ParameterId(index);
      model_.parameters.push_back({scopes_[scope].prefix + name,
                                   {},
                                   add_symbol(symbol),
                                   unit,
                                   about,
                                   place,
                                   scopes_[scope].prefix,
                                   unit_place});
    }
  }
}

void Reader::declare_element(std::size_t scope, NodeId node) {
  const Document& file = document(scopes_[scope]);
  const std::string_view name = file[node].key;
  if (!valid_name(name, file.key_place(node), "an element")) return;
  if (!expect(file, node, JsonKind::object, "an element")) return;
  if (const NodeId repeat = file.find(node, "repeat"); repeat.valid() && !scopes_[scope].copy_in)
    return declare_copies(scope, node, repeat);
  const NodeId kind = file.find(node, "kind");
  if (!kind.valid())
    return missing(file, node, "the element " + in_quotes(name) + " has no \"kind\"", file.key_place(node),
                   "add \"kind\": \"R\", say");
  if (!expect(file, kind, JsonKind::string, "\"kind\"")) return;
  const auto written = written_kind(file[kind].text);
  if (!written) return declare_instance(scope, node, file[kind].text);

  const KindRow& row = *written->row;
  check_keys(file, node, row.keys, "an element of kind " + kind_text(row.kind, written->modulated), row.kind);
  Element element;
  element.name = scopes_[scope].prefix + std::string(name) + index_text(scopes_[scope].indices);
  element.kind = row.kind;
  element.modulated = written->modulated;
  element.place = file.key_place(node);
  element.about = text_of(file, node, "about");
  switch (row.ports) {
    case Ports::one:
      element.ports = {""};
      break;
    case Ports::two:
      element.ports = {"1", "2"};
      break;
    case Ports::named:
      if (!read_ports(scope, node, element)) return;
      break;
    case Ports::by_bond:
      break;
  }
  const bool junction = is_junction(element.kind);
  add_element(scope, node, std::move(element));
  if (junction && file.find(node, "on").valid()) declare_junction_switch(scope, node);
}

/// The named ports of a field. A field whose ports are at fault is declared all the same as long as it has some, so
/// that what refers to it is not reported, too.
bool Reader::read_ports(std::size_t scope, NodeId node, Element& element) {
  const Document& file = document(scopes_[scope]);
  const std::string name = in_quotes(file[node].key);
  const NodeId ports = file.find(node, "ports");
  const bool mixed = is_store(element.kind) && !kind_row(element.kind).variable;  // each port says what it holds
  const std::string example = mixed ? "{ \"a\": \"q\", \"b\": \"p\" }" : "[\"a\", \"b\"]";
  if (!ports.valid()) {
    missing(file, node, "the field " + name + " has no \"ports\"", element.place,
            "add \"ports\": " + example + ", two or more names of your choice");
    return false;
  }
  if (mixed && file[ports].kind == JsonKind::array) {
    problem("BG113", "\"ports\" of the field " + name + " does not say what each port holds", file.place(ports),
            "write \"ports\": " + example, "a port of an IC holds a displacement q or a momentum p");
    return false;
  }
  if (!expect(file, ports, mixed ? JsonKind::object : JsonKind::array, "\"ports\"")) return false;
  bool understood = true;  // else every variable of the port would be reported
  std::unordered_set<std::string_view> seen;
  for (NodeId port = file[ports].first_child; port.valid(); port = file[port].next_sibling) {
    if (!expect(file, port, JsonKind::string, mixed ? "what a port holds" : "a port's name")) continue;
    const std::string_view named = mixed ? file[port].key : file[port].text;
    if (!valid_name(named, mixed ? file.key_place(port) : file.place(port), "a port")) continue;
    if (mixed && file[port].text != "q" && file[port].text != "p") {
      understood = false;
      problem("BG113", "the port " + in_quotes(named) + " of " + name + " holds " + in_quotes(file[port].text),
              file.place(port), "write \"q\" or \"p\"", "a port of an IC holds a displacement q or a momentum p");
    }
    if (seen.insert(named).second) {
      element.ports.emplace_back(named);
      if (mixed) element.stored.push_back(file[port].text == "p" ? Variable::momentum : Variable::displacement);
    } else {
      problem("BG116", "the field " + name + " has two ports called " + in_quotes(named), file.place(port),
              "rename one of the two");
    }
  }
  if (file[ports].child_count < 2)
    problem("BG113", "the field " + name + " has fewer than two ports", file.place(ports),
            "an element with one port is of kind " + one_port_of(element.kind));
  return understood && element.ports.size() > 1;
}

/// What a contact counts: the integral of its flow.
void Reader::declare_displacement(std::size_t scope, Element& element) {
  const std::size_t index = model_.signals.size();
  const std::string name = element.name + ".q";
  element.contact.emplace();
  if (!claim(name, {Entity::Kind::signal, static_cast<std::uint32_t>(index), element.place})) return;
  ModelSymbol meaning;
  meaning.kind = ModelSymbol::Kind::signal;
  meaning.signal = SignalId(index);
  Signal signal;
  signal.name = name;
  signal.kind = Signal::Kind::integral;
  signal.symbol = add_symbol(meaning);
  signal.place = element.place;
  model_.signals.push_back(std::move(signal));
  signal_text_.push_back({{static_cast<std::uint32_t>(scope), {}}, {static_cast<std::uint32_t>(scope), {}}});
  element.contact->displacement = meaning.signal;
}

/// Every variable of an element has its symbol from the start, one after the other.
void Reader::add_element(std::size_t scope, NodeId node, Element element) {
  const auto index = static_cast<std::uint32_t>(model_.elements.size());
  if (!claim(element.name, {Entity::Kind::element, index, element.place})) return;
  if (is_contact(element.kind)) declare_displacement(scope, element);
  ModelSymbol symbol;
  symbol.kind = ModelSymbol::Kind::port_variable;
  symbol.element = ElementId(index);
  element.first_symbol = SymbolId(model_.symbols.size());
  if (const auto shared = shared_variable(element.kind)) {
    symbol.variable = *shared;
    add_symbol(symbol);
  }
  for (std::uint32_t port = 0; port < element.ports.size(); ++port) {
    symbol.port = port;
    for (const Variable variable : {Variable::effort, Variable::flow, Variable::displacement, Variable::momentum}) {
      if (!has_variable(element, port, variable)) continue;
      symbol.variable = variable;
      add_symbol(symbol);
    }
  }
  model_.elements.push_back(std::move(element));
  element_text_.push_back({static_cast<std::uint32_t>(scope), node});
}

}  // namespace bgsim
