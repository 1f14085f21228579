/// What people write in expressions who come from other tools, and what it is called here. Only ever the help of a
/// message about something that was refused: nothing is read in another's language.
#pragma once

#include <optional>
#include <string>
#include <string_view>

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

}  // namespace bgsim
