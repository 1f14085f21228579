/// The codes of all messages, and the one way to begin a message.
#pragma once

#include <string_view>

#include "bgsim/diagnostic.hpp"

namespace bgsim {

struct Code {
  std::string_view code;  ///< "BG301"
  Severity severity = Severity::error;
  std::string_view title;  ///< of its section in docs/errors.md
};
[[nodiscard]] const Code& code_row(std::string_view code);  ///< @throws std::logic_error if there is none

/// A problem of this code, of the severity that its row has. What is left out may be filled in later.
[[nodiscard]] Diagnostic diagnostic_of(std::string_view code, std::string situation = {},
                                       std::optional<Place> place = {}, std::string rule = {}, std::string help = {},
                                       std::vector<Note> notes = {});

}  // namespace bgsim
