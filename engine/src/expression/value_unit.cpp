#include "expression/value_unit.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "bgsim/unit.hpp"

namespace bgsim {
namespace {

bool is_unit(std::string_view text) { return !text.empty() && parse_unit(text).unit.has_value(); }

/// The first word: up to a space or a sign that no unit's name holds.
std::size_t word_length(std::string_view text) {
  std::size_t length = 0;
  while (length < text.size() &&
         (is_letter(text[length]) || text[length] == '%' || static_cast<unsigned char>(text[length]) >= 0x80))
    ++length;
  return length;
}

struct Power {
  std::string_view prefix;
  int exponent;
};
constexpr std::array kPowers{Power{"f", -15},       Power{"p", -12}, Power{"n", -9}, Power{"u", -6},
                             Power{"\xC2\xB5", -6}, Power{"k", 3},   Power{"M", 6},  Power{"Meg", 6},
                             Power{"meg", 6},       Power{"MEG", 6}, Power{"G", 9}};

std::string power_help(std::string_view number, int exponent) {
  double value = 0.0;
  std::from_chars(number.data(), number.data() + number.size(), value);
  return number_text(value, 6) + "e" + std::to_string(exponent);
}

}  // namespace

std::string_view bare_unit(std::string_view text) {
  text = trimmed(text);
  for (const auto& [open, close] : {std::pair{'[', ']'}, {'{', '}'}, {'(', ')'}, {'\'', '\''}})
    if (text.size() > 2 && text.front() == open && text.back() == close)
      return trimmed(text.substr(1, text.size() - 2));
  return text;
}

std::optional<UnitBehind> unit_behind(std::string_view text, std::size_t at) {
  const std::string number(trimmed(text.substr(0, at)));
  const std::string_view rest = trimmed(text.substr(at));
  if (rest.empty()) return std::nullopt;
  if (is_digit(rest[0]) || (rest[0] == '_' && rest.size() > 1 && is_digit(rest[1])))
    return UnitBehind{rest[0] == '_' ? 2U : 1U, "no operator between " + number + " and " + std::string(rest),
                      "write the digits of a number without gaps, 1000000 or 1e6; write * if a product is meant",
                      "BG120"};
  if (rest.size() > 1 && (rest[0] == 'd' || rest[0] == 'D') &&
      (is_digit(rest[1]) || ((rest[1] == '-' || rest[1] == '+') && rest.size() > 2 && is_digit(rest[2]))))
    return UnitBehind{1, "no operator between " + number + " and " + std::string(rest),
                      "a power of ten is written with e: " + number + "e" + std::string(rest.substr(1)), "BG120"};
  std::string_view unit = rest;  // all that follows, or its first word
  if (!is_unit(bare_unit(unit)) && rest[0] != '[') unit = rest.substr(0, word_length(rest));
  if (unit.empty()) return std::nullopt;
  const std::string_view bare = bare_unit(unit);
  for (const std::string_view celsius : {"\xC2\xB0"
                                         "C",
                                         "degC", "deg C", "Celsius"})
    if (rest.starts_with(celsius))
      return UnitBehind{celsius.size(), "a temperature in degrees follows the number " + number,
                        "temperatures are in K: add 273.15"};
  if (is_unit(bare))
    return UnitBehind{unit.size(), "a unit, " + std::string(bare) + ", follows the number " + number,
                      bare == "m" ? "write the number alone; 1e-3 for the prefix milli" : "write the number alone"};
  for (const Power& power : kPowers)
    if (bare == power.prefix)
      return UnitBehind{unit.size(), "a number is followed by a letter: " + number + std::string(unit),
                        "write " + power_help(number, power.exponent) + " for the power of ten"};
  if (rest[0] != '[') return std::nullopt;
  const auto close = rest.find(']');
  if (close == std::string_view::npos) return std::nullopt;
  return UnitBehind{close + 1, "brackets follow the number " + number,
                    "write the number alone; a unit goes into \"unit\""};
}

std::optional<std::string> in_seconds(std::string_view number, std::string_view unit) {
  const ParsedUnit parsed = parse_unit(unit);
  double value = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc() || end != number.data() + number.size()) return std::nullopt;
  if (!parsed.unit || !same_dimension(*parsed.unit, second())) return std::nullopt;
  return number_text(value * std::exp(parsed.unit->log_scale), 6);
}

}  // namespace bgsim
