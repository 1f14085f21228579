/// Modes of a model with ideal switches (Sw), diodes (D) and contacts: which of them are closed. In a mode each is one
/// of two plain kinds, a source of no effort (closed; a diode conducts; a contact is free) or of no flow (open; a diode
/// blocks; a contact is closed), so every later stage sees a model without switches.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// By switch, in model order: whether it is closed.
using Mode = std::vector<bool>;

/// The model's switches, in model order.
std::vector<ElementId> switches_of(const Model& model);
[[nodiscard]] bool is_closed(const Element& element);
void set_closed(Element& element, bool closed);
/// What mode("name") says of a switch, diode or contact: whether it is closed (of one that is written with "locked":
/// locked), conducts, or touches.
[[nodiscard]] bool mode_holds(const Element& element);
/// The mode that the model is in. As read: switches with hysteresis as their "initial" says, the others open.
Mode mode_of(const Model& model);
/// A copy of the model in another mode. Elements, bonds, symbols and all their ids are the same.
Model in_mode(const Model& model, const Mode& closed);
/// "closed" or "open"; of a switch that is written with "locked", "locked" or "free"; of a diode "conducts" or
/// "blocks", of a contact "free" or "closed".
std::string side_text(const Element& element, bool closed);
/// "chop closed, brake locked"; at most some switches, then how many more.
std::string mode_text(const Model& model, const Mode& closed);
/// Reads "chop=closed,brake=locked" into @p mode; those that are not named stay as they are.
/// @throws ModelError BG173 no such switch, or no such side of it.
Mode parse_mode(const Model& model, std::string_view text, Mode mode);

}  // namespace bgsim
