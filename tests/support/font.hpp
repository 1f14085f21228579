/// Widths of texts by a font's own file, so that drawings are measured by what draws them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace bgsim::test {

/// A TrueType font that is installed.
class Font {
 public:
  /// @throws std::runtime_error  the font is not installed, or is none that can be read here.
  explicit Font(const std::string& fontconfig_name);
  /// Of ASCII; in px.
  [[nodiscard]] double width(const std::string& text, double size) const;
  [[nodiscard]] double advance(char c) const;  ///< in em

 private:
  [[nodiscard]] std::size_t u16(std::size_t at) const;
  [[nodiscard]] std::size_t u32(std::size_t at) const { return (u16(at) << 16U) + u16(at + 2); }
  [[nodiscard]] std::size_t table(const std::string& tag) const;
  [[nodiscard]] std::size_t glyph(std::size_t character) const;

  std::string bytes_;
  std::size_t map_ = 0;  ///< of characters to glyphs, format 4
  std::vector<double> advances_;
};

}  // namespace bgsim::test
