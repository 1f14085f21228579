#include "base/text.hpp"

#include <array>
#include <charconv>

#include "bgsim/text.hpp"

namespace bgsim {

std::string in_quotes(std::string_view name) { return '"' + short_name(name) + '"'; }

std::string list_of(const std::vector<std::string>& names, const char* last_separator, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == most) return text + ", ...";
    text += (i == 0 ? "" : i + 1 == names.size() ? last_separator : ", ") + in_quotes(names[i]);
  }
  return text;
}

std::string shortest_number(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\n\r";
  const auto begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

}  // namespace bgsim
