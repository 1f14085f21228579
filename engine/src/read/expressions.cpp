#include <algorithm>
#include <array>

#include "expression/partial.hpp"
#include "read/reader.hpp"

namespace bgsim {

ExprId Reader::expression(const Context& context, NodeId value, const std::string& what) {
  const Document& file = document(scopes_[context.scope]);
  if (file[value].kind == JsonKind::number) return model_.pool.constant(file[value].number);
  if (file[value].kind == JsonKind::string) return parse(context, value, file[value].text, 0);
  const bool unit = file[value].kind == JsonKind::object && file.find(value, "value").valid();
  problem("BG113", what + " must be a number or an expression, not " + json_kind_name(file[value].kind),
          file.place(value),
          unit ? "units belong to parameters: declare one with this value and unit, and write its name here"
          : file[value].kind == JsonKind::array ? "write one value; several values have separate names"
                                                : "");
  return {};
}

/// A condition such as "x > 1 and t < T", which is no number.
ExprId Reader::condition(const Context& context, NodeId value, const std::string& what) {
  const Document& file = document(scopes_[context.scope]);
  if (file[value].kind == JsonKind::string) return parse(context, value, file[value].text, 0, parse_condition);
  problem("BG113", what + " must be a condition in quotes, not " + json_kind_name(file[value].kind), file.place(value),
          "write a comparison: \"t >= 0.1\", \"cap.e > 5 and t > T\"; one that always holds is \"t > t - 1\"");
  return {};
}

/// Parses a part of a text that begins at byte @p offset of it.
ExprId Reader::parse(const Context& context, NodeId value, std::string_view text, std::size_t offset,
                     Parse parse_text) {
  ExpressionScope scope;
  scope.time = model_.time;
  scope.after_event = context.after_event;
  scope.previous = [&](ExprId x) { return previous(x); };
  scope.mode = [&](std::string_view name) { return mode_named(context, name); };
  scope.known_modes = [&] { return mode_names(context); };
  scope.name = [&](std::string_view name) { return meaning(context, name); };
  scope.known_names = [&] { return known_names(context); };
  scope.table = [&](std::string_view path, std::string_view column, Interpolation interpolation) {
    return load_table(scopes_[context.scope], text, path, column, interpolation);
  };
  scope.leaves_out = [&](std::size_t begin, std::size_t end, ExprId kept, ExprId lost) {
    warn_of_left_out(document(scopes_[context.scope]).place_in_string(value, offset + begin, offset + end), kept, lost);
  };
  refusal_.reset();
  try {
    const ExprId result = parse_text(text, model_.pool, scope);
    return context.constant == nullptr || only_parameters(context, value, result) ? result : ExprId{};
  } catch (const ExpressionError& error) {
    expression_fault(context, value, text, offset, error);
    return {};
  }
}

/// A part without a say in the result, as in 0*log(x), is not evaluated: nothing is said where it has no value.
void Reader::warn_of_left_out(const Place& place, ExprId kept, ExprId lost) {
  const auto name = [this](SymbolId symbol) { return symbol_name(model_, symbol); };
  model_.warnings.push_back(diagnostic_of("BG128", left_out_words(model_.pool, kept, lost, name), place,
                                          "what cancels, or is multiplied by 0, is not evaluated",
                                          "write what is meant without " + to_text(model_.pool, lost, name)));
}

/// Whether a name's owner is at fault itself, which has been reported.
bool Reader::is_broken(std::size_t scope, std::string_view name) const {
  // "left", "left.cell" and "left.cell[3]" of "left.cell[3].x"
  for (auto end = name.find_first_of(".["); end != std::string_view::npos; end = name.find_first_of(".[", end + 1))
    if (broken_.contains(scopes_[scope].prefix + std::string(name.substr(0, end)))) return true;
  return broken_.contains(scopes_[scope].prefix + std::string(name));
}

/// Constants know parameters (other names are refused one by one) but neither t nor der.
bool Reader::only_parameters(const Context& context, NodeId value, ExprId expression) {
  for (const ExprId id : reachable(model_.pool, std::array{expression})) {
    const bool time = model_.pool.is_symbol(id) && model_.pool.symbol_of(id) == model_.time;
    if (!time && model_.pool[id].op != Op::der) continue;
    problem("BG118", std::string(time ? "t" : "der") + " cannot be used in " + context.constant,
            document(scopes_[context.scope]).place(value),
            std::string_view(context.constant) == "a parameter" ? "what varies is declared among \"signals\"" : "",
            std::string(context.constant) + " is computed from numbers and parameters only");
    return false;
  }
  return true;
}

/// Whether a name that is not known may have been declared where the file cannot be read, which is reported.
bool Reader::perhaps_declared(std::size_t scope, std::string_view name) const {
  // What the command line and files of parameters say uses the names of the top model.
  const Scope& declares = scopes_[scope].prefix.empty() ? scopes_[0] : scopes_[scope];
  const auto lost = [&](std::string_view key) { return unreadable(declares, key); };
  if (name.find('.') == std::string_view::npos) return lost("parameters") || lost("signals");
  return lost("elements") || lost("bonds") || lost("types");
}

std::nullopt_t Reader::refuse(const char* code, std::string situation, std::string help, std::vector<Note> notes) {
  refusal_ = Refusal{code, std::move(situation), std::move(help), std::move(notes)};
  return std::nullopt;
}

std::optional<ExprId> Reader::meaning(const Context& context, std::string_view name) {
  const IndexValues& indices = scopes_[context.scope].indices;
  const std::size_t index = name.size() == 1 ? kIndexNames.find(name[0]) : std::string_view::npos;
  if (index != std::string_view::npos && indices.used[index]) {
    const auto other = names_.find(scopes_[context.scope].prefix + std::string(name));
    if (other == names_.end()) return model_.pool.constant(static_cast<double>(indices.value[index]));
    return refuse("BG116",
                  in_quotes(name) + " is ambiguous here: it is the index of what is repeated, and a name of the model",
                  "give the other one another name", {{other->second.place, "it is declared here"}});
  }
  if (name.find('[') == std::string_view::npos) return meaning_of_plain(context, name);
  const auto numbered = with_indices(context, name);
  return numbered ? meaning_of_plain(context, *numbered) : std::nullopt;
}

/// Of a name that has numbers for indices.
std::optional<ExprId> Reader::meaning_of_plain(const Context& context, std::string_view name) {
  if (context.own != nullptr) {
    if (const auto own = own_variable(context, name)) return own;
    if (refusal_) return std::nullopt;
  }
  const std::string& prefix = scopes_[context.scope].prefix;
  const auto found = names_.find(prefix + std::string(name));
  const bool is_quantity = found != names_.end() && (found->second.kind == Entity::Kind::parameter ||
                                                     found->second.kind == Entity::Kind::signal ||
                                                     found->second.kind == Entity::Kind::condition);
  // A column of the command line may be made of outputs, which may have the names of elements.
  if (context.scope == command_line_scope_ && !is_quantity)
    if (const auto output = outputs_.find(std::string(name));
        output != outputs_.end() && model_.outputs[output->second].value.valid())
      return model_.outputs[output->second].value;
  if (found != names_.end()) return quantity(context, found->second, name);
  const auto dot = name.rfind('.');
  std::optional<SymbolId> variable;
  if (dot != std::string_view::npos && name.size() == dot + 2)
    variable = variable_of(context.scope, name.substr(0, dot), name[dot + 1]);
  if (!variable) {
    if (refusal_) return std::nullopt;
    const std::string advice = index_advice(context.scope, name);
    return advice.empty() ? std::nullopt : refuse("BG121", "there is no " + in_quotes(name), advice);
  }
  if (context.constant != nullptr)
    return refuse("BG118", in_quotes(name) + " cannot be used in " + context.constant + ": it varies",
                  std::string(context.constant) + " is computed from numbers and parameters only");
  return model_.pool.symbol(*variable);
}

/// A name without a dot: a parameter or a signal.
std::optional<ExprId> Reader::quantity(const Context& context, const Entity& entity, std::string_view name) {
  switch (entity.kind) {
    case Entity::Kind::parameter:
      return model_.pool.symbol(model_.parameters[entity.index].symbol);
    case Entity::Kind::signal:
      if (context.constant == nullptr) return model_.pool.symbol(model_.signals[entity.index].symbol);
      return refuse("BG118", "the signal " + in_quotes(name) + " cannot be used in " + context.constant,
                    std::string(context.constant) + " is computed from numbers and parameters only");
    case Entity::Kind::condition:
      if (context.constant == nullptr) return condition_named(entity.index);
      return refuse("BG118", "the signal " + in_quotes(name) + " cannot be used in " + context.constant,
                    std::string(context.constant) + " is computed from numbers and parameters only");
    case Entity::Kind::element: {
      const Element& element = model_.elements[entity.index];
      if (kind_row(element.kind).variable == Variable::flow)
        return refuse("BG121", in_quotes(name) + " is an element, no quantity",
                      "write " + in_quotes(std::string(name) + ".f"));
      const std::string port = element.ports.size() > 1 ? "." + element.ports[0] : "";
      return refuse("BG121", in_quotes(name) + " is an element, no quantity",
                    "write one of its variables, such as " + in_quotes(std::string(name) + port + ".e"));
    }
    case Entity::Kind::bond:
      return refuse("BG121", in_quotes(name) + " is a bond, no quantity",
                    "write its effort " + in_quotes(std::string(name) + ".e") + " or its flow " +
                        in_quotes(std::string(name) + ".f"));
    case Entity::Kind::repeated:
      return refuse("BG121", in_quotes(name) + " is repeated, no quantity", index_advice(context.scope, name));
    case Entity::Kind::instance:
      return refuse("BG121", in_quotes(name) + " is a submodel, no quantity",
                    "write what is inside it, such as " + in_quotes(std::string(name) + ".mass.p"));
  }
  return std::nullopt;
}

/// Inside a law or an energy: bare e, f, q, p of a one-port, port.e ... of a field.
std::optional<ExprId> Reader::own_variable(const Context& context, std::string_view name) {
  const Element& own = *context.own;
  std::size_t port = 0;
  std::string_view letter = name;
  if (is_field(own.kind)) {
    const auto dot = name.find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    const auto at = std::find(own.ports.begin(), own.ports.end(), name.substr(0, dot));
    if (at == own.ports.end()) return std::nullopt;
    port = static_cast<std::size_t>(at - own.ports.begin());
    letter = name.substr(dot + 1);
  }
  const auto variable = letter.size() == 1 ? variable_from(letter[0]) : std::nullopt;
  if (!variable || !has_variable(own, port, *variable)) return std::nullopt;
  if (is_contact(own.kind) && *variable != Variable::flow) return std::nullopt;  // a restitution is over f alone
  // An element or a bond of that name is no quantity: in a law the letter alone can only mean the variable.
  const auto other = names_.find(scopes_[context.scope].prefix + std::string(name));
  if (!is_field(own.kind) && other != names_.end() &&
      (other->second.kind == Entity::Kind::parameter || other->second.kind == Entity::Kind::signal)) {
    const char* what = other->second.kind == Entity::Kind::parameter ? "parameter" : "signal";
    const std::string own_name = own.name.substr(scopes_[context.scope].prefix.size());
    return refuse("BG116",
                  in_quotes(name) + " is ambiguous in this law: it is a variable of " + in_quotes(own_name) +
                      " and a " + what + " of the model",
                  "give the " + std::string(what) + " " + in_quotes(name) + " another name",
                  {{other->second.place, "the " + std::string(what) + " " + in_quotes(name) + " is declared here"}});
  }
  return model_.pool.symbol(port_variable(own, port, *variable));
}

/// `base.letter` for an element, an element's port, a junction, a submodel's port or a bond.
std::optional<SymbolId> Reader::variable_of(std::size_t scope, std::string_view base, char letter) {
  const auto variable = variable_from(letter);
  if (!variable) return std::nullopt;
  const std::string name(base), full = scopes_[scope].prefix + name;
  auto found = names_.find(full);
  std::optional<std::size_t> port;
  if (found == names_.end()) {
    const auto dot = full.rfind('.');
    if (const auto outer = exports_.find(full); outer != exports_.end()) {
      found = names_.find(model_.elements[outer->second.index()].name);
    } else if (dot != std::string::npos) {
      found = names_.find(full.substr(0, dot));
      if (found == names_.end() || found->second.kind != Entity::Kind::element) return std::nullopt;
      const Element& element = model_.elements[found->second.index];
      const auto at = std::find(element.ports.begin(), element.ports.end(), full.substr(dot + 1));
      const std::string owner = name.substr(0, name.rfind('.'));
      if (element.ports.size() < 2)
        return refuse("BG121", in_quotes(owner) + " has no named ports", "write " + in_quotes(owner + "." + letter));
      if (at == element.ports.end())
        return refuse("BG121", in_quotes(owner) + " has no port " + in_quotes(full.substr(dot + 1)),
                      "its ports are " + list_of(element.ports, " and "));
      port = static_cast<std::size_t>(at - element.ports.begin());
    }
    if (found == names_.end()) return std::nullopt;
  }
  if (found->second.kind == Entity::Kind::bond) {
    if (*variable == Variable::effort || *variable == Variable::flow)
      return bond_symbol(BondId(found->second.index), *variable);
    return refuse("BG121", "a bond has no ." + std::string(1, letter),
                  "a bond has an effort " + in_quotes(name + ".e") + " and a flow " + in_quotes(name + ".f"));
  }
  if (found->second.kind != Entity::Kind::element) return std::nullopt;
  const Element& element = model_.elements[found->second.index];
  if (const auto shared = shared_variable(element.kind)) {
    const bool zero = *shared == Variable::effort;
    if (*variable == *shared) return element.first_symbol;
    const std::string kind = zero ? "0-junction" : "1-junction";
    return refuse("BG121", in_quotes(name) + " is a " + kind + " and has no ." + std::string(1, letter),
                  "the bonds of a " + kind + " share their " + (zero ? "effort " : "flow ") +
                      in_quotes(name + (zero ? ".e" : ".f")) + " only; for another variable name a bond");
  }
  if (!has_variable(element, port.value_or(0), *variable) && (port || element.stored.empty())) {
    std::vector<std::string> has;
    for (const char other : {'e', 'f', 'q', 'p'})
      if (has_variable(element, port.value_or(0), *variable_from(other))) has.emplace_back(1, other);
    return refuse("BG121",
                  (element.stored.empty() ? "an element of kind " + kind_text(element.kind, element.modulated)
                                          : "the port " + in_quotes(name)) +
                      " has no ." + std::string(1, letter),
                  "its variables are " + list_of(has, " and ") +
                      (is_store(element.kind) && *variable == Variable::displacement && element.stored.empty()
                           ? "; the displacement of a mass is the \"integral\" of its flow, a signal"
                           : ""));
  }
  if (element.ports.size() > 1 && !port)
    return refuse("BG121", in_quotes(name) + " has several ports: say which one is meant",
                  "write " + in_quotes(name + "." + element.ports[0] + "." + letter) + ", say");
  return port_variable(element, port.value_or(0), *variable);
}

/// The symbol of a stored quantity or an integral by its full name, as scenes name it; @p or_conjugate: or of the
/// effort of a C or the flow of an I, from which it follows.
std::optional<SymbolId> Reader::state_named(std::string_view name, bool or_conjugate) {
  if (const auto found = names_.find(std::string(name));
      found != names_.end() && found->second.kind == Entity::Kind::signal) {
    const Signal& signal = model_.signals[found->second.index];
    return signal.is_state() ? std::optional(signal.symbol) : std::nullopt;
  }
  const auto dot = name.rfind('.');
  if (dot == std::string_view::npos || dot + 2 != name.size()) return std::nullopt;
  const auto symbol = variable_of(0, name.substr(0, dot), name[dot + 1]);
  if (!symbol) return std::nullopt;
  const ModelSymbol& meaning = model_.symbols[symbol->index()];
  if (meaning.kind != ModelSymbol::Kind::port_variable) return std::nullopt;
  const Element& element = model_.elements[meaning.element.index()];
  if (!is_store(element.kind)) return std::nullopt;
  const bool stored = meaning.variable == stored_variable(element, meaning.port);
  const bool conjugate = law_relates(element, meaning.port, meaning.variable);
  return stored || (or_conjugate && conjugate) ? symbol : std::nullopt;
}

SymbolId Reader::bond_symbol(BondId bond, Variable variable) {
  const std::uint64_t key = (std::uint64_t{bond.value} << 1U) | (variable == Variable::flow ? 1U : 0U);
  const auto known = bond_symbols_.find(key);
  if (known != bond_symbols_.end()) return known->second;
  ModelSymbol symbol;
  symbol.kind = ModelSymbol::Kind::bond_variable;
  symbol.bond = bond;
  symbol.variable = variable;
  return bond_symbols_[key] = add_symbol(symbol);
}

/// What a suggestion may come from.
std::vector<std::string> Reader::known_names(const Context& context) const {
  std::vector<std::string> result;
  if (enough_problems()) return result;
  const std::string& prefix = scopes_[context.scope].prefix;
  const auto add = [&](const std::string& name) {
    if (name.compare(0, prefix.size(), prefix) == 0) result.push_back(name.substr(prefix.size()));
  };
  for (const Parameter& parameter : model_.parameters) {
    add(parameter.name);
    if (result.size() > kMostSearched) break;
  }
  if (context.constant != nullptr) return result;
  for (const Signal& signal : model_.signals) {
    add(signal.name);
    if (result.size() > kMostSearched) break;
  }
  for (const auto& [name, entity] : names_)
    if (entity.kind == Entity::Kind::condition) add(name);
  for (std::size_t i = 0; context.scope == command_line_scope_ && i < model_.outputs.size(); ++i)
    result.push_back(model_.outputs[i].name);
  for (std::size_t i = 1; i < model_.symbols.size() && result.size() < kMostSearched; ++i)
    if (model_.symbols[i].kind == ModelSymbol::Kind::port_variable) add(symbol_name(model_, SymbolId(i)));
  for (std::size_t i = 0; i < model_.bonds.size() && result.size() < kMostSearched; ++i)
    for (const char* letter : {".e", ".f"}) add(model_.bonds[i].name + letter);
  for (std::size_t port = 0; context.own != nullptr && port < context.own->ports.size(); ++port)
    for (const char letter : {'e', 'f', 'q', 'p'})
      if (has_variable(*context.own, port, *variable_from(letter)))
        result.push_back((is_field(context.own->kind) ? context.own->ports[port] + "." : "") + letter);
  return result;
}

}  // namespace bgsim
