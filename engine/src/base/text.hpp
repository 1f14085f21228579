/// Small texts that messages and tables are made of: names in quotes, lists, numbers, letters.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bgsim {

/// A name in a message: in quotes, and shortened as short_name does.
[[nodiscard]] std::string in_quotes(std::string_view name);

/// "a", "b" or "c": each in quotes; beyond @p most names the list ends with "...".
[[nodiscard]] std::string list_of(const std::vector<std::string>& names, const char* last_separator = " or ",
                                  std::size_t most = 20);

/// The shortest decimal form that reads back as the same number. A number for people is number_text of
/// bgsim/text.hpp.
[[nodiscard]] std::string shortest_number(double value);

/// The letters A to Z as small ones; all else stays, whatever the locale.
[[nodiscard]] std::string lower_case(std::string_view text);

/// Without blanks, tabs and line breaks at its ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// Of ASCII, whatever the locale.
/// Blanks and line ends, as JSON has them.
[[nodiscard]] constexpr bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
[[nodiscard]] constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
[[nodiscard]] constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
/// What a name may begin with.
[[nodiscard]] constexpr bool begins_name(char c) { return is_letter(c) || c == '_'; }

}  // namespace bgsim
