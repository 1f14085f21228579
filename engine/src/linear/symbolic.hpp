/// Sums of products of integer powers, with exact numbers: what the determinant of a small linear system is made of.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Without expression templates: values, as everywhere.
using WholeNumber =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
/// A fraction in lowest terms.
class ExactNumber {
 public:
  ExactNumber(int value) : up_(value) {}  // NOLINT(google-explicit-constructor): numbers in formulas
  explicit ExactNumber(WholeNumber up, WholeNumber down = 1);  ///< @pre down is not 0
  [[nodiscard]] const WholeNumber& numerator() const { return up_; }
  [[nodiscard]] const WholeNumber& denominator() const { return down_; }  ///< above 0
  explicit operator double() const;

  friend ExactNumber operator+(const ExactNumber& a, const ExactNumber& b) {
    return ExactNumber(a.up_ * b.down_ + b.up_ * a.down_, a.down_ * b.down_);
  }
  friend ExactNumber operator*(const ExactNumber& a, const ExactNumber& b) {
    return ExactNumber(a.up_ * b.up_, a.down_ * b.down_);
  }
  friend ExactNumber operator/(const ExactNumber& a, const ExactNumber& b) {
    return ExactNumber(a.up_ * b.down_, a.down_ * b.up_);
  }
  ExactNumber operator-() const { return ExactNumber(-up_, down_); }
  friend bool operator==(const ExactNumber& a, const ExactNumber& b) { return a.up_ == b.up_ && a.down_ == b.down_; }
  friend bool operator<(const ExactNumber& a, const ExactNumber& b) { return a.up_ * b.down_ < b.up_ * a.down_; }

 private:
  WholeNumber up_, down_ = 1;
};
/// Euclid; of 0 and b it is |b|.
WholeNumber common_divisor(WholeNumber a, WholeNumber b);

/// What a power is of: the variable s (0), a symbol, an expression that is no polynomial, or a sum in a denominator.
using Atom = std::uint32_t;
inline constexpr Atom kLaplace = 0;

/// Powers by atom, none of them 0, in order of atoms.
using Powers = std::vector<std::pair<Atom, int>>;
/// Coefficients, none of them 0.
using PowerSum = std::map<Powers, ExactNumber>;

/// A system is too large for its terms to be written out.
class TooManyTerms : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
constexpr std::size_t kMostTerms = 20'000;

PowerSum power_of(Atom atom, int exponent);
PowerSum exact(double value);  ///< of its shortest decimal text: 0.1 is a tenth
void add_to(PowerSum& sum, const PowerSum& other, const ExactNumber& factor = 1);
/// @throws TooManyTerms
PowerSum product(const PowerSum& a, const PowerSum& b);
/// a/b if that leaves no remainder. @pre no negative powers; b is not empty
std::optional<PowerSum> quotient(PowerSum a, const PowerSum& b);
/// The coefficients of the powers of s. @pre s has no negative powers
std::vector<PowerSum> by_laplace(const PowerSum& sum);
/// By s at @p exponent in all terms: taken out.
PowerSum shifted(const PowerSum& sum, Atom atom, int by);

/// Atoms, and expressions as sums of their powers.
class SymbolicRing {
 public:
  /// @param number  by SymbolId: values at the point. Conditions are decided there, and symbols with @p fixed are their
  ///                numbers.
  SymbolicRing(ExprPool& pool, std::vector<double> number, std::function<bool(SymbolId)> fixed);

  /// @throws TooManyTerms
  PowerSum sum_of(ExprId expression);

  /// A new atom with a name and a value: a slope at the point.
  Atom slope(std::string name, double value);
  /// Whether a sum is a product of powers of symbols.
  [[nodiscard]] bool is_product(const PowerSum& sum) const;

  [[nodiscard]] double value(Atom atom) const;  ///< @pre not s
  [[nodiscard]] double value(const PowerSum& sum) const;
  [[nodiscard]] std::string text(Atom atom, const SymbolName& name) const;
  /// "m*k + 2*c^2/k"; "0"
  [[nodiscard]] std::string text(const PowerSum& sum, const SymbolName& name) const;
  /// Of an atom that stands for a sum in a denominator.
  [[nodiscard]] const PowerSum* sum_in(Atom atom) const;
  /// The atoms of sums, latest first: one may be in those made after it.
  [[nodiscard]] std::vector<Atom> sum_atoms() const;
  /// The symbols that the atoms in @p sum depend on, and the atoms that are slopes.
  void symbols_of(const PowerSum& sum, std::set<SymbolId>& into, std::set<Atom>& slopes) const;

 private:
  PowerSum compute(ExprId e);
  PowerSum inverse(const PowerSum& sum);
  Atom opaque(ExprId e);
  double number_of(ExprId e) const { return evaluate(pool_, e, number_); }

  struct Meaning {
    ExprId expression;  ///< none: of s, of sums and of slopes
    PowerSum sum;
    std::string name;  ///< of a slope
    double number = 0.0;
  };
  ExprPool& pool_;
  std::vector<double> number_;
  std::function<bool(SymbolId)> fixed_;
  std::vector<Meaning> atoms_;
  std::map<std::uint32_t, Atom> atom_of_;  ///< by expression
  std::map<PowerSum, Atom> atom_of_sum_;
  std::map<std::uint32_t, PowerSum> known_;  ///< by expression
};

}  // namespace bgsim
