#include "read/reader.hpp"

namespace bgsim {

/// A signal whose value is a condition. It stands for its text, so no stage but this one knows of it.
void Reader::declare_condition(std::size_t scope, NodeId node, NodeId value) {
  const Document& file = document(scopes_[scope]);
  const std::string name = scopes_[scope].prefix + std::string(file[node].key);
  const auto index = static_cast<std::uint32_t>(conditions_.size());
  if (claim(name, {Entity::Kind::condition, index, file.key_place(node)}))
    conditions_.push_back({{static_cast<std::uint32_t>(scope), value}, file.place(value), name});
}

/// The condition that a signal stands for, parsed when it is first asked for. None if it is at fault, which is
/// reported.
std::optional<ExprId> Reader::condition_named(std::size_t index) {
  if (conditions_[index].id.valid()) return conditions_[index].id;
  const std::string name = conditions_[index].name;
  if (broken_.contains(name)) return std::nullopt;
  if (conditions_[index].begun)
    return refuse("BG132", "the condition " + in_quotes(name) + " depends on itself",
                  "give one of the conditions a text that does not refer to the others",
                  {{conditions_[index].place, in_quotes(name) + " is given here"}});
  conditions_[index].begun = true;
  const auto [names, value] = conditions_[index].text;
  const ExprId id = condition({names, nullptr, nullptr}, value, "a signal");
  refusal_.reset();
  conditions_[index].id = id;
  if (id.valid()) return id;
  broken_.insert(name);
  return std::nullopt;
}

/// What an instance says of a submodel's condition.
void Reader::override_condition(std::size_t scope, std::uint32_t index, NodeId node) {
  const auto parent = static_cast<std::uint32_t>(scopes_[scope].parent);
  const Document& file = document(scopes_[parent]);
  if (conditions_[index].latch || file[node].kind != JsonKind::string)
    problem("BG113",
            "the signal " + in_quotes(file[node].key) + " is a condition" +
                (conditions_[index].latch ? " that remembers" : ""),
            file.place(node),
            conditions_[index].latch ? "let its \"set\" and \"reset\" depend on conditions that can be given"
                                     : "give a condition in quotes: \"t > 1\"");
  else
    conditions_[index].text = {parent, node}, conditions_[index].place = file.place(node);
}

}  // namespace bgsim
