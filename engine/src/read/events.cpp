#include <algorithm>
#include <array>

#include "read/reader.hpp"

namespace bgsim {

/// "events": name -> { when, set, priority, about }.
void Reader::parse_events(std::size_t scope) {
  const NodeId object = section(scopes_[scope], "events", JsonKind::object);
  if (!object.valid()) return;
  for (NodeId node = document(scopes_[scope])[object].first_child; node.valid();
       node = document(scopes_[scope])[node].next_sibling)
    parse_event(scope, node);
}

void Reader::parse_event(std::size_t scope, NodeId node) {
  static constexpr std::array<std::string_view, 4> kKeys{"when", "set", "priority", "about"};
  const Document& file = document(scopes_[scope]);
  if (!expect(file, node, JsonKind::object, "an event")) return;
  const std::string name(file[node].key);
  if (!valid_name(name, file.key_place(node), "an event")) return;
  check_keys(file, node, kKeys, "an event");
  ModelEvent event;
  event.name = scopes_[scope].prefix + name;
  event.place = file.key_place(node);
  text_of(file, node, "about");
  if (const NodeId when = file.find(node, "when"); when.valid()) {
    event.when = condition({scope, nullptr, nullptr}, when, "\"when\"");
    event.when_place = file.place(when);
  } else {
    missing(file, node, "the event " + in_quotes(name) + " has no \"when\"", event.place,
            "add \"when\": the condition that becomes true at its instant");
  }
  if (const NodeId set = file.find(node, "set"); set.valid())
    parse_sets(scope, set, event);
  else
    missing(file, node, "the event " + in_quotes(name) + " has no \"set\"", event.place,
            "add \"set\": { \"mass.p\": \"-0.7*pre(mass.p)\" }, what stores and integrals hold after it");
  if (const NodeId priority = file.find(node, "priority");
      priority.valid() && expect(file, priority, JsonKind::number, "\"priority\""))
    event.priority = file[priority].number;
  if (event.when.valid()) model_.events.push_back(std::move(event));
}

void Reader::parse_sets(std::size_t scope, NodeId object, ModelEvent& event) {
  const Document& file = document(scopes_[scope]);
  if (!expect(file, object, JsonKind::object, "\"set\"")) return;
  if (!file[object].first_child.valid())
    problem("BG112", "the \"set\" of the event " + in_quotes(event.name) + " is empty", file.place(object),
            "add what it sets: { \"mass.p\": \"-0.7*pre(mass.p)\" }", "an event sets at least one store or integral");
  for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) {
    const ExprId value = expression({scope, nullptr, nullptr, true}, node, "what an event sets");
    auto set = set_target(scope, node);
    if (!set || !value.valid()) continue;
    set->value = value;
    set->place = file.place(node);
    set->target_place = file.key_place(node);
    event.sets.push_back(*set);
  }
}

/// A store's q or p, or an integral.
std::optional<ModelEvent::Set> Reader::set_target(std::size_t scope, NodeId node) {
  const Document& file = document(scopes_[scope]);
  const std::string name(file[node].key);
  const auto refused = [&](const std::string& why, const std::string& help) {
    if (!is_broken(scope, name))
      problem("BG185", in_quotes(name) + " cannot be set by an event: " + why, file.key_place(node), help,
              "an event sets what stores hold, q of C and CC, p of I and II, either of IC, and integrals");
    return std::nullopt;
  };
  if (const auto symbol = state_named(scopes_[scope].prefix + name, false)) {
    const ModelSymbol& meaning = model_.symbols[symbol->index()];
    ModelEvent::Set set;
    if (meaning.kind == ModelSymbol::Kind::signal)
      set.signal = meaning.signal;
    else
      set.element = meaning.element, set.port = meaning.port;
    return set;
  }
  if (const auto symbol = state_named(scopes_[scope].prefix + name, true)) {
    const ModelSymbol& meaning = model_.symbols[symbol->index()];
    const Element& store = model_.elements[meaning.element.index()];
    const std::string stored = port_name(store, meaning.port).substr(scopes_[scope].prefix.size()) + "." +
                               letter(stored_variable(store, meaning.port));
    return refused("it follows from what the store holds", "set " + in_quotes(stored));
  }
  const auto found = names_.find(scopes_[scope].prefix + name);
  if (found != names_.end() && found->second.kind == Entity::Kind::signal)
    return refused("it is a signal with a value of its own", "write an \"integral\", which keeps what it is set to");
  if (found != names_.end() && found->second.kind == Entity::Kind::parameter)
    return refused("parameters are constants", "write a signal with \"integral\": 0, which keeps what it is set to");
  if (found != names_.end() && found->second.kind == Entity::Kind::condition)
    return refused("it is a condition", "let the \"set\" or \"reset\" of the latch hold where the event takes place");
  return refused("there is no such store or integral", suggestion(scopes_[scope].prefix + name, state_names()));
}

}  // namespace bgsim
