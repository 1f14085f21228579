/// XML and HTML.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bgsim {

/// @p text as the content of an element, or of an attribute in double quotes. What XML has no place for (control
/// characters, bytes that are no UTF-8) is written out as visible_text does it.
std::string xml_text(std::string_view text);

/// Names and values, which are escaped.
using XmlAttributes = std::vector<std::pair<std::string_view, std::string>>;

/// <TAG NAME="VALUE" ...>, as the begin of an element.
std::string xml_begin(std::string_view tag, const XmlAttributes& attributes = {});
/// <TAG NAME="VALUE" ...>INSIDE</TAG>.
/// @param inside  XML already: elements, or xml_text of a text.
std::string xml_element(std::string_view tag, const XmlAttributes& attributes, std::string_view inside);
std::string xml_element(std::string_view tag, std::string_view inside);
/// <TAG NAME="VALUE" .../>, an element without content.
std::string xml_empty(std::string_view tag, const XmlAttributes& attributes);
/// <TAG>text</TAG>, the text escaped.
std::string xml_text_element(std::string_view tag, std::string_view text);

}  // namespace bgsim
