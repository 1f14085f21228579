#include "base/latex_text.hpp"

#include <algorithm>

#include "bgsim/text.hpp"

namespace bgsim {

namespace {

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

/// What text of LaTeX writes for a character that it would read otherwise.
std::string_view command_for(char c) {
  switch (c) {
    case '\\':
      return "\\textbackslash{}";
    case '^':
      return "\\textasciicircum{}";
    case '~':
      return "\\textasciitilde{}";
    case '{':
      return "\\{";
    case '}':
      return "\\}";
    case '$':
      return "\\$";
    case '&':
      return "\\&";
    case '#':
      return "\\#";
    case '%':
      return "\\%";
    case '_':
      return "\\_";
    default:
      return {};
  }
}

}  // namespace

std::string latex_text(std::string_view name) {
  std::string escaped;
  for (const char c : visible_line(name)) {
    const std::string_view command = command_for(c);
    if (command.empty())
      escaped += c;
    else
      escaped += command;
  }
  const bool plain = std::all_of(name.begin(), name.end(), is_plain);
  return (plain ? "\\mathrm{" : "\\text{") + escaped + "}";
}

}  // namespace bgsim
