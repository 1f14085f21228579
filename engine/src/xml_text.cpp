#include "bgsim/xml_text.hpp"

namespace bgsim {

std::string xml_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) >= ' ' || c == '\n' || c == '\t' ? c : ' ';
  }
  return result;
}

}  // namespace bgsim
