#include "names.hpp"

#include <algorithm>

namespace bgsim::cli {

std::vector<std::string> parts_of_list(const std::string& list, bool expressions) {
  std::vector<std::string> parts{""};
  int depth = 0;
  bool quoted = false;
  for (const char c : list) {
    if (c == '"') quoted = !quoted;
    if (!quoted && expressions) depth += c == '(' || c == '[' ? 1 : c == ')' || c == ']' ? -1 : 0;
    if (c == ',' && !quoted && depth <= 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  if (parts.size() > 1 && parts.back().empty()) parts.pop_back();  // a comma at the end
  return parts;
}

std::string::size_type end_of_name(const std::string& text) {
  bool quoted = false;
  for (std::string::size_type i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    if (text[i] == '=' && !quoted) return i;
  }
  return std::string::npos;
}

std::string name_of(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  if (begin == std::string::npos) return {};
  std::string name = text.substr(begin, end + 1 - begin);
  if (name.size() < 2 || name.front() != '"' || name.back() != '"') return name;
  std::string inner;
  for (std::string::size_type i = 1; i + 1 < name.size(); ++i) {
    if (name[i] == '"' && name[i + 1] == '"' && i + 2 < name.size()) ++i;
    inner += name[i];
  }
  return inner;
}

std::string quoted_name(const std::string& name) {
  if (name.find_first_of(",=\"") == std::string::npos) return name;
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + '"';
}

}  // namespace bgsim::cli
