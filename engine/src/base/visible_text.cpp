#include <algorithm>
#include <array>
#include <cstdio>

#include "bgsim/text.hpp"

namespace bgsim {

namespace {

struct Span {
  long first, last;
};

template <std::size_t n>
bool within(long code, const std::array<Span, n>& spans) {
  return std::any_of(spans.begin(), spans.end(), [&](Span s) { return code >= s.first && code <= s.last; });
}

/// What has no shape: controls, the marks of direction, of joining and of nothing, separators, tags and noncharacters.
/// The zero-width joiners U+200C and U+200D stay, since words of Persian and Hindi are not written without them.
bool is_shapeless(long code) {
  static constexpr std::array<Span, 15> kShapeless{{{0x00, 0x1F},
                                                    {0x7F, 0x9F},
                                                    {0xAD, 0xAD},
                                                    {0x61C, 0x61C},
                                                    {0x180E, 0x180E},
                                                    {0x200B, 0x200B},
                                                    {0x200E, 0x200F},
                                                    {0x2028, 0x202E},
                                                    {0x2060, 0x206F},
                                                    {0xFDD0, 0xFDEF},
                                                    {0xFEFF, 0xFEFF},
                                                    {0xFFF0, 0xFFFB},
                                                    {0xE0000, 0xE0FFF},
                                                    {0x115F, 0x1160},
                                                    {0x3164, 0x3164}}};
  return within(code, kShapeless) || (code & 0xFFFE) == 0xFFFE;
}

/// Marks that are set above or below the letter before them.
bool is_combining(long code) {
  static constexpr std::array<Span, 5> kCombining{
      {{0x300, 0x36F}, {0x1AB0, 0x1AFF}, {0x1DC0, 0x1DFF}, {0x20D0, 0x20FF}, {0xFE20, 0xFE2F}}};
  return within(code, kCombining);
}

std::string escape(const char* format, unsigned long value) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string escape(std::string_view bytes, long code) {
  if (code == '\n') return "\\n";
  if (code == '\r') return "\\r";
  if (code == '\t') return "\\t";
  if (code < 0x80) return escape("\\x%02lx", static_cast<unsigned char>(bytes.front()));
  return escape("\\u{%lx}", static_cast<unsigned long>(code));
}

std::string written_out(std::string_view text, bool keep_lines) {
  constexpr int kMostMarks = 4;
  std::string result;
  result.reserve(text.size());
  int marks = 0;
  for_each_character(text, [&](std::string_view bytes, long code) {
    marks = is_combining(code) ? marks + 1 : 0;
    const bool line_break = keep_lines && (code == '\n' || code == '\t');
    const bool before_line_feed =
        keep_lines && code == '\r' && bytes.data() + 1 < text.data() + text.size() && bytes.data()[1] == '\n';
    if (before_line_feed) return;
    if (!line_break && (code < 0 || is_shapeless(code) || marks > kMostMarks))
      result += escape(bytes, code);
    else
      result += bytes;
  });
  return result;
}

}  // namespace

std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.empty()) return 0;
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  // Forms longer than needed, surrogates, and what lies beyond U+10FFFF.
  if ((first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F)) return 0;
  if ((first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) > 0x8F)) return 0;
  return length;
}

void for_each_character(std::string_view text, const std::function<void(std::string_view bytes, long code)>& take) {
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (length == 0) {
      take(text.substr(0, 1), -1);
      text.remove_prefix(1);
      continue;
    }
    constexpr std::array<unsigned, 5> kPayload{0, 0x7F, 0x1F, 0x0F, 0x07};
    long code = static_cast<unsigned char>(text[0]) & kPayload[length];
    for (std::size_t i = 1; i < length; ++i) code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3FU);
    take(text.substr(0, length), code);
    text.remove_prefix(length);
  }
}

std::string visible_text(std::string_view text) { return written_out(text, true); }

std::string visible_line(std::string_view text) { return written_out(text, false); }

std::size_t character_count(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::string short_line(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return visible_line(text);
  const std::size_t length = character_count(text);
  if (length <= longest && text.size() <= 4 * longest) return visible_line(text);
  const auto inside = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U; };
  std::size_t head = 2 * longest / 3, tail = text.size() - longest / 6;
  for (int i = 0; i < 3 && head > 0 && inside(head); ++i) --head;
  for (int i = 0; i < 3 && tail < text.size() && inside(tail); ++i) ++tail;
  return visible_line(text.substr(0, head)) + "..." + visible_line(text.substr(tail)) + " (" + std::to_string(length) +
         " characters)";
}

std::string short_name(std::string_view name) { return short_line(name, 120); }

std::string short_path(std::string_view path) { return short_line(path, 1000); }

std::string number_text(double value, int digits) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

}  // namespace bgsim
