#include "text_buffer.hpp"

#include <algorithm>
#include <string_view>

#include "bgsim/text.hpp"

namespace bgsim::cli {

namespace {

/// Bytes at the end of @p text that more bytes may make a character of, or a line end.
std::size_t open_end(std::string_view text) {
  if (text.ends_with('\r')) return 1;
  for (std::size_t count = 1; count <= std::min<std::size_t>(3, text.size()); ++count) {
    const auto byte = static_cast<unsigned char>(text[text.size() - count]);
    if ((byte & 0xC0U) == 0x80U) continue;  // the middle of a character
    const std::size_t length = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : byte >= 0xC0 ? 2 : 1;
    return length > count ? count : 0;
  }
  return 0;
}

}  // namespace

bool TextBuffer::write(std::string_view text) {
  const std::string visible = visible_text(text);
  const auto count = static_cast<std::streamsize>(visible.size());
  return to_->sputn(visible.data(), count) == count;
}

std::streamsize TextBuffer::xsputn(const char* text, std::streamsize count) {
  held_.append(text, static_cast<std::size_t>(count));
  const std::size_t whole = held_.size() - open_end(held_);
  const bool written = write(std::string_view(held_).substr(0, whole));
  held_.erase(0, whole);
  return written ? count : 0;
}

TextBuffer::int_type TextBuffer::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char one = traits_type::to_char_type(c);
  return xsputn(&one, 1) == 1 ? c : traits_type::eof();
}

int TextBuffer::sync() {
  const bool written = held_.empty() || write(held_);
  held_.clear();
  return to_->pubsync() == 0 && written ? 0 : -1;
}

}  // namespace bgsim::cli
