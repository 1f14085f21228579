/// JSON as text.
#pragma once

#include <string>

namespace bgsim {

/// @p json (of nlohmann's kind) as text: what all JSON that is written goes through. Bytes that are no UTF-8, as they
/// come from the names of files and of columns, have no place in JSON and become U+FFFD.
/// @param indent  blanks for each level; -1 for one line.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bgsim
