#include "linear/symbolic.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"

namespace bgsim {

namespace {

Powers multiplied(const Powers& a, const Powers& b) {
  Powers result;
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->first < j->first)) {
      result.push_back(*i++);
    } else if (i == a.end() || j->first < i->first) {
      result.push_back(*j++);
    } else {
      if (i->second + j->second != 0) result.emplace_back(i->first, i->second + j->second);
      ++i;
      ++j;
    }
  }
  return result;
}

Powers inverted(Powers powers) {
  for (auto& [atom, exponent] : powers) exponent = -exponent;
  return powers;
}

int exponent_of(const Powers& powers, Atom atom) {
  for (const auto& [own, exponent] : powers)
    if (own == atom) return exponent;
  return 0;
}

/// The lowest power of each atom in all terms.
Powers common_powers(const PowerSum& sum) {
  std::map<Atom, int> least;
  for (const auto& [powers, coefficient] : sum)
    for (const auto& [atom, exponent] : powers) least.emplace(atom, exponent);
  for (auto& [atom, exponent] : least)
    for (const auto& [powers, coefficient] : sum) exponent = std::min(exponent, exponent_of(powers, atom));
  Powers result;
  for (const auto& [atom, exponent] : least)
    if (exponent != 0) result.emplace_back(atom, exponent);
  return result;
}

void add_term(PowerSum& sum, const Powers& powers, const ExactNumber& coefficient) {
  const auto [at, fresh] = sum.try_emplace(powers, coefficient);
  if (fresh) return;
  at->second = at->second + coefficient;
  if (at->second == 0) sum.erase(at);
}

PowerSum times(const PowerSum& sum, const Powers& powers, const ExactNumber& factor) {
  PowerSum result;
  for (const auto& [own, coefficient] : sum) result.emplace(multiplied(own, powers), coefficient * factor);
  return result;
}

/// By degree in the atoms from the first on: an order that products keep, if no power is negative.
bool lower(const Powers& a, const Powers& b) {
  auto i = a.begin(), j = b.begin();
  for (; i != a.end() && j != b.end(); ++i, ++j) {
    if (i->first != j->first) return i->first > j->first;
    if (i->second != j->second) return i->second < j->second;
  }
  return i == a.end() && j != b.end();
}
PowerSum::const_iterator leading(const PowerSum& sum) {
  return std::max_element(sum.begin(), sum.end(), [](const auto& a, const auto& b) { return lower(a.first, b.first); });
}

std::string number_word(const ExactNumber& value) {
  const WholeNumber &up = value.numerator(), &down = value.denominator();
  return down == 1 && up < 1000000000000000 ? up.str() : number_text(static_cast<double>(value), 15);
}

}  // namespace

WholeNumber common_divisor(WholeNumber a, WholeNumber b) {
  while (b != 0) {
    WholeNumber rest = a % b;
    a = std::move(b);
    b = std::move(rest);
  }
  return a < 0 ? WholeNumber(-a) : a;
}

ExactNumber::ExactNumber(WholeNumber up, WholeNumber down) : up_(std::move(up)), down_(std::move(down)) {
  WholeNumber divisor = common_divisor(up_, down_);
  if (down_ < 0) divisor = -divisor;
  if (divisor == 1) return;
  up_ /= divisor;
  down_ /= divisor;
}

ExactNumber::operator double() const {
  if (up_ == 0) return 0.0;
  // Both within the range of a double, with all their leading digits.
  constexpr unsigned kBits = 900;
  const unsigned longest = std::max(msb(abs(up_)), msb(down_)), shift = longest > kBits ? longest - kBits : 0;
  const WholeNumber up = abs(up_) >> shift, down = down_ >> shift;
  const double size = static_cast<double>(up) / static_cast<double>(down);
  return up_ < 0 ? -size : size;
}

PowerSum power_of(Atom atom, int exponent) {
  if (exponent == 0) return {{Powers{}, 1}};
  return {{Powers{{atom, exponent}}, 1}};
}

