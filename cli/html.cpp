#include "html.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bgsim/json_text.hpp"
#include "bgsim/xml_text.hpp"

namespace bgsim::cli {

std::string element(const std::string& name, std::string_view text) {
  return "<" + name + ">" + xml_text(text) + "</" + name + ">";
}

std::string html_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                       const std::vector<std::size_t>& numeric) {
  const auto kind = [&](std::size_t column) {
    return std::find(numeric.begin(), numeric.end(), column) == numeric.end() ? "" : " class=\"number\"";
  };
  std::string text = "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>";
  for (std::size_t i = 0; i < header.size(); ++i)
    text.append("<th scope=\"col\"").append(kind(i)).append(">").append(header[i]).append("</th>");
  text += "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    text += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i == 0)
        text.append("<th scope=\"row\">").append(row[i]).append("</th>");
      else
        text.append("<td").append(kind(i)).append(">").append(row[i]).append("</td>");
    }
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string script_json(const nlohmann::ordered_json& json) {
  const std::string text = json_text(json);
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      result += "\\u003c";  // occurs in strings only
    else
      result += c;
  }
  return result;
}

std::string base64(std::span<const double> values) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((8 * values.size() + 2) / 3 * 4);
  std::uint32_t pending = 0;
  int bytes = 0;
  const auto write = [&](int digits) {
    for (int i = 0; i < 4; ++i) text += i < digits ? kDigits[(pending >> (18 - 6 * i)) & 63U] : '=';
    pending = 0;
    bytes = 0;
  };
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int byte = 0; byte < 8; ++byte) {
      pending |= static_cast<std::uint32_t>((bits >> (8 * byte)) & 255U) << (16 - 8 * bytes);
      if (++bytes == 3) write(4);
    }
  }
  if (bytes > 0) write(bytes + 1);
  return text;
}

std::string_view raw_text(std::string_view text, std::string_view element) {
  if (text.find("</" + std::string(element)) != std::string_view::npos)
    throw std::logic_error("an asset of the page holds </" + std::string(element));
  return text;
}

}  // namespace bgsim::cli
