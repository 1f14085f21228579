/// Text in XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace bgsim {

/// @p text as the content of an element or of an attribute in double quotes. What XML has no place for (control
/// characters, bytes that are no UTF-8) is written out as visible_text does it.
std::string xml_text(std::string_view text);

}  // namespace bgsim
