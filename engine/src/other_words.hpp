/// What people write who come from other tools, and what it is called here. Only ever the help of a message about
/// something that was refused: nothing is read in another's language.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "bgsim/model.hpp"

namespace bgsim {

/// What to write for a function that is not there: "write exp(x)" for Exp, "... min(max(x, low), high)" for sat. The
/// prefixes of other languages' libraries are seen through: np.sin, Math.sin. Empty if nothing is known.
std::string instead_of_function(std::string_view name);

/// The same for a name; @p rest is the text that follows it, so that "d" in "d/dt" is known for what it is.
std::string instead_of_name(std::string_view name, std::string_view rest);

/// A sign that the language does not have.
struct ForeignSign {
  std::size_t length = 0;  ///< bytes of the text
  std::string what;        ///< how a message calls it, where the sign itself cannot be seen; else empty
  std::string help;
};
/// The sign at the beginning of @p text: "&&", "?", a superscript, a minus that is no hyphen; none if not known.
std::optional<ForeignSign> foreign_sign(std::string_view text);

/// Which variable a letter or word of a domain means: "F" and "voltage" the effort, "v" the flow. Where a letter means
/// two, that which a law of @p kind relates.
std::optional<Variable> variable_called(std::string_view name, ElementKind kind);
/// "effort (force, voltage, torque, pressure, ...)".
const char* variable_words(Variable variable);

/// What to write for a key that an element of a kind has not: "stiffness" of a C. Empty if nothing is known.
std::string instead_of_key(ElementKind kind, std::string_view key);
/// The same for the keys of "a model", "a bond", "a scene", "a parameter", "a signal", "an output".
std::string instead_of_key(std::string_view object, std::string_view key);
/// "for ode45 write erk5; " for a method of another tool.
std::string instead_of_method(std::string_view method);
/// What to write for a kind that is not there: "Resistor", "J0", "Df".
std::string instead_of_kind(std::string_view kind);

}  // namespace bgsim
