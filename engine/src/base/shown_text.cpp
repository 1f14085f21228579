#include "base/shown_text.hpp"

#include <string_view>

namespace bgsim {

bool shows_text(const Document& file) {
  if (file.is_users()) return true;
  constexpr std::string_view kKey = "\"bgsim\"";
  const std::string_view text = file.text();
  for (auto at = text.find(kKey); at != std::string_view::npos; at = text.find(kKey, at + 1)) {
    const auto after = text.find_first_not_of(" \t\r\n", at + kKey.size());
    if (after != std::string_view::npos && text[after] == ':') return true;
  }
  return false;
}

}  // namespace bgsim
