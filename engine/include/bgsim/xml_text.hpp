/// Text in XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace bgsim {

/// @p text as the content of an element or of an attribute in double quotes. Control characters, for which XML has no
/// place, become blanks.
std::string xml_text(std::string_view text);

}  // namespace bgsim
