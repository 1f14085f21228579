// Maxwell reciprocity of fields that are given by laws: proved by algebra where that is possible, else tested on
// numbers.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <unordered_set>

#include "model/constitutive.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

constexpr int kPoints = 64;
constexpr int kFewestPoints = 8;      // below that many finite points nothing is claimed
constexpr double kTolerance = 1e-9;   // relative; partials are exact but for rounding
constexpr std::uint64_t kSeed = 306;  // the same model gives the same verdict

/// One law after the other ports' left sides have been replaced in it: left = right(arguments of all ports).
struct ReducedLaw {
  SymbolId left;      // the variable alone on the left
  SymbolId argument;  // its partner: q or p for e or f, and the reverse
  bool gives_stored = false;
  ExprId right;
};

std::vector<ReducedLaw> reduced_laws(ExprPool& pool, const Element& field, const std::vector<Law>& laws) {
  std::vector<ReducedLaw> reduced;
  std::unordered_map<SymbolId, ExprId> replacement;
  for (const Law& law : laws) {
    const Variable stored = stored_variable(field, law.port), conjugate = conjugate_variable(field, law.port);
    const bool gives_stored = law.variable == stored;
    reduced.push_back({port_variable(field, law.port, law.variable),
                       port_variable(field, law.port, gives_stored ? conjugate : stored), gives_stored, law.right});
    replacement[reduced.back().left] = law.right;
  }
  // Laws that use each other's left sides reach each other in at most as many steps as there are laws.
  for (std::size_t step = 1; step < laws.size(); ++step)
    for (ReducedLaw& law : reduced) law.right = substitute(pool, law.right, replacement);
  return reduced;
}

bool in_closed_form(const ExprPool& pool, const std::vector<ReducedLaw>& laws) {
  for (const ReducedLaw& law : laws)
    for (const SymbolId symbol : symbols_in(pool, std::array{law.right}))
      for (const ReducedLaw& other : laws)
        if (other.left == symbol) return false;
  return true;
}

/// d right / d argument, with the sign that makes the two cross derivatives of one energy equal: a law solved for q
/// belongs to the energy's Legendre transform.
ExprId cross_derivative(ExprPool& pool, const ReducedLaw& law, SymbolId argument) {
  const auto partials = gradient(pool, law.right, [&](SymbolId symbol) { return symbol == argument; });
  if (partials.empty()) return pool.constant(0.0);
  return law.gives_stored ? pool.neg(partials.front().second) : partials.front().second;
}

/// Values for the symbols of test points: parameters as the model gives them, everything else random.
class TestPoints {
 public:
  TestPoints(const Model& model, const ExprPool& pool, const std::vector<SymbolId>& symbols)
      : model_(model), values_(model.symbols.size(), std::numeric_limits<double>::quiet_NaN()), random_(kSeed) {
    find_parameters(pool, symbols);
    for (const SymbolId symbol : symbols)
      if (!is_parameter(symbol)) drawn_.push_back(symbol);
  }

  const std::vector<double>& next() {
    for (const SymbolId symbol : drawn_) values_[symbol.index()] = draw();
    return values_;
  }

 private:
  [[nodiscard]] bool is_parameter(SymbolId symbol) const {
    return model_.symbols[symbol.index()].kind == ModelSymbol::Kind::parameter;
  }

  /// Works out the parameters among @p symbols, those they depend on first.
  void find_parameters(const ExprPool& pool, const std::vector<SymbolId>& symbols) {
    std::vector<std::pair<SymbolId, bool>> waiting;
    for (const SymbolId symbol : symbols) waiting.emplace_back(symbol, false);
    std::unordered_set<SymbolId> met;
    while (!waiting.empty()) {
      const auto [symbol, ready] = waiting.back();
      waiting.pop_back();
      if (!is_parameter(symbol)) continue;
      const ExprId expression = model_.parameters[model_.symbols[symbol.index()].parameter.index()].value;
      if (ready) {
        values_[symbol.index()] = evaluate(pool, expression, values_);
      } else if (met.insert(symbol).second) {  // a cycle is prepare_scene's to report; here it stays without a value
        waiting.emplace_back(symbol, true);
        for (const SymbolId argument : symbols_in(pool, std::array{expression})) waiting.emplace_back(argument, false);
      }
    }
  }

