/// A pool with a few names, and random expressions over them.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "expression/parse.hpp"

namespace bgsim::test {

struct World {
  World() {
    Table line;
    line.file = "data.csv";
    line.column = "u";
    line.x = {-10.0, 0.0, 1.0, 10.0};
    line.y = {3.0, 1.0, 2.0, -4.0};
    linear_table = pool.add_table(line);
    line.interpolation = Interpolation::spline;
    spline_table = pool.add_table(line);
  }

  ExprPool pool;
  std::vector<std::string> names{"t", "x", "y", "z", "packet.wall.q", "tf.1.e", "R_b"};
  TableId linear_table, spline_table;

  [[nodiscard]] static SymbolId id(std::size_t i) { return SymbolId(i); }
  [[nodiscard]] SymbolId id(const std::string& name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return SymbolId(i);
    return {};
  }
  ExprId symbol(const std::string& name) { return pool.symbol(id(name)); }

  ExpressionScope scope() {
    ExpressionScope s;
    s.name = [this](std::string_view n) -> std::optional<ExprId> {
      const SymbolId found = id(std::string(n));
      if (!found.valid()) return std::nullopt;
      return pool.symbol(found);
    };
    s.known_names = [this] { return names; };
    s.table = [this](std::string_view, std::string_view, Interpolation i) {
      return i == Interpolation::linear ? linear_table : spline_table;
    };
    s.time = SymbolId(std::size_t{0});
    return s;
  }
  ExprId parse(std::string_view text) { return parse_expression(text, pool, scope()); }
  [[nodiscard]] std::string text(ExprId e) const {
    return to_text(pool, e, [this](SymbolId s) { return names[s.index()]; });
  }
  [[nodiscard]] std::string latex(ExprId e) const {
    return to_latex(pool, e, [this](SymbolId s) { return names[s.index()]; });
  }
  [[nodiscard]] std::vector<std::string> mathml(ExprId e) const {
    return to_mathml(pool, e, [this](SymbolId s) { return names[s.index()]; });
  }
  [[nodiscard]] double value(ExprId e, std::span<const double> values) const { return evaluate(pool, e, values); }
  double value(std::string_view expression, std::vector<double> values = {}) {
    return evaluate(pool, parse(expression), values);
  }
  /// The partial derivative by one name; the constant 0 if it vanishes.
  ExprId derivative(ExprId e, const std::string& name) {
    const auto g = gradient(pool, e, [&](SymbolId s) { return s == id(name); });
    return g.empty() ? pool.constant(0.0) : g.front().second;
  }
};

/// Builds random expressions from the constructors, numbers and conditions apart.
class RandomExpressions {
 public:
  /// @param moderate  numbers between 0.1 and 3 in magnitude only.
  RandomExpressions(World& world, unsigned seed, bool moderate = false)
      : world_(world), random_(seed), moderate_(moderate) {}

  /// A number with about @p size operators.
  ExprId number(int size) {
    if (size <= 0) return leaf();
    const auto split = [&] { return static_cast<int>(random_() % static_cast<unsigned>(size)); };
    ExprPool& pool = world_.pool;
    switch (random_() % 8) {
      case 0:
      case 1:
      case 2:
      case 3: {
        static constexpr std::array kTwo{Op::add, Op::sub, Op::mul, Op::div,   Op::pow,   Op::add,   Op::sub, Op::mul,
                                         Op::div, Op::min, Op::max, Op::atan2, Op::hypot, Op::ssqrt, Op::mod};
        const int left = split();
        const ExprId a = number(left), b = number(size - 1 - left);
        return pool.make(kTwo[random_() % kTwo.size()], a, b);
      }
      case 4:
        return pool.neg(number(size - 1));
      case 5: {
        static constexpr auto kFirst = static_cast<unsigned>(Op::abs), kLast = static_cast<unsigned>(Op::step);
        return pool.make(static_cast<Op>(kFirst + random_() % (kLast - kFirst + 1)), number(size - 1));
      }
      case 6: {
        const ExprId c = condition(size / 3), a = number(size / 3), b = number(size / 3);
        return pool.select(c, a, b);
      }
      default:
        if (random_() % 2 == 0) return pool.make(Op::der, number(size - 1));
        return pool.table(Op::table, number(size - 1), random_() % 2 == 0 ? world_.linear_table : world_.spline_table);
    }
  }

  ExprId condition(int size) {
    ExprPool& pool = world_.pool;
    if (size > 0 && random_() % 2 == 0) {
      const ExprId a = condition(size / 2), b = condition(size / 2);
      const unsigned kind = static_cast<unsigned>(random_() % 3);
      if (kind == 2) return pool.make(Op::logical_not, a);
      return pool.make(kind == 0 ? Op::logical_and : Op::logical_or, a, b);
    }
    const auto op = static_cast<Op>(static_cast<unsigned>(Op::lt) + random_() % 6);
    const ExprId a = number(size / 2);
    ExprId b = number(size / 2);
    if (pool.is_constant(a) && pool.is_constant(b)) b = world_.symbol("x");  // a constant condition has no text
    return pool.make(op, a, b);
  }

  ExprId leaf() {
    ExprPool& pool = world_.pool;
    static constexpr std::array kNumbers{2.0, -1.0, 0.5, 3.0, -2.5, 0.1, 1e-9, 6.02214076e23, 1e-200, 0.0};
    if (random_() % 3 == 0) return pool.constant(kNumbers[random_() % (moderate_ ? 6 : kNumbers.size())]);
    return pool.symbol(SymbolId(random_() % world_.names.size()));
  }

  std::mt19937& random() { return random_; }

 private:
  World& world_;
  std::mt19937 random_;
  bool moderate_;
};

}  // namespace bgsim::test
