#include "bgsim/xml_text.hpp"

#include "bgsim/visible_text.hpp"

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

}  // namespace bgsim
