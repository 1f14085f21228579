#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "base/unit_table.hpp"
#include "bgsim/diagnostic.hpp"
#include "bgsim/unit.hpp"

namespace bgsim {

namespace {

constexpr std::pair<std::string_view, std::string_view> kWords[] = {
    {"metre", "m"},   {"meter", "m"},  {"gram", "g"},     {"kilogram", "kg"},     {"second", "s"},  {"ampere", "A"},
    {"amp", "A"},     {"kelvin", "K"}, {"mole", "mol"},   {"newton", "N"},        {"pascal", "Pa"}, {"joule", "J"},
    {"watt", "W"},    {"volt", "V"},   {"coulomb", "C"},  {"farad", "F"},         {"weber", "Wb"},  {"tesla", "T"},
    {"henry", "H"},   {"hertz", "Hz"}, {"siemens", "S"},  {"litre", "L"},         {"liter", "L"},   {"minute", "min"},
    {"hour", "h"},    {"hr", "h"},     {"degree", "deg"}, {"radian", "rad"},      {"inch", "in"},   {"foot", "ft"},
    {"percent", "%"}, {"yr", "year"},  {"none", "1"},     {"dimensionless", "1"},
};

Unit unit_of(const FoundUnit& found) {
  Unit unit;
  for (std::size_t i = 0; i < unit.exponents.size(); ++i) unit.exponents[i] = found.unit->exponents[i];
  unit.log_scale = std::log(found.unit->scale * found.prefix);
  return unit;
}

/// A name without prefix, or the kilogram.
bool is_plain_name(std::string_view name) {
  const FoundUnit found = find_unit(name);
  return found.unit != nullptr && (found.prefix == 1.0 || name == "kg");
}

/// What a name that is no unit was probably meant to be.
std::string suggestion_for(std::string_view name) {
  for (std::size_t i = 1; i < name.size(); ++i)
    if (is_plain_name(name.substr(0, i)) && is_plain_name(name.substr(i)))
      return "products are written with a space: did you mean " +
             in_quotes(std::string(name.substr(0, i)) + " " + std::string(name.substr(i))) + "?";
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [word, symbol] : kWords)
    if (lower == word || lower == std::string(word) + "s") return "did you mean " + in_quotes(symbol) + "?";
  std::vector<std::string> candidates{"kg", "mm", "km",   "kPa", "MPa", "kN", "kW",
                                      "kJ", "mA", "kOhm", "kHz", "mH",  "uF"};
  for (const NamedUnit& unit : kUnits) candidates.emplace_back(unit.name);
  const std::string nearest = nearest_name(std::string(name), candidates);
  return nearest.empty() ? "" : "did you mean " + in_quotes(nearest) + "?";
}

class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  ParsedUnit parse() {
    const Unit unit = product(0);
    if (result_.fault.empty() && at_ < text_.size()) fail(at_, at_ + 1, "a unit cannot go on with this sign");
    if (result_.fault.empty()) result_.unit = unit;
    return std::move(result_);
  }

 private:
  static constexpr int kDeepest = 20;

  Unit fail(std::size_t begin, std::size_t end, std::string fault, std::string help = {}) {
    if (result_.fault.empty()) result_ = {std::nullopt, std::move(fault), std::move(help), begin, end};
    at_ = text_.size();
    return {};
  }

  bool take(std::string_view sign) {
    if (!text_.substr(at_).starts_with(sign)) return false;
    at_ += sign.size();
    return true;
  }
  bool skip_spaces() {
    const std::size_t before = at_;
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    return at_ > before;
  }
  [[nodiscard]] bool ends() const { return at_ >= text_.size() || text_[at_] == ')'; }

  /// Factors with products and quotients between them.
  Unit product(int depth) {
    skip_spaces();
    Unit unit = factor(depth);
    bool divided = false;
    while (true) {
      const bool spaces = skip_spaces();
      if (ends()) return unit;
      const std::size_t here = at_;
      if (take("/")) {
        divided = true;
        skip_spaces();
        unit = unit / factor(depth);
        continue;
      }
      const bool sign = take("**") ? false : take("*") || take("\xC2\xB7") || take("\xE2\x8B\x85") || take(".");
      if (!sign && !spaces && text_[here] != '(') return fail(here, here + 1, "a unit cannot go on with this sign");
      if (divided)
        return fail(0, text_.size(), "a product after a division is ambiguous",
                    "use parentheses: \"J/(kg K)\", or put the division last: \"N m/rad\"");
      skip_spaces();
      unit = unit * factor(depth);
    }
  }