PowerSum exact(double value) {
  if (value == 0.0) return {};
  // "-1.25e-3" as an integer times a power of ten.
  std::string digits;
  const std::string text = shortest_number(value);
  int exponent = 0;
  bool behind = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == 'e' || text[i] == 'E') {
      exponent += std::stoi(text.substr(i + 1));
      break;
    }
    if (text[i] == '.') {
      behind = true;
    } else {
      digits += text[i];
      if (behind) --exponent;
    }
  }
  const bool negative = digits.starts_with('-');
  // A leading zero would be an octal number.
  const std::size_t first = digits.find_first_not_of("-0");
  WholeNumber whole(first == std::string::npos ? std::string("0") : digits.substr(first));
  if (negative) whole = -whole;
  WholeNumber scale = 1;
  for (int i = 0; i < std::abs(exponent); ++i) scale *= 10;
  return {{Powers{}, exponent < 0 ? ExactNumber(whole, scale) : ExactNumber(whole * scale)}};
}

void add_to(PowerSum& sum, const PowerSum& other, const ExactNumber& factor) {
  for (const auto& [powers, coefficient] : other) add_term(sum, powers, coefficient * factor);
  if (sum.size() > kMostTerms) throw TooManyTerms("too many terms");
}

PowerSum product(const PowerSum& a, const PowerSum& b) {
  if (a.size() * b.size() > 50 * kMostTerms) throw TooManyTerms("too many terms");
  PowerSum result;
  for (const auto& [powers, coefficient] : a)
    for (const auto& [other, factor] : b) add_term(result, multiplied(powers, other), coefficient * factor);
  if (result.size() > kMostTerms) throw TooManyTerms("too many terms");
  return result;
}

std::optional<PowerSum> quotient(PowerSum a, const PowerSum& b) {
  PowerSum result;
  const auto first = leading(b);
  const Powers down = inverted(first->first);
  while (!a.empty()) {
    const auto top = leading(a);
    const Powers powers = multiplied(top->first, down);
    if (std::any_of(powers.begin(), powers.end(), [](const auto& power) { return power.second < 0; }))
      return std::nullopt;
    const ExactNumber coefficient = top->second / first->second;
    add_term(result, powers, coefficient);
    add_to(a, times(b, powers, -coefficient));
  }
  return result;
}

std::vector<PowerSum> by_laplace(const PowerSum& sum) {
  std::vector<PowerSum> result;
  for (const auto& [powers, coefficient] : sum) {
    const auto exponent = static_cast<std::size_t>(exponent_of(powers, kLaplace));
    if (result.size() <= exponent) result.resize(exponent + 1);
    Powers rest = powers;
    std::erase_if(rest, [](const auto& power) { return power.first == kLaplace; });
    result[exponent].emplace(std::move(rest), coefficient);
  }
  return result;
}

PowerSum shifted(const PowerSum& sum, Atom atom, int by) { return by == 0 ? sum : times(sum, Powers{{atom, by}}, 1); }

SymbolicRing::SymbolicRing(ExprPool& pool, std::vector<double> number, std::function<bool(SymbolId)> fixed)
    : pool_(pool), number_(std::move(number)), fixed_(std::move(fixed)), atoms_(1) {}

PowerSum SymbolicRing::sum_of(ExprId expression) {
  arguments_first(
      pool_, expression, [this](ExprId e) { return known_.contains(e.value); },
      [this](ExprId e) {
        PowerSum sum = compute(e);
        known_.emplace(e.value, std::move(sum));
      });
  return known_.at(expression.value);
}

