/// Units of measurement: what a unit's text means, and a text for what was computed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bgsim {

/// A unit as the product of powers of the SI's base units and a number: bar is 1e5 kg m^-1 s^-2. Angles are pure
/// numbers as in the SI: rad is 1, deg is pi/180. Exponents are doubles: those that occur (halves, thirds, 1.4) are few
/// operations away from integers, and elimination needs no care for overflow.
struct Unit {
  static constexpr std::array<const char*, 7> kBase{"m", "kg", "s", "A", "K", "mol", "cd"};
  std::array<double, 7> exponents{};  ///< of kBase
  double log_scale = 0.0;             ///< natural logarithm of the number
};

Unit operator*(const Unit& a, const Unit& b);
Unit operator/(const Unit& a, const Unit& b);
Unit power(const Unit& unit, double exponent);
Unit second();
Unit watt();

/// The same powers of the base units, whatever the number.
bool same_dimension(const Unit& a, const Unit& b);
/// The same dimension and number. Numbers that differ by less than one in a million are the same: some units are
/// defined by measured values.
bool same_unit(const Unit& a, const Unit& b);
bool is_pure_number(const Unit& unit);

/// What a unit's text means, or what is wrong with it.
struct ParsedUnit {
  std::optional<Unit> unit;
  std::string fault;               ///< where there is no unit: what is wrong
  std::string help;                ///< a fix, if there is one
  std::size_t begin = 0, end = 0;  ///< bytes of the text that are at fault
};

/// Reads "N m", "J/(K mol)", "m^3/s", "kPa", "1/min", "m s^-2", "100 km": names of units with SI prefixes, numbers,
/// products (a space, * or a middle dot), quotients, powers (^ and a number, or a superscript) and parentheses. A
/// division followed by a product ("J/kg K") is read in two ways by different people, and refused.
ParsedUnit parse_unit(std::string_view text);

/// The shortest of the usual ways to write a unit: "N", "m^3/Pa", "kg^0.5/m", "1e5 Pa", "1" for pure numbers.
std::string unit_text(const Unit& unit);

}  // namespace bgsim
