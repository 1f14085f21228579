// The help of messages about expressions, where the place tells more than the expression itself.
#include <algorithm>
#include <cctype>

#include "expression/value_unit.hpp"
#include "read/reader.hpp"
#include "read/variable_words.hpp"

namespace bgsim {
namespace {

std::string with_words(Variable variable) {
  return in_quotes(std::string(1, letter(variable))) + " for the " + variable_words(variable);
}

/// The variables that a port of an element has, each with what it is: the law's two, or all.
std::vector<Variable> variables_of(const Element& element, std::size_t port, bool law) {
  std::vector<Variable> all;
  for (const Variable variable : {Variable::effort, Variable::flow, Variable::displacement, Variable::momentum})
    if (law ? law_relates(element, port, variable) : has_variable(element, port, variable)) all.push_back(variable);
  return all;
}

/// What a port of a store holds; none of other elements.
std::optional<Variable> stored_at(const Element& element, std::size_t port) {
  return is_store(element.kind) ? std::optional(stored_variable(element, port)) : std::nullopt;
}

bool is_json_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.eE+-") == std::string::npos && text[0] != '.' &&
         text[0] != '+' && text.back() != '.';
}

}  // namespace

void Reader::expression_fault(const Context& context, NodeId value, std::string_view text, std::size_t offset,
                              const ExpressionError& error) {
  const std::string situation = error.what();
  const bool refused = refusal_ && error.code == "BG121" &&
                       (situation.starts_with("unknown name") || situation.starts_with("there is no switch"));
  const std::string_view name = text.substr(error.begin, error.end - error.begin);
  if (error.code == "BG121" && !refused && (is_broken(context.scope, name) || perhaps_declared(context.scope, name)))
    return;
  const Place place = document(scopes_[context.scope]).place_in_string(value, offset + error.begin, offset + error.end);
  if (refused && refusal_->code == "BG116" &&
      !ambiguous_.insert(scopes_[context.scope].prefix + std::string(name)).second)
    return;  // one message for a name, however many laws use it
  if (refused) return problem(refusal_->code.c_str(), refusal_->situation, place, refusal_->help, {}, refusal_->notes);
  std::string help = error.help;
  if (error.code == "BG121" && situation.starts_with("unknown name"))
    if (const std::string advice = name_advice(context, name); !advice.empty()) {
      // "F" is near "f", but that is chance: what is meant is known better.
      const bool near = help.starts_with("did you mean");
      const bool word = name.size() > 2 && name.find('.') == std::string_view::npos;
      help = near && word ? help + " Otherwise " + advice : help.empty() || near ? advice : help;
    }
  if (error.code == "BG121" && help.empty())
    help = context.constant != nullptr ? "declare it among \"parameters\""
                                       : "declare it among \"parameters\" or \"signals\"";
  if (error.code == "BG181" && situation.starts_with("a unit"))
    if (const std::string advice = unit_advice(context, value, text.substr(0, error.begin), name); !advice.empty())
      help = help.starts_with("if a product") ? help.substr(0, help.find(';')) + "; otherwise " + advice : advice;
  problem(error.code.c_str(), situation, place, help);
}

/// How a number with its unit is written in this place; nothing if what follows the number is no unit.
std::string Reader::unit_advice(const Context& context, NodeId value, std::string_view number_text,
                                std::string_view unit_text) {
  const std::string number(trimmed(number_text)), unit(bare_unit(unit_text));
  if (!parse_unit(unit).unit) return {};
  const std::string what = context.constant == nullptr ? "" : context.constant;
  if (what == "\"start\"" || what == "\"stop\"" || what == "\"interval\"") {
    const auto seconds = in_seconds(number, unit);
    return "times are in seconds: write " + seconds.value_or("the number alone");
  }
  const std::string pointer = document(scopes_[context.scope]).pointer(value);
  const bool of_instance = pointer.starts_with("/elements/") && pointer.find("/parameters/") != std::string::npos;
  if (what == "an initial value") return "write the number alone, " + number + ", in the unit that the state has";
  if (of_instance || pointer.starts_with("/scenes/"))
    return "write the number alone, " + number + ", in the unit that the parameter has";
  const std::string shown = is_json_number(number) ? number : in_quotes(number);
  const std::string pair = "{ \"value\": " + shown + ", \"unit\": " + in_quotes(unit) + " }";
  if (pointer.starts_with("/elements/"))
    return "units belong to parameters: add \"x\": " + pair + " to \"parameters\", and write x here";
  return "write " + pair;
}