PowerSum SymbolicRing::compute(ExprId e) {
  const ExprNode node = pool_[e];
  const auto argument = [&](std::uint32_t child) -> const PowerSum& { return known_.at(child); };
  switch (node.op) {
    case Op::constant:
      return exact(node.constant);
    case Op::symbol:
      if (fixed_(SymbolId(node.a))) return exact(number_[node.a]);
      return power_of(opaque(e), 1);
    case Op::neg:
      return times(argument(node.a), {}, -1);
    case Op::add:
    case Op::sub: {
      PowerSum sum = argument(node.a);
      add_to(sum, argument(node.b), node.op == Op::add ? 1 : -1);
      return sum;
    }
    case Op::mul:
      return product(argument(node.a), argument(node.b));
    case Op::div:
      if (argument(node.b).empty()) return power_of(opaque(e), 1);
      return product(argument(node.a), inverse(argument(node.b)));
    case Op::pow: {
      constexpr double kMostPower = 12.0;
      const PowerSum& exponent = argument(node.b);
      const double value = exponent.empty() ? 0.0 : this->value(exponent);
      const bool number = exponent.empty() || (exponent.size() == 1 && exponent.begin()->first.empty());
      if (!number || value != std::round(value) || std::abs(value) > kMostPower || argument(node.a).empty()) break;
      const PowerSum base = value < 0.0 ? inverse(argument(node.a)) : argument(node.a);
      PowerSum result{{Powers{}, 1}};
      for (int i = 0; i < static_cast<int>(std::abs(value)); ++i) result = product(result, base);
      return result;
    }
    // What is constant near the point, and which side holds there.
    case Op::abs: {
      const double value = number_of(ExprId(node.a));
      return times(argument(node.a), {}, value < 0.0 ? -1 : 1);
    }
    case Op::min:
    case Op::max:
      return argument(number_of(e) == number_of(ExprId(node.a)) ? node.a : node.b);
    case Op::select:
      return argument(number_of(ExprId(node.a)) != 0.0 ? node.b : node.c);
    case Op::sign:
    case Op::step:
    case Op::floor:
    case Op::ceil:
    case Op::round:
    case Op::lt:
    case Op::le:
    case Op::gt:
    case Op::ge:
    case Op::eq:
    case Op::ne:
    case Op::logical_and:
    case Op::logical_or:
    case Op::logical_not:
      return exact(number_of(e));
    default:
      break;
  }
  // A function of numbers is a number.
  bool numbers = true;
  for_each_argument(node, [&](ExprId a) {
    const PowerSum& sum = argument(a.value);
    numbers = numbers && (sum.empty() || (sum.size() == 1 && sum.begin()->first.empty()));
  });
  if (numbers) return exact(number_of(e));
  return power_of(opaque(e), 1);
}

PowerSum SymbolicRing::inverse(const PowerSum& sum) {
  if (sum.size() == 1) return {{inverted(sum.begin()->first), 1 / sum.begin()->second}};
  // What all terms have in common, and the first coefficient, stand before the sum, so that equal sums are one atom.
  const Powers common = common_powers(sum);
  PowerSum rest = times(sum, inverted(common), 1);
  const ExactNumber first = leading(rest)->second;
  rest = times(rest, {}, 1 / first);
  const auto [at, fresh] = atom_of_sum_.try_emplace(rest, static_cast<Atom>(atoms_.size()));
  if (fresh) atoms_.push_back({{}, rest, {}, 0.0});
  return times(power_of(at->second, -1), inverted(common), 1 / first);
}

Atom SymbolicRing::opaque(ExprId e) {
  const auto [at, fresh] = atom_of_.try_emplace(e.value, static_cast<Atom>(atoms_.size()));
  if (fresh) atoms_.push_back({e, {}, {}, 0.0});
  return at->second;
}

Atom SymbolicRing::slope(std::string name, double value) {
  atoms_.push_back({{}, {}, std::move(name), value});
  return static_cast<Atom>(atoms_.size() - 1);
}

bool SymbolicRing::is_product(const PowerSum& sum) const {
  return sum.size() <= 1 && std::all_of(sum.begin(), sum.end(), [&](const auto& term) {
           return std::all_of(term.first.begin(), term.first.end(), [&](const auto& power) {
             const ExprId e = atoms_[power.first].expression;
             return e.valid() && pool_.is_symbol(e);
           });
         });
}

