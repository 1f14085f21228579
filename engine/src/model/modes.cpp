#include "bgsim/modes.hpp"

#include <set>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

std::vector<ElementId> switches_of(const Model& model) {
  std::vector<ElementId> result;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (is_switch(model.elements[i].kind)) result.emplace_back(i);
  return result;
}

bool is_closed(const Element& element) { return (imposed_variable(element.kind) == Variable::effort) != element.idle; }

void set_closed(Element& element, bool closed) {
  element.idle = false;
  if (element.contact)
    element.kind = closed ? ElementKind::free_contact : ElementKind::closed_contact;
  else if (element.diode)
    element.kind = closed ? ElementKind::conducting_diode : ElementKind::blocking_diode;
  else
    element.kind = closed ? ElementKind::closed_switch : ElementKind::open_switch;
}

bool mode_holds(const Element& element) {
  if (!is_switch(element.kind)) return element.stands_in;
  if (element.contact && element.contact->settling) return false;
  const bool reversed = element.contact || (element.switches && element.switches->locks);
  return is_closed(element) != reversed;
}

Mode mode_of(const Model& model) {
  Mode mode;
  for (const Element& element : model.elements)
    if (is_switch(element.kind)) mode.push_back(is_closed(element));
  return mode;
}

Model in_mode(const Model& model, const Mode& closed) {
  Model result = model;
  std::size_t next = 0;
  for (Element& element : result.elements)
    if (is_switch(element.kind)) set_closed(element, closed.at(next++));
  return result;
}

std::string side_text(const Element& element, bool closed) {
  if (element.contact) return closed ? "free" : "closed";
  if (element.diode) return closed ? "conducts" : "blocks";
  const bool locks = element.switches && element.switches->locks;
  return locks ? (closed ? "free" : "locked") : closed ? "closed" : "open";
}

std::string mode_text(const Model& model, const Mode& closed) {
  constexpr std::size_t kMost = 12;
  std::string text;
  std::size_t next = 0;
  for (const Element& element : model.elements) {
    if (!is_switch(element.kind)) continue;
    if (next < kMost) text += (next == 0 ? "" : ", ") + element.name + " " + side_text(element, closed.at(next));
    ++next;
  }
  if (next > kMost) text += " and " + std::to_string(next - kMost) + " more";
  return text;
}

Mode parse_mode(const Model& model, std::string_view text, Mode mode) {
  const std::vector<ElementId> switches = switches_of(model);
  const auto fail = [&](const std::string& situation, const std::string& help) {
    throw ModelError({diagnostic_of("BG173", situation, {}, "a mode says of switches which side they are on", help)},
                     model.sources);
  };
  std::set<std::string> given;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view part = trimmed(text.substr(0, comma));
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    const std::size_t equals = part.find('=');
    const std::string name(trimmed(part.substr(0, equals)));
    if (!given.insert(name).second) fail("the side of \"" + name + "\" is given twice", "leave out one of the two");
    std::vector<std::string> names;
    bool known = false;
    for (std::size_t i = 0; i < switches.size(); ++i) {
      const Element& element = model.elements[switches[i].index()];
      names.push_back(element.name);
      if (element.name != name) continue;
      known = true;
      const std::string_view side =
          equals == std::string_view::npos ? std::string_view() : trimmed(part.substr(equals + 1));
      if (side != side_text(element, true) && side != side_text(element, false)) {
        std::string help = "write ";
        help.append(name).append("=").append(side_text(element, true)).append(" or ");
        help.append(name).append("=").append(side_text(element, false));
        fail("\"" + std::string(part) + "\" does not say which side the switch is on", help);
      }
      mode[i] = side == side_text(element, true);
    }
    if (known) continue;
    const std::string near = nearest_name(name, names);
    fail("there is no switch \"" + name + "\" in the model", near.empty() ? "" : "did you mean \"" + near + "\"?");
  }
  return mode;
}

}  // namespace bgsim
