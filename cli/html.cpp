#include "html.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bgsim/text.hpp"
#include "bgsim/xml.hpp"

namespace bgsim::cli {

std::string html_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                       const std::vector<std::size_t>& numeric) {
  const auto cell = [&](const char* tag, XmlAttributes attributes, std::size_t column, const std::string& inside) {
    if (std::find(numeric.begin(), numeric.end(), column) != numeric.end()) attributes.emplace_back("class", "number");
    return xml_element(tag, attributes, inside);
  };
  std::string titles, body("\n");
  for (std::size_t i = 0; i < header.size(); ++i) titles += cell("th", {{"scope", "col"}}, i, header[i]);
  for (const std::vector<std::string>& row : rows) {
    std::string cells;
    for (std::size_t i = 0; i < row.size(); ++i)
      cells += i == 0 ? xml_element("th", {{"scope", "row"}}, row[i]) : cell("td", {}, i, row[i]);
    body += xml_element("tr", cells) + "\n";
  }
  const std::string table = xml_element("thead", xml_element("tr", titles)) + xml_element("tbody", body);
  return scrolling(xml_element("table", table)) + "\n";
}

std::string html_section(const std::string& id, std::string_view title, std::string_view inside) {
  return xml_element("section", {{"id", id}}, xml_text_element("h2", title) + "\n" + std::string(inside)) + "\n";
}

std::string folded(std::string_view summary, std::string_view inside, bool open) {
  const XmlAttributes attributes = open ? XmlAttributes{{"open", ""}} : XmlAttributes{};
  return xml_element("details", attributes, xml_element("summary", summary) + "\n" + std::string(inside)) + "\n";
}

std::string paragraph(std::string_view inside) { return xml_element("p", inside) + "\n"; }

std::string note_paragraph(std::string_view inside) { return xml_element("p", {{"class", "note"}}, inside) + "\n"; }

std::string preformatted(std::string_view text, std::string_view css_class) {
  XmlAttributes attributes;
  if (!css_class.empty()) attributes.emplace_back("class", css_class);
  attributes.emplace_back("tabindex", "0");
  return xml_element("pre", attributes, xml_text(text)) + "\n";
}

std::string badge(bool good, std::string_view text) {
  return xml_element("span", {{"class", good ? "badge good" : "badge bad"}}, xml_text(text));
}

std::string scrolling(std::string_view inside) {
  return xml_element("div", {{"class", "scroll"}, {"tabindex", "0"}}, inside);
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

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  std::uint32_t pending = 0;
  int count = 0;
  const auto write = [&](int digits) {
    for (int i = 0; i < 4; ++i) text += i < digits ? kDigits[(pending >> (18 - 6 * i)) & 63U] : '=';
    pending = 0;
    count = 0;
  };
  for (const char byte : bytes) {
    pending |= static_cast<std::uint32_t>(static_cast<unsigned char>(byte)) << (16 - 8 * count);
    if (++count == 3) write(4);
  }
  if (count > 0) write(count + 1);
  return text;
}

std::string base64(std::span<const double> values) {
  std::string bytes;
  bytes.reserve(8 * values.size());
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int byte = 0; byte < 8; ++byte) bytes += static_cast<char>((bits >> (8 * byte)) & 255U);
  }
  return base64(bytes);
}

std::string svg_image(std::string_view svg, std::string_view about) {
  return xml_empty("img", {{"src", "data:image/svg+xml;base64," + base64(svg)}, {"alt", std::string(about)}}) + "\n";
}

std::string_view raw_text(std::string_view text, std::string_view element) {
  if (text.find("</" + std::string(element)) != std::string_view::npos)
    throw std::logic_error("an asset of the page holds </" + std::string(element));
  return text;
}

}  // namespace bgsim::cli
