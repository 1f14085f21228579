// The tables head, hhea, hmtx and cmap (format 4) of a TrueType file: ISO/IEC 14496-22.
#include "support/font.hpp"

#include <sstream>
#include <stdexcept>

#include "support/files.hpp"

namespace bgsim::test {

namespace {

std::string file_of(const std::string& name) {
  std::istringstream lines(output_of("fc-match -f '%{family}\\n%{file}\\n' '" + name + "'"));
  std::string family, file;
  std::getline(lines, family);
  std::getline(lines, file);
  if (!name.starts_with(family) || family.empty())
    throw std::runtime_error(name + " is not installed (Debian: fonts-liberation); fontconfig offers " + family);
  return file;
}

}  // namespace

Font::Font(const std::string& fontconfig_name) {
  bytes_ = file_text(file_of(fontconfig_name));
  const double unit = 1.0 / static_cast<double>(u16(table("head") + 18));
  const std::size_t cmap = table("cmap");
  for (std::size_t i = 0; i < u16(cmap + 2); ++i)
    if (u16(cmap + 4 + 8 * i) == 3 && u16(cmap + 6 + 8 * i) == 1) map_ = cmap + u32(cmap + 8 + 8 * i);
  if (map_ == 0 || u16(map_) != 4) throw std::runtime_error("no map of characters in " + fontconfig_name);
  const std::size_t last = u16(table("hhea") + 34) - 1, metrics = table("hmtx");
  for (std::size_t c = 0; c < 128; ++c)
    advances_.push_back(unit * static_cast<double>(u16(metrics + 4 * std::min(glyph(c), last))));
}

std::size_t Font::u16(std::size_t at) const {
  if (at + 1 >= bytes_.size()) throw std::runtime_error("a font file that ends early");
  return std::size_t{static_cast<unsigned char>(bytes_[at])} * 256 + static_cast<unsigned char>(bytes_[at + 1]);
}

std::size_t Font::table(const std::string& tag) const {
  for (std::size_t i = 0; i < u16(4); ++i)
    if (bytes_.compare(12 + 16 * i, 4, tag) == 0) return u32(12 + 16 * i + 8);
  throw std::runtime_error("no table " + tag);
}

std::size_t Font::glyph(std::size_t character) const {
  const std::size_t twice = u16(map_ + 6), ends = map_ + 14, starts = ends + twice + 2, deltas = starts + twice,
                    offsets = deltas + twice;
  for (std::size_t i = 0; i < twice; i += 2) {
    if (u16(ends + i) < character) continue;
    if (u16(starts + i) > character) return 0;
    const std::size_t offset = u16(offsets + i);
    return offset == 0 ? (character + u16(deltas + i)) % 65536
                       : u16(offsets + i + offset + 2 * (character - u16(starts + i)));
  }
  return 0;
}

double Font::advance(char c) const { return advances_[static_cast<unsigned char>(c) % 128]; }

double Font::width(const std::string& text, double size) const {
  double sum = 0.0;
  for (const char c : text) sum += advance(c);
  return sum * size;
}

}  // namespace bgsim::test
