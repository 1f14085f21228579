/// Text for people, and JSON as text. Names, texts and file names come from files that somebody else wrote: what a
/// reader would not see, or what would rule a terminal, is written out (docs/design/writers.md).
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace bgsim {

/// @p text with all that has no shape of its own written out: control characters as \x1b, the signs that turn or hide
/// text (U+202E, U+200B, ...) and combining marks beyond four on one letter as \u{202e}, bytes that are no UTF-8 as
/// \xff. Line breaks and tabs stay; a line end of two characters becomes one. Valid UTF-8, whatever goes in.
/// Linear in the text. Twice the same as once.
std::string visible_text(std::string_view text);

/// The same for a text that belongs into one line: line breaks and tabs are \n, \r and \t.
std::string visible_line(std::string_view text);

/// A name within a line: as visible_line, and of one longer than some hundred characters the beginning and the end,
/// with its length. For messages and tables; data have names whole.
std::string short_name(std::string_view name);
/// The same for the path of a file, which is whole up to a thousand characters.
std::string short_path(std::string_view path);

/// The same for a text of at most @p longest characters, of which a longer one keeps two thirds from its beginning and
/// a sixth from its end.
std::string short_line(std::string_view text, std::size_t longest);

/// A number as people read it, with at most @p digits of them: "0.25", "3.64132e+20".
std::string number_text(double value, int digits = 10);

/// Characters (code points) of a text in UTF-8: what a column of a table counts.
std::size_t character_count(std::string_view text);

/// Walks over @p text and hands over each character: its bytes and its code point, or one byte and -1 where the bytes
/// are no UTF-8 (RFC 3629: surrogates and forms longer than needed are none).
void for_each_character(std::string_view text, const std::function<void(std::string_view bytes, long code)>& take);

/// Length in bytes of the character at the head of @p text, from 1 to 4; 0 if the bytes are no UTF-8, or no whole one.
std::size_t character_length(std::string_view text);

/// @p json (of nlohmann's kind) as text: what all JSON that is written goes through. Bytes that are no UTF-8, as they
/// come from the names of files and of columns, have no place in JSON and become U+FFFD.
/// @param indent  blanks for each level; -1 for one line.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bgsim
