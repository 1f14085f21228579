#include "gnuplot.hpp"

#include <array>
#include <cctype>
#include <cstdio>

#include "bgsim/visible_text.hpp"
#include "programs.hpp"

namespace bgsim::cli {

std::string gnuplot_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : short_name(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ' || std::isalnum(byte) != 0) {
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
  return run_program(kGnuplot, {"--default-settings", "-"}, "set encoding utf8\n" + script);
}

}  // namespace bgsim::cli