  /// Either sign, magnitudes from 1e-3 to 10 evenly by decades. Written out, for distributions differ between
  /// libraries.
  double draw() {
    const double unit = static_cast<double>(random_() >> 11U) * 0x1.0p-53;
    const double magnitude = std::pow(10.0, -3.0 + 4.0 * unit);
    return (random_() & 1U) != 0 ? magnitude : -magnitude;
  }

  const Model& model_;
  std::vector<double> values_;  // by SymbolId
  std::vector<SymbolId> drawn_;
  std::mt19937_64 random_;
};

enum class Sampling { equal, different, untested };

Sampling compare_on_numbers(const Model& model, const ExprPool& pool, ExprId one, ExprId two) {
  TestPoints points(model, pool, symbols_in(pool, std::array{one, two}));
  int finite = 0;
  for (int i = 0; i < kPoints; ++i) {
    const std::vector<double>& values = points.next();
    const double a = evaluate(pool, one, values), b = evaluate(pool, two, values);
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    ++finite;
    if (std::abs(a - b) > kTolerance * std::max(std::abs(a), std::abs(b))) return Sampling::different;
  }
  return finite < kFewestPoints ? Sampling::untested : Sampling::equal;
}

std::string partial_text(const Model& model, const ExprPool& pool, const ReducedLaw& law, SymbolId argument,
                         ExprId partial) {
  const auto name = [&](SymbolId symbol) { return symbol_name(model, symbol); };
  return (law.gives_stored ? "-d " : "d ") + name(law.left) + " / d " + name(argument) + " = " +
         readable_text(pool, partial, name);
}

}  // namespace

Reciprocity test_reciprocity(const Model& model, ExprPool& pool, ElementId id) {
  const Element& field = model.elements[id.index()];
  Reciprocity result;
  if (field.laws.empty()) return result;
  const std::vector<ReducedLaw> laws = reduced_laws(pool, field, port_laws(model, pool, id));
  if (!in_closed_form(pool, laws)) {
    result.verdict = Reciprocity::Verdict::untested;
    result.text = "its laws contain each other's left sides in a circle";
    return result;
  }
  result.verdict = Reciprocity::Verdict::proved;
  for (std::size_t i = 0; i < laws.size(); ++i)
    for (std::size_t j = i + 1; j < laws.size(); ++j) {
      const ExprId one = cross_derivative(pool, laws[i], laws[j].argument);
      const ExprId two = cross_derivative(pool, laws[j], laws[i].argument);
      if (pool.is_constant(pool.sub(one, two), 0.0)) continue;
      const Sampling sampling = compare_on_numbers(model, pool, one, two);
      if (sampling == Sampling::equal) {
        if (result.verdict == Reciprocity::Verdict::proved) result.verdict = Reciprocity::Verdict::sampled;
      } else if (sampling == Sampling::untested) {
        result.verdict = Reciprocity::Verdict::untested;
        result.text = "its cross derivatives have no finite values near the origin";
      } else {
        result.verdict = Reciprocity::Verdict::violated;
        result.port_a = static_cast<std::uint32_t>(i);
        result.port_b = static_cast<std::uint32_t>(j);
        result.text = partial_text(model, pool, laws[i], laws[j].argument, one) + ", but " +
                      partial_text(model, pool, laws[j], laws[i].argument, two);
        return result;
      }
    }
  return result;
}

Reciprocity test_reciprocity(const Model& model, ElementId id) {
  ExprPool scratch = model.pool;
  return test_reciprocity(model, scratch, id);
}

}  // namespace bgsim
