/// Values that are written with their unit, "250 kg", which the language refuses: units have a key of their own.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace bgsim {

/// What follows a number and is no operator.
struct UnitBehind {
  std::size_t length = 0;  ///< bytes of it
  std::string situation, help;
  const char* code = "BG181";  ///< BG120 where it is neither a unit nor a prefix of one
};
/// @param text  begins with the number.
/// @param at  where in @p text the number has ended and something else begins.
/// @return none unless it is a unit ("250 kg", "2 [m]", "9.81 m/s^2"), a prefix of one ("10k") or an exponent as other
///         languages write it ("1d-3").
std::optional<UnitBehind> unit_behind(std::string_view text, std::size_t at);

/// "0.01" for "10" and "ms": a time in seconds; none if the unit is none of time.
std::optional<std::string> in_seconds(std::string_view number, std::string_view unit);

/// The unit in "[kg]" or "kg": without brackets and spaces around it.
std::string_view bare_unit(std::string_view text);

}  // namespace bgsim
