/// What people write in model files who come from other tools, and what it is called here. Only ever the help of a
/// message about something that was refused.
#pragma once

#include <string>
#include <string_view>

#include "bgsim/model.hpp"

namespace bgsim {

/// What to write for a key that an element of a kind has not: "stiffness" of a C. Empty if nothing is known.
std::string instead_of_key(ElementKind kind, std::string_view key);
/// The same for the keys of "a model", "a bond", "a scene", "a parameter", "a signal", "an output".
std::string instead_of_key(std::string_view object, std::string_view key);
/// "for ode45 write erk5; " for a method of another tool.
std::string instead_of_method(std::string_view method);
/// What to write for a kind that is not there: "Resistor", "J0", "Df".
std::string instead_of_kind(std::string_view kind);

}  // namespace bgsim
