#include "gnuplot.hpp"

#include <array>
#include <cctype>
#include <cstdio>

#include "bgsim/text.hpp"
#include "programs.hpp"

namespace bgsim::cli {

std::string gnuplot_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : short_name(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ' || std::isalpha(byte) != 0) {
      out += c;
    } else {
      std::array<char, 8> code{};
      std::snprintf(code.data(), code.size(), "\\%03o", static_cast<unsigned>(byte));
      out += code.data();
    }
  }
  return out + '"';
}

std::string svg_from_gnuplot(const std::string& script) {
  // Widths of letters are those of UTF-8, whatever the locale.
  std::string svg = run_program(kGnuplot, {"--default-settings", "-"}, "set encoding utf8\n" + script);
  // gnuplot writes > in texts as it is, which XML allows but after ]]; it has no section of its own that would end so.
  constexpr std::string_view kEnd = "]]>";
  for (auto at = svg.find(kEnd); at != std::string::npos; at = svg.find(kEnd, at))
    svg.replace(at, kEnd.size(), "]]&gt;");
  return svg;
}

}  // namespace bgsim::cli