/// What a name of a domain is called here: "F" in a law, "mass.v" anywhere.
std::string Reader::name_advice(const Context& context, std::string_view name) const {
  const auto dot = name.rfind('.');
  if (dot == std::string_view::npos) {
    if (context.own != nullptr && context.constant == nullptr && !is_junction(context.own->kind))
      return law_advice(*context.own, name);
    const auto variable = variable_called(name, std::nullopt);
    if (!variable || context.constant != nullptr) return {};
    return "declare it among \"parameters\" or \"signals\"; variables of the graph are written with their element, as "
           "in "
           "mass.f: " +
           with_words(*variable);
  }
  std::string base = scopes_[context.scope].prefix + std::string(name.substr(0, dot));
  const std::string last(name.substr(dot + 1)), written(name.substr(0, dot));
  auto found = names_.find(base);
  std::string port;
  if (found == names_.end() && base.rfind('.') != std::string::npos) {
    found = names_.find(base.substr(0, base.rfind('.')));
    if (found != names_.end() && found->second.kind == Entity::Kind::element) {
      const auto& ports = model_.elements[found->second.index].ports;
      if (std::find(ports.begin(), ports.end(), base.substr(base.rfind('.') + 1)) == ports.end()) return {};
    }
  }
  if (found == names_.end()) return {};
  if (found->second.kind == Entity::Kind::bond)
    return "a bond has an effort " + in_quotes(written + ".e") + " and a flow " + in_quotes(written + ".f");
  if (found->second.kind != Entity::Kind::element) return {};
  const Element& element = model_.elements[found->second.index];
  const std::string kind = kind_text(element.kind, element.modulated);
  if (is_junction(element.kind))
    return "the bonds of a " + kind + "-junction share their " + (kind == "0" ? "effort " : "flow ") +
           in_quotes(written + (kind == "0" ? ".e" : ".f"));
  // The V of a tank is its volume, that of a capacitor its voltage, and Q is a charge or a flow: then all are listed.
  const bool field_without_port = is_field(element.kind) && base == element.name;
  const std::string end = field_without_port ? written + "." + element.ports[0] : written;
  const auto named = std::find(element.ports.begin(), element.ports.end(), base.substr(base.rfind('.') + 1));
  const std::size_t number =
      field_without_port || named == element.ports.end() ? 0 : static_cast<std::size_t>(named - element.ports.begin());
  const bool ambiguous = stores_displacement(element, number) && (last == "V" || last == "Q");
  std::optional<Variable> variable;
  if (!ambiguous) variable = variable_called(last, stored_at(element, number));
  if (variable && has_variable(element, number, *variable))
    return "write " + in_quotes(end + "." + letter(*variable)) + ": " + with_words(*variable);
  std::string help = "the variables of " + in_quotes(written) + ", of kind " + kind + ", are";
  for (const Variable v : variables_of(element, number, false))
    help += (help.ends_with(" are") ? " " : ", ") + in_quotes(end + "." + letter(v)) + ": " + variable_words(v);
  if (variable == Variable::displacement)
    help += "; a displacement is the \"integral\" of a flow among \"signals\", or the q of a C at the same junction";
  return help;
}

/// The same in the law of an element, where its own variables need no name before them.
std::string Reader::law_advice(const Element& own, std::string_view name) const {
  const auto variable = variable_called(name, stored_at(own, 0));
  if (!variable) return {};
  std::string ports;
  for (std::size_t port = 0; is_field(own.kind) && port < own.ports.size(); ++port)
    for (const Variable v : variables_of(own, port, true))
      ports += (ports.empty() ? "" : ", ") + in_quotes(own.ports[port] + "." + letter(v));
  if (!ports.empty()) return "the variables of a field are written with their port: " + ports;
  const bool usable = law_relates(own, 0, *variable);
  std::string help;
  if (!usable)
    help =
        "the law of " + kind_text(own.kind, own.modulated) + " has no " + variable_words(*variable) + "; it relates ";
  else
    help = "here a law relates ";
  bool first = true;
  for (const Variable v : variables_of(own, 0, true)) {
    help += (first ? "" : " and ") + in_quotes(std::string(1, letter(v))) + ", the " + variable_words(v);
    first = false;
  }
  return help;
}

/// What to write for an initial value that a store has not: "v" of a mass, "x" of a spring.
std::string Reader::initial_advice(const Element& own, std::string_view name, const std::string& owner) const {
  const auto dot = name.rfind('.');
  const auto named = std::find(own.ports.begin(), own.ports.end(), name.substr(0, std::min(dot, name.size())));
  const std::size_t number = named == own.ports.end() ? 0 : static_cast<std::size_t>(named - own.ports.begin());
  const bool q = stores_displacement(own, number);
  const auto variable =
      variable_called(dot == std::string_view::npos ? name : name.substr(dot + 1), stored_variable(own, number));
  const std::string port = owner + (own.ports.size() > 1 ? own.ports[number] + "." : "");
  const std::string stored = in_quotes(port + (q ? "q" : "p")), other = in_quotes(port + (q ? "e" : "f"));
  const char* product = q ? "q = C e" : "p = I f (momentum is mass times velocity)";
  if (variable && law_relates(own, number, *variable))
    return "write " + in_quotes(port + letter(*variable)) + " for the " + variable_words(*variable) +
           (own.coefficient.valid() ? std::string("; ") + product : "");
  return "write " + stored + ", the " + variable_words(stored_variable(own, number)) + ", or " + other + ", the " +
         variable_words(q ? Variable::effort : Variable::flow);
}

std::string Reader::law_without_equals(const Element& own, std::string_view text) const {
  const std::string port = is_field(own.kind) ? own.ports[0] + "." : "";
  const std::string shown(trimmed(text));
  if (shown.find("==") != std::string::npos) return "a law has a single equals sign; == compares";
  const auto contains = [&](char letter) {
    const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    for (auto at = shown.find(letter); at != std::string::npos; at = shown.find(letter, at + 1))
      if ((at == 0 || !is_part(shown[at - 1])) && (at + 1 == shown.size() || !is_part(shown[at + 1]))) return true;
    return false;
  };
  constexpr std::size_t kLongest = 40;
  std::string help;
  for (const Variable v : variables_of(own, 0, true))
    if (is_field(own.kind) || !contains(letter(v)))
      help += (help.empty() ? "write " : " or ") +
              in_quotes(port + letter(v) + " = " + (shown.size() > kLongest ? "..." : shown));
  return help;
}

}  // namespace bgsim
