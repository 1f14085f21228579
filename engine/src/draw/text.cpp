// Widths of texts, by the advances in the font files of Liberation Sans and Serif (those of Arial and Times New Roman):
// what is laid out by them fits as it is drawn, in these fonts and in every font of their measure.
#include <array>

#include "draw/shapes.hpp"

namespace bgsim {

namespace {

using Advances = std::array<std::uint16_t, 95>;  // of the characters from blank to ~, in 1/2048 em

constexpr Advances kSans{569,  569,  727,  1139, 1139, 1821, 1366, 391,  682,  682,  797,  1196, 569,  682,  569,  569,
                         1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 569,  569,  1196, 1196, 1196, 1139,
                         2079, 1366, 1366, 1479, 1479, 1366, 1251, 1593, 1479, 569,  1024, 1366, 1139, 1706, 1479, 1593,
                         1366, 1593, 1479, 1366, 1251, 1479, 1366, 1933, 1366, 1366, 1251, 569,  569,  569,  961,  1139,
                         682,  1139, 1139, 1024, 1139, 1139, 569,  1139, 1139, 455,  455,  1024, 455,  1706, 1139, 1139,
                         1139, 1139, 682,  1024, 569,  1139, 1024, 1479, 1024, 1024, 1024, 684,  532,  684,  1196};
constexpr Advances kBold{569,  682,  971,  1139, 1139, 1821, 1479, 487,  682,  682,  797,  1196, 569,  682,  569,  569,
                         1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 1139, 682,  682,  1196, 1196, 1196, 1251,
                         1997, 1479, 1479, 1479, 1479, 1366, 1251, 1593, 1479, 569,  1139, 1479, 1251, 1706, 1479, 1593,
                         1366, 1593, 1479, 1366, 1251, 1479, 1366, 1933, 1366, 1366, 1251, 682,  569,  682,  1196, 1139,
                         682,  1139, 1251, 1139, 1251, 1139, 682,  1251, 1251, 569,  569,  1139, 569,  1821, 1251, 1251,
                         1251, 1251, 797,  1139, 682,  1251, 1139, 1593, 1139, 1139, 1024, 797,  573,  797,  1196};
constexpr Advances kSerif{
    512,  682,  836,  1024, 1024, 1706, 1593, 369,  682,  682,  1024, 1155, 512,  682,  512,  569,  1024, 1024, 1024,
    1024, 1024, 1024, 1024, 1024, 1024, 1024, 569,  569,  1155, 1155, 1155, 909,  1886, 1479, 1366, 1366, 1479, 1251,
    1139, 1479, 1479, 682,  797,  1479, 1251, 1821, 1479, 1479, 1139, 1479, 1366, 1139, 1251, 1479, 1479, 1933, 1479,
    1479, 1251, 682,  569,  682,  961,  1024, 682,  909,  1024, 909,  1024, 909,  682,  1024, 1024, 569,  569,  1024,
    569,  1593, 1024, 1024, 1024, 1024, 682,  797,  569,  1024, 1024, 1479, 1024, 1024, 909,  983,  410,  983,  1108};

constexpr double kUnits = 2048.0;
constexpr double kWidest = 2253.0;  // 1.1 em: no letter beyond ASCII is wider in these fonts

const Advances& advances(Face face) {
  switch (face) {
    case Face::bold:
      return kBold;
    case Face::serif:
      return kSerif;
    case Face::sans:
      break;
  }
  return kSans;
}

}  // namespace

double text_width(const std::string& text, double size, Face face) {
  const Advances& advance = advances(face);
  double units = 0.0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) == 0x80U) continue;  // inside a UTF-8 character
    units += byte >= 0x20U && byte < 0x7FU ? advance[byte - 0x20U] : kWidest;
  }
  return units / kUnits * size;
}

bool exact_width(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20U || static_cast<unsigned char>(c) >= 0x7FU) return false;
  return true;
}

}  // namespace bgsim
