#include <algorithm>
#include <array>

#include "base/codes.hpp"
#include "bgsim/modes.hpp"
#include "expression/text_form.hpp"
#include "read/reader.hpp"

namespace bgsim {

void Reader::parse_quantities() {
  for (std::size_t i = 0; i < model_.parameters.size(); ++i)
    if (const auto [names, value] = parameter_text_[i]; value.valid())
      model_.parameters[i].value = expression({names, nullptr, "a parameter"}, value, "a parameter");
  for (std::size_t i = 0; i < conditions_.size(); ++i) condition_named(i);
  for (std::size_t i = 0; i < signal_text_.size(); ++i) parse_signal(i);
  parse_memories();
  parse_delays();
}

void Reader::parse_signal(std::size_t index) {
  // What an expression says may declare a further signal: previous(u).
  const auto [value, initial] = signal_text_[index];
  if (value.value.valid()) {
    const ExprId parsed = expression({value.names, nullptr, nullptr}, value.value, "a signal");
    model_.signals[index].value = parsed;
  }
  if (initial.value.valid())
    model_.signals[index].initial =
        expression({initial.names, nullptr, "an initial value"}, initial.value, "an initial value");
}

void Reader::parse_element(std::size_t index) {
  if (junction_switches_.contains(index)) return parse_junction_switch(index);
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  if (const auto way = chosen_way(index)) {
    Element& element = model_.elements[index];
    const std::string_view key = file[*way].key;
    element.coefficient_place = file.place(*way);
    if (is_switch(element.kind) && !is_contact(element.kind)) {
      parse_switch(index, *way);
    } else if (key == "energy") {
      parse_energy(index, *way);
    } else if (key == "law") {
      if (expect(file, *way, JsonKind::string, "\"law\"")) parse_law(index, *way);
    } else if (key == "laws") {
      if (expect(file, *way, JsonKind::array, "\"laws\"")) parse_laws(index, *way);
    } else {
      element.coefficient = expression({scope, nullptr, nullptr}, *way, in_quotes(key));
    }
  }
  if (is_contact(model_.elements[index].kind)) return parse_contact(index);
  if (is_diode(model_.elements[index].kind)) parse_diode(index);
  if (!is_store(model_.elements[index].kind)) return;
  if (const NodeId initial = file.find(node, "initial"); initial.valid()) parse_initial(index, initial);
  if (const NodeId priority = file.find(node, "priority"); priority.valid()) parse_priority(index, priority);
}

/// An ideal switch: "closed" or "locked" with one condition, or "close" and "open" with one each.
void Reader::parse_switch(std::size_t index, NodeId way) {
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  const Context context{scope, nullptr, nullptr};
  Element& element = model_.elements[index];
  element.coefficient = model_.pool.constant(0.0);
  SwitchLaw law;
  const std::string_view key = file[way].key;
  const NodeId open = file.find(node, "open"), initial = file.find(node, "initial");
  if (key == "close") {
    law.remembers = true;
    if (!open.valid())
      return missing(file, node, "the switch " + in_quotes(file[node].key) + " has \"close\", but no \"open\"",
                     file.key_place(way), "add \"open\": the condition under which it opens again",
                     "a switch with hysteresis has a condition for either way");
    const ExprId close = condition(context, way, "\"close\"");
    law.opens = condition(context, open, "\"open\"");
    // Where both hold, the switch is open: otherwise it would change sides without end.
    if (close.valid() && law.opens.valid())
      law.closes = model_.pool.make(Op::logical_and, close, model_.pool.make(Op::logical_not, law.opens));
    law.closes_place = file.place(way);
    law.opens_place = file.place(open);
    if (initial.valid() && expect(file, initial, JsonKind::string, "the \"initial\" of a switch")) {
      const std::string_view side = file[initial].text;
      if (side != "open" && side != "closed")
        return problem("BG113", "a switch is \"open\" or \"closed\" at the start, not " + in_quotes(side),
                       file.place(initial), suggestion(side, {"open", "closed"}));
      if (side == "closed") set_closed(element, true);
    }
  } else {
    for (const NodeId other : {open, initial})
      if (other.valid())
        return problem(
            "BG112",
            "the switch " + in_quotes(file[node].key) + " has " + in_quotes(key) + " and " + in_quotes(file[other].key),
            file.key_place(other),
            "leave it out, or write \"close\" and \"open\": the conditions under which it changes sides",
            "one condition says at each instant which side the switch is on",
            {{file.key_place(way), "it is defined here first"}});
    const ExprId written = condition(context, way, in_quotes(key));
    if (!written.valid()) return;
    law.locks = key == "locked";
    law.closes = law.locks ? model_.pool.make(Op::logical_not, written) : written;
    law.opens = law.locks ? written : model_.pool.make(Op::logical_not, written);
    law.closes_place = law.opens_place = file.place(way);
  }
  if (law.closes.valid() && law.opens.valid()) element.switches = law;
}

/// An ideal diode; all that it has may be left out.
void Reader::parse_diode(std::size_t index) {
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  Element& element = model_.elements[index];
  element.coefficient = model_.pool.constant(0.0);
  element.diode.emplace();
  if (const NodeId passes = file.find(node, "passes");
      passes.valid() && expect(file, passes, JsonKind::string, "\"passes\"")) {
    const std::string_view way = file[passes].text;
    if (way != "in" && way != "out")
      return problem("BG113", "a diode passes \"in\" or \"out\", not " + in_quotes(way), file.place(passes),
                     suggestion(way, {"in", "out"}), "\"in\": it conducts what flows into the element");
    element.diode->out = way == "out";
  }
  if (const NodeId threshold = file.find(node, "threshold"); threshold.valid()) {
    element.coefficient_place = file.place(threshold);
    const ExprId value = expression({scope, nullptr, "a threshold"}, threshold, "\"threshold\"");
    if (value.valid()) element.coefficient = value;
  }
  element.diode->threshold = element.coefficient;
  if (const NodeId fire = file.find(node, "fire"); fire.valid()) {
    element.diode->fire = condition({scope, nullptr, nullptr}, fire, "\"fire\"");
    element.diode->fire_place = file.place(fire);
  }
}

/// A contact; its displacement has been declared as an integral.
void Reader::parse_contact(std::size_t index) {
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  ExprPool& pool = model_.pool;
  Element& element = model_.elements[index];
  const SymbolId flow = port_variable(element, 0, Variable::flow);
  ContactLaw& law = *element.contact;
  if (!law.displacement.valid()) return;
  Signal& displacement = model_.signals[law.displacement.index()];
  displacement.value = pool.symbol(flow);
  if (const NodeId initial = file.find(node, "initial");
      initial.valid() && expect(file, initial, JsonKind::object, "\"initial\""))
    for (NodeId at = file[initial].first_child; at.valid(); at = file[at].next_sibling) {
      if (file[at].key != "q") {
        problem("BG135", in_quotes(file[at].key) + " is not an initial value of this element", file.key_place(at),
                "write \"q\"", "a contact begins with a displacement q, which is at most its gap");
        continue;
      }
      displacement.initial = expression({scope, nullptr, "an initial value"}, at, "an initial value");
      displacement.initial_place = file.place(at);
    }
  element.diode.emplace();
  element.diode->out = true;
  element.diode->threshold = pool.constant(0.0);
  law.speed = element.coefficient.valid() ? pool.make(Op::der, element.coefficient) : pool.constant(0.0);
  law.restitution = pool.constant(0.0);
  const NodeId restitution = file.find(node, "restitution");
  if (!restitution.valid()) return;
  law.restitution_place = file.place(restitution);
  const ExprId value = expression({scope, &element, nullptr}, restitution, "\"restitution\"");
  if (!value.valid()) return;
  law.restitution = value;
  // One of parameters is looked at where a scene gives their values.
  if (const ExprNode& at = pool[value]; at.op == Op::constant && !(at.constant >= 0.0 && at.constant <= 1.0))
    return problem(
        "BG626", "the restitution of the contact " + in_quotes(element.name) + " is " + number_text(at.constant, 6),
        law.restitution_place, "1 keeps all energy, 0 none", "the speed after an impact is 0 to 1 times that before");
  for (const SymbolId id : symbols_in(pool, std::array{value}))
    if (id != flow && model_.symbols[id.index()].kind != ModelSymbol::Kind::parameter)
      return problem("BG118", "the restitution depends on " + symbol_name(model_, id), law.restitution_place,
                     "write it over f, the closing speed",
                     "the restitution is a number, or an expression of parameters and f");
}

/// The one key that says what the element does.
std::optional<NodeId> Reader::chosen_way(std::size_t index) {
  const auto [scope, node] = element_text_[index];
  const Document& file = document(scopes_[scope]);
  const KindRow& row = kind_row(model_.elements[index].kind);
  if (row.ways.empty()) return std::nullopt;
  std::optional<NodeId> chosen;
  const auto wanted = [&] { return list_of({row.ways.begin(), row.ways.end()}); };
  for (const std::string_view way : row.ways) {
    const NodeId value = file.find(node, way);
    if (!value.valid()) continue;
    if (chosen) {
      problem("BG112", "the element " + in_quotes(file[node].key) + " defines its law twice", file.key_place(value),
              "keep one of " + wanted(), "an element has one law",
              {{file.key_place(*chosen), "it is defined here first"}});
      return std::nullopt;
    }
    chosen = value;
  }
  if (!chosen)
    missing(file, node, "the element " + in_quotes(file[node].key) + " has no " + wanted(), file.key_place(node),
            "define this " + std::string(row.text), "physical values have no defaults");
  return chosen;
}

void Reader::parse_energy(std::size_t index, NodeId value) {
  const std::size_t scope = element_text_[index].names;
  const ExprId energy = expression({scope, &model_.elements[index], nullptr}, value, "\"energy\"");
  if (!energy.valid()) return;
  for (const ExprId e : reachable(model_.pool, std::array{energy}))
    if (model_.pool[e].op == Op::der)
      return problem("BG117", "the energy contains a time derivative", document(scopes_[scope]).place(value),
                     "a part that depends on a rate dissipates and belongs in a separate R or RR; a rate from "
                     "elsewhere is a signal",
                     "the energy of a field is a function of what its ports hold, of parameters, t and signals");
  model_.elements[index].energy = energy;
  for (const SymbolId id : symbols_in(model_.pool, std::vector{energy})) {
    const ModelSymbol& symbol = model_.symbols[id.index()];
    const bool own = symbol.kind == ModelSymbol::Kind::port_variable && symbol.element == ElementId(index);
    const Element& field = model_.elements[index];
    if (!own || symbol.variable == stored_variable(field, symbol.port)) continue;
    const char* stored = !field.stored.empty()           ? "displacements q and momenta p"
                         : stores_displacement(field, 0) ? "displacements q"
                                                         : "momenta p";
    return problem("BG117", "the energy depends on the field's own " + symbol_name(model_, id),
                   document(scopes_[scope]).place(value), std::string("write it over the ports' ") + stored,
                   std::string("the energy of a field is a function of its ports' ") + stored);
  }
}

/// One law for each port of a field.
void Reader::parse_laws(std::size_t index, NodeId value) {
  const std::size_t scope = element_text_[index].names;
  const Document& file = document(scopes_[scope]);
  bool complete = true;  // each law is understood and for a port of its own
  for (NodeId law = file[value].first_child; law.valid(); law = file[law].next_sibling) {
    const std::size_t before = model_.elements[index].laws.size();
    if (expect(file, law, JsonKind::string, "a law")) parse_law(index, law);
    complete = complete && model_.elements[index].laws.size() > before;
  }
  const Element& element = model_.elements[index];
  std::vector<const Law*> law_of_port(element.ports.size(), nullptr);
  for (const Law& law : element.laws) {
    if (law_of_port[law.port] != nullptr) {
      complete = false;
      problem("BG117", "the port " + in_quotes(element.ports[law.port]) + " has two laws", law.place,
              "leave one out, or write it for another port", "a field has one law for each port",
              {{law_of_port[law.port]->place, "this is the first"}});
    }
    law_of_port[law.port] = &law;
  }
  for (std::size_t port = 0; complete && port < law_of_port.size(); ++port)
    if (law_of_port[port] == nullptr)
      problem("BG117", "the port " + in_quotes(element.ports[port]) + " has no law", file.key_place(value),
              "add a law " + in_quotes(element.ports[port] + "." + law_letters(element, port)[0] + " = ..."),
              "a field has one law for each port");
}

void Reader::parse_law(std::size_t index, NodeId value) {
  const std::size_t scope = element_text_[index].names;
  const Document& file = document(scopes_[scope]);
  LawText parts;
  try {
    parts = split_law(file[value].text);
  } catch (const ExpressionError& error) {
    const bool none = std::string_view(error.what()).ends_with("none");
    return problem(error.code.c_str(), error.what(), file.place_in_string(value, error.begin, error.end),
                   none ? law_without_equals(model_.elements[index], file[value].text) : error.help);
  }
  const Context context{scope, &model_.elements[index], nullptr};
  const ExprId left = parse(context, value, parts.left, parts.left_begin);
  const ExprId right = parse(context, value, parts.right, parts.right_begin);
  if (!left.valid() || !right.valid()) return;
  const Element& element = model_.elements[index];
  const auto own = [&](SymbolId id) -> const ModelSymbol* {
    const ModelSymbol& symbol = model_.symbols[id.index()];
    return symbol.kind == ModelSymbol::Kind::port_variable && symbol.element == ElementId(index) ? &symbol : nullptr;
  };
  const bool zero = model_.pool.is_constant(left, 0.0) && is_resistor(element.kind) && !is_field(element.kind);
  const ModelSymbol* variable = model_.pool.is_symbol(left) ? own(model_.pool.symbol_of(left)) : nullptr;
  const std::uint32_t number = variable != nullptr && is_field(element.kind) ? variable->port : 0;
  const std::string port = is_field(element.kind) ? element.ports[number] + "." : "";
  if (!zero && (variable == nullptr || !law_relates(element, variable->port, variable->variable)))
    return problem("BG117",
                   "the left side of this law is not " +
                       (variable != nullptr ? law_letters(element, number) : law_letters(element)) + " alone",
                   file.place_in_string(value, parts.left_begin, parts.left_begin + parts.left.size()),
                   "solve it for one of them: " + in_quotes(port + law_letters(element, number)[0] + " = ..."),
                   "a law has one variable of its element alone on the left");
  const Place right_place = file.place_in_string(value, parts.right_begin, parts.right_begin + parts.right.size());
  bool occurs = false;
  for (const SymbolId id : symbols_in(model_.pool, std::vector{right})) {
    const ModelSymbol* other = own(id);
    if (other == nullptr) continue;
    occurs = true;
    if (!zero && id == model_.pool.symbol_of(left))
      return problem("BG117", symbol_name(model_, id) + " is on both sides of this law", right_place,
                     "solve the law for it", "a law has one variable of its element alone on the left");
    if (!law_relates(element, other->port, other->variable))
      return problem("BG117", "this law contains the element's own " + symbol_name(model_, id), right_place,
                     "put the dissipation into a separate R",
                     "the law of " +
                         (element.stored.empty() ? kind_text(element.kind, element.modulated)
                                                 : "the port " + in_quotes(element.ports[other->port])) +
                         " relates " + law_letters(element, other->port)[0] + " and " +
                         law_letters(element, other->port)[5]);
  }
  if (!is_store(element.kind))
    for (const ExprId e : reachable(model_.pool, std::array{right})) {
      if (model_.pool[e].op != Op::der) continue;
      for (const SymbolId id : symbols_in(model_.pool, std::array{e}))
        if (own(id) != nullptr)
          return problem("BG117", "this law contains the rate of the element's own " + symbol_name(model_, id),
                         right_place, "what follows the rate of a flow is an I, of an effort a C",
                         "the law of a resistor relates effort and flow of one instant; what it takes in is lost");
    }
  if (zero && !occurs)
    return problem("BG117", "this law contains neither e nor f of its element", right_place,
                   "write the equation that relates them: \"0 = e - R*f\"", "the law of a resistor relates e and f");
  warn_of_euler(index, right, right_place);
  if (zero)
    model_.elements[index].laws.push_back({0, Variable::effort, right, file.place(value), true});
  else
    model_.elements[index].laws.push_back({variable->port, variable->variable, right, file.place(value)});
}

/// e^(-t/T) in a law is a power of the effort e, and is unlikely to be meant so.
void Reader::warn_of_euler(std::size_t index, ExprId right, const Place& place) {
  const Element& element = model_.elements[index];
  if (is_field(element.kind)) return;
  const ExprId effort = model_.pool.symbol(port_variable(element, 0, Variable::effort));
  for (const ExprId e : reachable(model_.pool, std::array{right})) {
    const ExprNode& node = model_.pool[e];
    if (node.op != Op::pow || ExprId(node.a) != effort) continue;
    const auto symbols = symbols_in(model_.pool, std::array{ExprId(node.b)});
    if (std::all_of(symbols.begin(), symbols.end(),
                    [this](SymbolId s) { return model_.symbols[s.index()].kind == ModelSymbol::Kind::parameter; }))
      continue;
    model_.warnings.push_back(
        diagnostic_of("BG182", "in this law e^(...) is a power of the effort e of " + in_quotes(element.name), place,
                      "in a law e is the element's own effort; Euler's number is exp(1)", "write exp(x) for e^x"));
    return;
  }
}

void Reader::parse_initial(std::size_t index, NodeId value) {
  const std::size_t scope = element_text_[index].names;
  const Document& file = document(scopes_[scope]);
  if (!expect(file, value, JsonKind::object, "\"initial\"")) return;
  const Element& element = model_.elements[index];
  const std::vector<std::string>& ports = element.ports;
  std::unordered_map<std::uint32_t, Place> given;  // by port
  for (NodeId node = file[value].first_child; node.valid(); node = file[node].next_sibling) {
    const std::string_view key = file[node].key;
    const auto named = [&](Variable (*variable)(const Element&, std::size_t)) -> std::optional<std::uint32_t> {
      for (std::uint32_t port = 0; port < ports.size(); ++port)
        if (key == (ports[port].empty() ? "" : ports[port] + ".") + letter(variable(element, port))) return port;
      return std::nullopt;
    };
    const bool conjugate = !named(stored_variable);
    const auto at = named(conjugate ? conjugate_variable : stored_variable);
    if (!at) {
      problem(
          "BG135", in_quotes(key) + " is not an initial value of this element", file.key_place(node),
          initial_advice(element, key, {}),
          "an initial value is what is stored, q of C and CC, p of I and II, either of IC; or e or f, which determine "
          "it");
      continue;
    }
    const std::uint32_t port = *at;
    if (const auto [first, is_new] = given.emplace(port, file.key_place(node)); !is_new) {
      problem("BG184", "two initial values are given for one store", file.key_place(node), "keep one of them",
              std::string("the ") + letter(stored_variable(element, port)) + " of a store and its " +
                  letter(conjugate_variable(element, port)) + " follow from each other by its law",
              {{first->second, "this is the other one"}});
      continue;
    }
    const ExprId start = expression({scope, nullptr, "an initial value"}, node, "an initial value");
    if (start.valid()) model_.elements[index].initial.push_back({port, start, file.place(node), conjugate});
  }
}

void Reader::parse_priority(std::size_t index, NodeId value) {
  const Document& file = document(scopes_[element_text_[index].names]);
  if (expect(file, value, JsonKind::number, "\"priority\"")) model_.elements[index].priority = file[value].number;
}

/// Outputs of submodels are not taken over: they are for running the submodel by itself.
void Reader::parse_outputs(std::size_t scope) {
  static constexpr std::array<std::string_view, 3> kKeys{"value", "unit", "about"};
  const NodeId object = section(scopes_[scope], "outputs", JsonKind::object);
  if (!object.valid()) return;
  const Document& file = document(scopes_[scope]);
  for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) {
    Output output;
    output.name = file[node].key;
    output.place = file.key_place(node);
    if (output.name.empty() || output.name == "t") {
      problem("BG115", in_quotes(output.name) + " cannot be the name of an output", output.place, "choose another name",
              "the columns of a trace have names, and the first one is t");
      continue;
    }
    if (const auto there = outputs_.find(output.name); there != outputs_.end()) {
      problem("BG116", "there is an output " + in_quotes(output.name) + " already", output.place,
              "choose another name for the column", "the columns of a trace have different names",
              {{model_.outputs[there->second].place, "it is declared here"}});
      continue;
    }
    NodeId value = node;
    if (file[node].kind == JsonKind::object) {
      check_keys(file, node, kKeys, "an output");
      output.unit = text_of(file, node, "unit");
      if (!output.unit.empty()) output.unit_place = file.place(file.find(node, "unit"));
      text_of(file, node, "about");
      value = file.find(node, "value");
      if (!value.valid())
        missing(file, node, "the output " + in_quotes(output.name) + " has no \"value\"", output.place,
                "add \"value\": an expression");
    }
    if (value.valid()) output.value = expression({scope, nullptr, nullptr}, value, "an output");
    outputs_.emplace(output.name, model_.outputs.size());
    model_.outputs.push_back(std::move(output));
  }
}

}  // namespace bgsim