double SymbolicRing::value(Atom atom) const {
  const Meaning& meaning = atoms_[atom];
  if (!meaning.name.empty()) return meaning.number;
  return meaning.expression.valid() ? number_of(meaning.expression) : value(meaning.sum);
}

double SymbolicRing::value(const PowerSum& sum) const {
  double result = 0.0;
  for (const auto& [powers, coefficient] : sum) {
    auto term = static_cast<double>(coefficient);
    for (const auto& [atom, exponent] : powers) term *= std::pow(value(atom), exponent);
    result += term;
  }
  return result;
}

const PowerSum* SymbolicRing::sum_in(Atom atom) const {
  const bool other = atom == kLaplace || atoms_[atom].expression.valid() || !atoms_[atom].name.empty();
  return other ? nullptr : &atoms_[atom].sum;
}

std::vector<Atom> SymbolicRing::sum_atoms() const {
  std::vector<Atom> result;
  for (Atom atom = static_cast<Atom>(atoms_.size()); atom-- > 1;)
    if (sum_in(atom) != nullptr) result.push_back(atom);
  return result;
}

std::string SymbolicRing::text(Atom atom, const SymbolName& name) const {
  if (atom == kLaplace) return "s";
  const Meaning& meaning = atoms_[atom];
  if (!meaning.name.empty()) return meaning.name;
  if (!meaning.expression.valid()) return "(" + text(meaning.sum, name) + ")";
  const std::string words = readable_text(pool_, meaning.expression, name);
  const bool plain = pool_.is_symbol(meaning.expression) || arity(pool_[meaning.expression].op) == 1;
  return plain ? words : "(" + words + ")";
}

std::string SymbolicRing::text(const PowerSum& sum, const SymbolName& name) const {
  if (sum.empty()) return "0";
  std::vector<PowerSum::const_iterator> terms;
  for (auto at = sum.begin(); at != sum.end(); ++at) terms.push_back(at);
  std::sort(terms.begin(), terms.end(), [](const auto& a, const auto& b) { return lower(b->first, a->first); });
  std::string result;
  for (const auto& term : terms) {
    ExactNumber coefficient = term->second;
    if (!result.empty()) result += coefficient < 0 ? " - " : " + ";
    if (result.empty() && coefficient < 0) result = "-";
    if (coefficient < 0) coefficient = -coefficient;
    std::string up;
    std::string down;
    std::size_t below = 0;
    Powers powers = term->first;  // s last
    if (!powers.empty() && powers.front().first == kLaplace)
      std::rotate(powers.begin(), powers.begin() + 1, powers.end());
    for (const auto& [atom, exponent] : powers) {
      std::string& side = exponent > 0 ? up : down;
      if (exponent < 0) ++below;
      if (!side.empty()) side += '*';
      side += text(atom, name);
      if (std::abs(exponent) != 1) side += "^" + std::to_string(std::abs(exponent));
    }
    if (coefficient != 1 || up.empty()) result += number_word(coefficient);
    if (coefficient != 1 && !up.empty()) result += '*';
    result += up;
    if (!down.empty()) result += below > 1 ? "/(" + down + ")" : "/" + down;
  }
  return result;
}

void SymbolicRing::symbols_of(const PowerSum& sum, std::set<SymbolId>& into, std::set<Atom>& slopes) const {
  for (const auto& [powers, coefficient] : sum)
    for (const auto& [atom, exponent] : powers) {
      if (atom == kLaplace) continue;
      if (const PowerSum* own = sum_in(atom)) {
        symbols_of(*own, into, slopes);
      } else if (!atoms_[atom].name.empty()) {
        slopes.insert(atom);
      } else {
        const std::vector<SymbolId> symbols = symbols_in(pool_, std::vector{atoms_[atom].expression});
        into.insert(symbols.begin(), symbols.end());
      }
    }
}

}  // namespace bgsim
