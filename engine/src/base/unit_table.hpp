/// The units and prefixes that bgsim knows.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <span>
#include <string_view>

namespace bgsim {

/// A unit as exponents of m, kg, s, A, K, mol, cd and a number.
struct NamedUnit {
  std::string_view name;
  std::array<std::int8_t, 7> exponents;
  double scale = 1.0;
  bool prefixes = false;  ///< takes the prefixes of the SI
};

struct Prefix {
  std::string_view name;
  double scale;
};

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kPoundForce = 4.4482216152605;  ///< 0.45359237 kg in standard gravity
inline constexpr double kInch = 0.0254;

// Numbers are the definitions of the SI brochure (9th edition) and, for units outside it, of NIST SP 811 (2008),
// appendix B.
inline constexpr NamedUnit kUnits[] = {
    // base units
    {"m", {1, 0, 0, 0, 0, 0, 0}, 1.0, true},
    {"g", {0, 1, 0, 0, 0, 0, 0}, 1e-3, true},
    {"s", {0, 0, 1, 0, 0, 0, 0}, 1.0, true},
    {"A", {0, 0, 0, 1, 0, 0, 0}, 1.0, true},
    {"K", {0, 0, 0, 0, 1, 0, 0}, 1.0, true},
    {"mol", {0, 0, 0, 0, 0, 1, 0}, 1.0, true},
    {"cd", {0, 0, 0, 0, 0, 0, 1}, 1.0, true},
    // pure numbers; a turn is 2 pi rad
    {"rad", {}, 1.0, true},
    {"sr", {}, 1.0},
    {"deg", {}, kPi / 180.0},
    {"\xC2\xB0", {}, kPi / 180.0},
    {"rev", {}, 2.0 * kPi},
    {"turn", {}, 2.0 * kPi},
    {"%", {}, 1e-2},
    {"ppm", {}, 1e-6},
    // derived units with names
    {"N", {1, 1, -2, 0, 0, 0, 0}, 1.0, true},
    {"Pa", {-1, 1, -2, 0, 0, 0, 0}, 1.0, true},
    {"J", {2, 1, -2, 0, 0, 0, 0}, 1.0, true},
    {"W", {2, 1, -3, 0, 0, 0, 0}, 1.0, true},
    {"V", {2, 1, -3, -1, 0, 0, 0}, 1.0, true},
    {"C", {0, 0, 1, 1, 0, 0, 0}, 1.0, true},
    {"F", {-2, -1, 4, 2, 0, 0, 0}, 1.0, true},
    {"Ohm", {2, 1, -3, -2, 0, 0, 0}, 1.0, true},
    {"ohm", {2, 1, -3, -2, 0, 0, 0}, 1.0, true},
    {"\xCE\xA9", {2, 1, -3, -2, 0, 0, 0}, 1.0, true},      // Greek capital omega
    {"\xE2\x84\xA6", {2, 1, -3, -2, 0, 0, 0}, 1.0, true},  // ohm sign
    {"S", {-2, -1, 3, 2, 0, 0, 0}, 1.0, true},
    {"Wb", {2, 1, -2, -1, 0, 0, 0}, 1.0, true},
    {"T", {0, 1, -2, -1, 0, 0, 0}, 1.0, true},
    {"H", {2, 1, -2, -2, 0, 0, 0}, 1.0, true},
    {"Hz", {0, 0, -1, 0, 0, 0, 0}, 1.0, true},
    {"Bq", {0, 0, -1, 0, 0, 0, 0}, 1.0, true},
    {"Gy", {2, 0, -2, 0, 0, 0, 0}, 1.0, true},
    {"kat", {0, 0, -1, 0, 0, 1, 0}, 1.0, true},
    {"lm", {0, 0, 0, 0, 0, 0, 1}, 1.0, true},
    {"lx", {-2, 0, 0, 0, 0, 0, 1}, 1.0, true},
    {"VA", {2, 1, -3, 0, 0, 0, 0}, 1.0, true},
    // time
    {"sec", {0, 0, 1, 0, 0, 0, 0}},
    {"min", {0, 0, 1, 0, 0, 0, 0}, 60.0},
    {"h", {0, 0, 1, 0, 0, 0, 0}, 3600.0},
    {"d", {0, 0, 1, 0, 0, 0, 0}, 86400.0},
    {"day", {0, 0, 1, 0, 0, 0, 0}, 86400.0},
    {"year", {0, 0, 1, 0, 0, 0, 0}, 31557600.0},  // Julian
    {"rpm", {0, 0, -1, 0, 0, 0, 0}, 2.0 * kPi / 60.0},
    // length, area, volume, speed
    {"L", {3, 0, 0, 0, 0, 0, 0}, 1e-3, true},
    {"l", {3, 0, 0, 0, 0, 0, 0}, 1e-3, true},
    {"ha", {2, 0, 0, 0, 0, 0, 0}, 1e4},
    {"in", {1, 0, 0, 0, 0, 0, 0}, kInch},
    {"ft", {1, 0, 0, 0, 0, 0, 0}, 12.0 * kInch},
    {"mi", {1, 0, 0, 0, 0, 0, 0}, 1609.344},
    {"gal", {3, 0, 0, 0, 0, 0, 0}, 231.0 * kInch* kInch* kInch},
    {"mph", {1, 0, -1, 0, 0, 0, 0}, 0.44704},
    {"kn", {1, 0, -1, 0, 0, 0, 0}, 1852.0 / 3600.0},
    // mass, force, pressure, viscosity
    {"t", {0, 1, 0, 0, 0, 0, 0}, 1e3, true},
    {"Da", {0, 1, 0, 0, 0, 0, 0}, 1.66053906660e-27, true},
    {"lb", {0, 1, 0, 0, 0, 0, 0}, 0.45359237},
    {"lbf", {1, 1, -2, 0, 0, 0, 0}, kPoundForce},
    {"kgf", {1, 1, -2, 0, 0, 0, 0}, 9.80665},
    {"dyn", {1, 1, -2, 0, 0, 0, 0}, 1e-5},
    {"bar", {-1, 1, -2, 0, 0, 0, 0}, 1e5, true},
    {"atm", {-1, 1, -2, 0, 0, 0, 0}, 101325.0},
    {"Torr", {-1, 1, -2, 0, 0, 0, 0}, 101325.0 / 760.0},
    {"mmHg", {-1, 1, -2, 0, 0, 0, 0}, 133.322387415},
    {"psi", {-1, 1, -2, 0, 0, 0, 0}, kPoundForce / (kInch * kInch)},
    {"P", {-1, 1, -1, 0, 0, 0, 0}, 0.1, true},
    {"St", {2, 0, -1, 0, 0, 0, 0}, 1e-4, true},
    // energy, power, charge, field
    {"eV", {2, 1, -2, 0, 0, 0, 0}, 1.602176634e-19, true},
    {"cal", {2, 1, -2, 0, 0, 0, 0}, 4.184, true},
    {"erg", {2, 1, -2, 0, 0, 0, 0}, 1e-7},
    {"Wh", {2, 1, -2, 0, 0, 0, 0}, 3600.0, true},
    {"hp", {2, 1, -3, 0, 0, 0, 0}, 550.0 * 12.0 * kInch* kPoundForce},
    {"Ah", {0, 0, 1, 1, 0, 0, 0}, 3600.0, true},
    {"gauss", {0, 1, -2, -1, 0, 0, 0}, 1e-4},
};

inline constexpr Prefix kPrefixes[] = {
    {"Q", 1e30},  {"R", 1e27},  {"Y", 1e24},  {"Z", 1e21},  {"E", 1e18},        {"P", 1e15},        {"T", 1e12},
    {"G", 1e9},   {"M", 1e6},   {"k", 1e3},   {"h", 1e2},   {"da", 1e1},        {"d", 1e-1},        {"c", 1e-2},
    {"m", 1e-3},  {"u", 1e-6},  {"n", 1e-9},  {"p", 1e-12}, {"\xC2\xB5", 1e-6}, {"\xCE\xBC", 1e-6}, {"f", 1e-15},
    {"a", 1e-18}, {"z", 1e-21}, {"y", 1e-24}, {"r", 1e-27}, {"q", 1e-30},
};

/// A unit's name without and with a prefix. A whole name goes before a prefixed one: min is the minute, cd the candela.
struct FoundUnit {
  const NamedUnit* unit = nullptr;
  double prefix = 1.0;
};

constexpr FoundUnit find_unit(std::string_view name) {
  for (const NamedUnit& unit : kUnits)
    if (unit.name == name) return {&unit, 1.0};
  for (const Prefix& prefix : kPrefixes) {
    if (!name.starts_with(prefix.name)) continue;
    const std::string_view rest = name.substr(prefix.name.size());
    for (const NamedUnit& unit : kUnits)
      if (unit.prefixes && unit.name == rest) return {&unit, prefix.scale};
  }
  return {};
}
static_assert(find_unit("min").prefix == 1.0 && find_unit("kg").prefix == 1e3);

}  // namespace bgsim
