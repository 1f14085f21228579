#include "bgsim/unit.hpp"

#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "base/unit_table.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

constexpr double kSameExponent = 1e-6;
constexpr double kSameScale = 1e-6;

constexpr std::string_view kMass = "kg";

/// Units that others are written with. Of two equally short ways the first one is used.
constexpr const char* kDerived[] = {"N", "Pa", "J", "W", "V", "C", "F", "Ohm", "S", "Wb", "H", "T"};

/// A factor of a unit's text: a name and its exponent.
struct Factor {
  std::string name;
  double exponent = 1.0;
};

std::string exponent_text(double value) {
  const double rounded = std::round(value);
  if (std::abs(value - rounded) < kSameExponent) return number_text(rounded, 6);
  return number_text(value, 6);
}

/// "kg m/s^2", "1/(K mol)".
std::string joined(const std::vector<Factor>& factors) {
  std::string above, below;
  std::size_t divisors = 0;
  for (const Factor& factor : factors) {
    std::string& text = factor.exponent > 0.0 ? above : below;
    const double exponent = std::abs(factor.exponent);
    if (factor.exponent < 0.0) ++divisors;
    text += (text.empty() ? "" : " ") + factor.name;
    if (std::abs(exponent - 1.0) > kSameExponent) text += "^" + exponent_text(exponent);
  }
  if (above.empty()) above = "1";
  if (divisors == 0) return above;
  return above + "/" + (divisors == 1 ? below : "(" + below + ")");
}

/// How long the base units of a text are to read: a name counts one, and so does each power. kg beside a derived unit
/// counts more, so that an acceleration is m/s^2 and not N/kg.
double base_length(const Unit& unit, bool derived) {
  double sum = 0.0;
  for (std::size_t i = 0; i < unit.exponents.size(); ++i)
    if (const double size = std::abs(unit.exponents[i]); size > kSameExponent)
      sum += 1.0 + size + (derived && Unit::kBase[i] == kMass ? 1.5 : 0.0);
  return sum;
}

/// Base units, kg first: "kg m^2/s".
std::vector<Factor> base_factors(const Unit& unit) {
  constexpr std::array<std::size_t, 7> kOrder{1, 0, 2, 3, 4, 5, 6};
  std::vector<Factor> factors;
  for (const std::size_t i : kOrder)
    if (std::abs(unit.exponents[i]) > kSameExponent) factors.push_back({Unit::kBase[i], unit.exponents[i]});
  return factors;
}

struct Derived {
  const char* name;
  Unit unit;
};
const std::vector<Derived>& derived_units() {
  static const std::vector<Derived> kUnitsOf = [] {
    std::vector<Derived> units;
    for (const char* name : kDerived) units.push_back({name, *parse_unit(name).unit});
    return units;
  }();
  return kUnitsOf;
}

/// The best of the texts with base units only, with one derived unit, and with two.
std::vector<Factor> shortest(const Unit& unit) {
  std::vector<Factor> best = base_factors(unit);
  double best_length = base_length(unit, false);
  using Named = std::pair<const char*, double>;
  const auto consider = [&](std::initializer_list<Named> names, const Unit& rest) {
    double length = base_length(rest, true);
    for (const auto& [name, exponent] : names) length += 1.0 + std::abs(exponent);
    if (length > best_length - 1e-9) return;
    best_length = length;
    best.clear();
    for (const auto& [name, exponent] : names)
      if (exponent == 1.0) best.push_back({name, exponent});
    for (Factor& factor : base_factors(rest)) best.push_back(std::move(factor));
    for (const auto& [name, exponent] : names)
      if (exponent != 1.0) best.push_back({name, exponent});
  };
  bool kinematic = true;  // only m and s: nobody writes m^3/s as W/Pa
  for (std::size_t i = 0; i < unit.exponents.size(); ++i)
    if (i != 0 && i != 2 && std::abs(unit.exponents[i]) > kSameExponent) kinematic = false;
  if (kinematic) return best;
  for (const Derived& derived : derived_units())
    for (const double exponent : {1.0, -1.0, 2.0})
      consider({{derived.name, exponent}}, unit / power(derived.unit, exponent));
  for (const double exponent : {0.5, -0.5})  // orifices
    consider({{"Pa", exponent}}, unit / power(derived_units()[1].unit, exponent));
  for (const Derived& a : derived_units())
    for (const Derived& b : derived_units())
      if (a.name != b.name) consider({{a.name, 1.0}, {b.name, 1.0}}, unit / a.unit / b.unit);
  return best;
}

/// "kPa", "mm", "kJ/K": a name to the power 1 in front takes the scale as a prefix; else empty.
std::string with_prefix(std::vector<Factor> factors, double log_scale) {
  if (factors.empty() || factors.front().exponent != 1.0) return {};
  const bool mass = factors.front().name == "kg";
  if (mass) factors.front().name = "g";
  const double scale = std::exp(log_scale) * (mass ? 1e3 : 1.0);
  if (std::abs(scale - 1.0) < kSameScale) return joined(factors);
  for (const Prefix& prefix : kPrefixes) {
    if (std::abs(scale / prefix.scale - 1.0) > kSameScale) continue;
    factors.front().name.insert(0, prefix.name);
    return joined(factors);
  }
  return {};
}

}  // namespace

Unit operator*(const Unit& a, const Unit& b) {
  Unit unit = a;
  for (std::size_t i = 0; i < unit.exponents.size(); ++i) unit.exponents[i] += b.exponents[i];
  unit.log_scale += b.log_scale;
  return unit;
}

Unit operator/(const Unit& a, const Unit& b) { return a * power(b, -1.0); }

Unit power(const Unit& unit, double exponent) {
  Unit result = unit;
  for (double& e : result.exponents) e *= exponent;
  result.log_scale *= exponent;
  return result;
}

Unit second() { return {{0, 0, 1, 0, 0, 0, 0}, 0.0}; }
Unit watt() { return {{2, 1, -3, 0, 0, 0, 0}, 0.0}; }

bool same_dimension(const Unit& a, const Unit& b) {
  for (std::size_t i = 0; i < a.exponents.size(); ++i)
    if (std::abs(a.exponents[i] - b.exponents[i]) > kSameExponent) return false;
  return true;
}

bool same_unit(const Unit& a, const Unit& b) {
  return same_dimension(a, b) && std::abs(a.log_scale - b.log_scale) < kSameScale;
}

bool is_pure_number(const Unit& unit) { return same_unit(unit, {}); }

std::string unit_text(const Unit& unit) {
  std::string text = joined(shortest(unit));
  if (std::abs(unit.log_scale) < kSameScale) return text;
  // A unit with a name of its own: bar, min, deg. In the table's order, which has the common ones first.
  for (const NamedUnit& named : kUnits) {
    if (named.scale == 1.0) continue;
    const ParsedUnit other = parse_unit(named.name);
    if (other.unit && same_unit(*other.unit, unit)) return std::string(named.name);
  }
  if (std::string prefixed = with_prefix(shortest(unit), unit.log_scale); !prefixed.empty()) return prefixed;
  const std::string number = number_text(std::exp(unit.log_scale), 6);
  if (text.starts_with("1/")) return number + text.substr(1);
  return text == "1" ? number : number + " " + text;
}

}  // namespace bgsim
