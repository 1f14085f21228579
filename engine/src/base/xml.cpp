#include "bgsim/xml.hpp"

#include "bgsim/text.hpp"

namespace bgsim {

std::string xml_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : visible_text(text)) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

namespace {

/// <TAG NAME="VALUE" ..., without its end.
std::string opened(std::string_view tag, const XmlAttributes& attributes) {
  std::string text("<");
  text += tag;
  for (const auto& [name, value] : attributes)
    text.append(" ").append(name).append("=\"").append(xml_text(value)) += '"';
  return text;
}

}  // namespace

std::string xml_begin(std::string_view tag, const XmlAttributes& attributes) { return opened(tag, attributes) += '>'; }

std::string xml_element(std::string_view tag, const XmlAttributes& attributes, std::string_view inside) {
  return opened(tag, attributes).append(">").append(inside).append("</").append(tag).append(">");
}

std::string xml_element(std::string_view tag, std::string_view inside) { return xml_element(tag, {}, inside); }

std::string xml_empty(std::string_view tag, const XmlAttributes& attributes) {
  return opened(tag, attributes).append("/>");
}

std::string xml_text_element(std::string_view tag, std::string_view text) {
  return xml_element(tag, {}, xml_text(text));
}

}  // namespace bgsim
