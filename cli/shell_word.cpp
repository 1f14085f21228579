#include "shell_word.hpp"

#include <array>
#include <cstdio>

#include "bgsim/text.hpp"

namespace bgsim::cli {

namespace {

/// In $'...': each byte of a character without a shape by its number.
std::string numbered(std::string_view word) {
  std::string text = "$'";
  for_each_character(word, [&](std::string_view bytes, long) {
    if (bytes == "'" || bytes == "\\")
      text.append("\\").append(bytes);
    else if (visible_line(bytes) == bytes)
      text += bytes;
    else
      for (const char c : bytes) {
        std::array<char, 8> code{};
        std::snprintf(code.data(), code.size(), "\\%03o", static_cast<unsigned>(static_cast<unsigned char>(c)));
        text += code.data();
      }
  });
  return text + "'";
}

}  // namespace

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) return std::string(word);
  if (visible_line(word) != word) return numbered(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace bgsim::cli