  Unit factor(int depth) {
    if (ends()) return fail(at_, at_ + 1, "a unit is missing here");
    Unit unit;
    const std::size_t begin = at_;
    if (take("(")) {
      if (depth == kDeepest) return fail(begin, at_, "parentheses are nested too deep");
      unit = product(depth + 1);
      if (result_.fault.empty() && !take(")")) return fail(begin, begin + 1, "a parenthesis is not closed");
    } else if (std::isdigit(static_cast<unsigned char>(text_[at_])) != 0) {
      const std::optional<double> value = number();
      if (!value || !(*value > 0.0)) return fail(begin, at_, "a factor in a unit is a number above zero");
      unit.log_scale = std::log(*value);
    } else {
      unit = name();
    }
    return exponent(unit);
  }

  std::optional<double> number() {
    double value = 0.0;
    const char* const end = text_.data() + text_.size();
    const auto [stop, fault] = std::from_chars(text_.data() + at_, end, value);
    if (fault != std::errc{} || !std::isfinite(value)) return std::nullopt;
    at_ = static_cast<std::size_t>(stop - text_.data());
    return value;
  }

  Unit name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && in_name()) ++at_;
    const std::string_view name = text_.substr(begin, at_ - begin);
    if (name.empty()) return fail(at_, at_ + 1, "a unit cannot go on with this sign");
    const FoundUnit found = find_unit(name);
    if (found.unit == nullptr) {
      if (name == "degC" || name == "\xC2\xB0\x43" || name == "degF" || name == "\xC2\xB0\x46")
        return fail(begin, at_, in_quotes(name) + " has another zero than K, and numbers are used as they are written",
                    "give temperatures in K; a difference of 1 " + std::string(name) + " is " +
                        (name.back() == 'C' ? "1 K" : "5/9 K"));
      return fail(begin, at_, in_quotes(name) + " is not a known unit", suggestion_for(name));
    }
    const std::size_t digit = at_ < text_.size() && text_[at_] == '-' ? at_ + 1 : at_;
    if (digit < text_.size() && std::isdigit(static_cast<unsigned char>(text_[digit])) != 0)
      return fail(begin, text_.size(), "a number follows a unit's name",
                  "powers are written with ^: " + in_quotes(std::string(name) + "^" + std::string(text_.substr(at_))));
    return unit_of(found);
  }
  /// Letters, %, and whatever is written in more than one byte, but for superscripts and dots.
  [[nodiscard]] bool in_name() const {
    const auto byte = static_cast<unsigned char>(text_[at_]);
    if (byte < 0x80) return std::isalpha(byte) != 0 || byte == '%' || byte == '_';
    const std::string_view rest = text_.substr(at_);
    for (const std::string_view other : {"\xC2\xB2", "\xC2\xB3", "\xC2\xB9", "\xC2\xB7", "\xE2\x8B\x85", "\xE2\x81"})
      if (rest.starts_with(other)) return false;
    return true;
  }

  Unit exponent(const Unit& unit) {
    if (const std::optional<double> raised = superscript()) return power(unit, *raised);
    const std::size_t begin = at_;
    if (!take("^") && !take("**")) return unit;
    const bool parenthesis = take("(");
    const bool minus = take("-");
    std::optional<double> value = number();
    if (value && parenthesis && take("/")) {
      const std::optional<double> below = number();
      value = below && *below != 0.0 ? std::optional(*value / *below) : std::nullopt;
    }
    if (value && parenthesis && !take(")")) value.reset();
    if (!value || std::abs(*value) > 100.0)
      return fail(begin, begin + 1, "an exponent is a number: \"m^2\", \"s^-1\", \"Pa^(1/2)\"");
    return power(unit, minus ? -*value : *value);
  }

  std::optional<double> superscript() {
    bool minus = false, any = false;
    double value = 0.0;
    while (true) {
      int digit = -1;
      const std::string_view rest = text_.substr(at_);
      if (rest.starts_with("\xE2\x81\xBB") && !any && !minus) {
        minus = true;
        at_ += 3;
        continue;
      }
      if (rest.starts_with("\xC2\xB9")) digit = 1;
      if (rest.starts_with("\xC2\xB2")) digit = 2;
      if (rest.starts_with("\xC2\xB3")) digit = 3;
      if (digit > 0) {
        at_ += 2;
      } else if (rest.size() > 2 && rest.starts_with("\xE2\x81")) {
        digit = static_cast<unsigned char>(rest[2]) - 0xB0;
        if (digit < 0 || digit > 9) break;
        at_ += 3;
      } else {
        break;
      }
      any = true;
      value = 10.0 * value + digit;
    }
    if (!any) return std::nullopt;
    return minus ? -value : value;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  ParsedUnit result_;
};

}  // namespace

ParsedUnit parse_unit(std::string_view text) { return UnitParser(text).parse(); }

}  // namespace bgsim
