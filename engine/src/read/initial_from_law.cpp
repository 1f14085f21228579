#include "read/initial_from_law.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bgsim/text.hpp"
#include "expression/rounded.hpp"
#include "expression/solutions.hpp"
#include "model/constitutive.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// A solution is put into its law again: closed forms lose a few digits, a wrong branch loses all.
constexpr double kAgreement = 1e-9;
/// A solution is off by some roundings of its own, of elimination by more for each unknown.
constexpr double kSolution = 4.0 * std::numeric_limits<double>::epsilon();

class StoreStart {
 public:
  StoreStart(const Model& model, ExprPool& pool, ElementId id, std::span<const StartValue> given, double start,
             std::vector<double>& values, std::vector<double>& errors)
      : model_(model),
        pool_(pool),
        element_(model.elements[id.index()]),
        id_(id),
        given_(given),
        values_(values),
        errors_(errors) {
    values_.resize(model.symbols.size(), std::numeric_limits<double>::quiet_NaN());
    values_[model.time.index()] = start;
  }

  StoredAtStart run() {
    result_.stored.assign(given_.size(), 0.0);
    result_.rounding.assign(given_.size(), 0.0);
    for (std::uint32_t port = 0; port < element_.ports.size(); ++port) at(stored(port)) = 0.0;
    for (std::size_t i = 0; i < given_.size(); ++i) {
      result_.stored[i] = given_[i].value;
      at(given_[i].conjugate ? conjugate(given_[i].port) : stored(given_[i].port)) = given_[i].value;
    }
    const std::vector<Law> laws = port_laws(model_, pool_, id_);
    for (std::size_t i = 0; i < given_.size() && result_.fault.empty(); ++i)
      if (given_[i].conjugate) prepare(i, laws);
    if (result_.fault.empty()) solve();
    if (result_.fault.empty()) verify();
    return std::move(result_);
  }

 private:
  struct Unknown {
    std::size_t given;  ///< position among the given values
    SymbolId symbol;    ///< what is stored
    ExprId law;         ///< over it
  };

  [[nodiscard]] SymbolId stored(std::uint32_t port) const {
    return port_variable(element_, port, stored_variable(element_, port));
  }
  [[nodiscard]] SymbolId conjugate(std::uint32_t port) const {
    return port_variable(element_, port, conjugate_variable(element_, port));
  }
  double& at(SymbolId symbol) { return values_[symbol.index()]; }
  [[nodiscard]] std::string name(SymbolId symbol) const { return symbol_name(model_, symbol); }
  void fail(std::size_t given, std::string why) {
    result_.fault = std::move(why);
    result_.at = given;
  }

  /// Signals by what they are computed from, down to quantities that are no signals.
  ExprId without_signals(ExprId expression) {
    while (true) {
      std::unordered_map<SymbolId, ExprId> values;
      for (const SymbolId symbol : symbols_in(pool_, std::array{expression})) {
        const ModelSymbol& meaning = model_.symbols[symbol.index()];
        // An integral among the signals is known during the run only, like a state.
        if (meaning.kind == ModelSymbol::Kind::signal && !model_.signals[meaning.signal.index()].is_state())
          values[symbol] = model_.signals[meaning.signal.index()].value;
      }
      if (values.empty()) return expression;
      expression = substitute(pool_, expression, values);
    }
  }

  /// A law that gives what is stored is evaluated; one that gives the effort or flow becomes an equation to be solved.
  void prepare(std::size_t i, const std::vector<Law>& laws) {
    const Law& law = laws[given_[i].port];
    const ExprId right = without_signals(law.right);
    for (const ExprId e : reachable(pool_, std::array{right}))
      if (pool_[e].op == Op::der) return fail(i, "its law contains a time derivative");
    const bool gives_stored = law.variable == stored_variable(element_, law.port);
    for (const SymbolId symbol : symbols_in(pool_, std::array{right})) {
      const ModelSymbol& meaning = model_.symbols[symbol.index()];
      if (meaning.kind == ModelSymbol::Kind::parameter || meaning.kind == ModelSymbol::Kind::time) continue;
      const bool own = meaning.kind == ModelSymbol::Kind::port_variable && meaning.element == id_;
      const bool holds = own && meaning.variable == stored_variable(element_, meaning.port);
      if (!own) return fail(i, "its law depends on " + name(symbol) + ", which is known only during the run");
      if (gives_stored ? (holds || std::isnan(at(symbol))) : !holds)
        return fail(i, "its law depends on " + name(symbol) + ", which is not given");
    }
    if (!gives_stored) return unknowns_.push_back({i, stored(given_[i].port), right});
    result_.stored[i] = evaluate(pool_, right, values_);
    result_.rounding[i] = rounding_of(pool_, right, values_, errors_);
    at(stored(given_[i].port)) = result_.stored[i];
    if (!std::isfinite(result_.stored[i])) fail(i, "its law gives no finite value there");
  }

  void solve() {
    if (unknowns_.empty()) return;
    if (unknowns_.size() == 1)
      solve_one(unknowns_[0]);
    else
      solve_linear();
    for (const Unknown& unknown : unknowns_) at(unknown.symbol) = result_.stored[unknown.given];
  }

  void solve_one(const Unknown& unknown) {
    const double wanted = given_[unknown.given].value;
    double& x = result_.stored[unknown.given];
    if (const auto inverse = invert(pool_, unknown.law, unknown.symbol, pool_.constant(wanted))) {
      x = evaluate(pool_, *inverse, values_);
      if (!std::isfinite(x)) fail(unknown.given, "no finite value of " + name(unknown.symbol) + " gives it by the law");
      return;
    }
    const auto is_x = [&](SymbolId s) { return s == unknown.symbol; };
    if (gradient(pool_, unknown.law, is_x).empty())
      return fail(unknown.given, "its law does not depend on " + name(unknown.symbol));
    const Solutions found = jumps_with(pool_, unknown.law, is_x)
                                ? Solutions{}
                                : solutions(pool_, unknown.law, unknown.symbol, wanted, values_);
    if (found.at.size() == 1 && found.all) {
      x = found.at.front();
      return;
    }
    const std::string stored = name(unknown.symbol);
    if (!found.all)
      fail(unknown.given, "its law may give it for several values of " + stored + ", or for none");
    else if (found.at.empty())
      fail(unknown.given, "no value of " + stored + " gives it by the law");
    else
      fail(unknown.given, "its law gives it for several values of " + stored + ": " + number_text(found.at[0]) + ", " +
                              number_text(found.at[1]) + (found.at.size() > 2 ? ", ..." : ""));
  }

  void solve_linear() {
    const auto n = static_cast<Eigen::Index>(unknowns_.size());
    Eigen::MatrixXd slopes(n, n);
    Eigen::VectorXd wanted(n);
    for (const Unknown& unknown : unknowns_) at(unknown.symbol) = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Unknown& row = unknowns_[static_cast<std::size_t>(i)];
      wanted[i] = given_[row.given].value - evaluate(pool_, row.law, values_);
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto form = linear_in(pool_, row.law, unknowns_[static_cast<std::size_t>(k)].symbol);
        if (!form || has_unknown(form->slope))
          return fail(row.given, "several are to be solved for together, and the law is not linear in them");
        slopes(i, k) = evaluate(pool_, form->slope, values_);
      }
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> factors(slopes);
    if (!slopes.allFinite() || !wanted.allFinite() || !factors.isInvertible())
      return fail(unknowns_[0].given,
                  "the laws of the ports do not determine what is stored: together they are singular");
    const Eigen::VectorXd x = factors.solve(wanted);
    for (Eigen::Index i = 0; i < n; ++i) result_.stored[unknowns_[static_cast<std::size_t>(i)].given] = x[i];
  }
  [[nodiscard]] bool has_unknown(ExprId expression) const {
    const auto symbols = symbols_in(pool_, std::array{expression});
    return std::any_of(symbols.begin(), symbols.end(), [&](SymbolId s) {
      return std::any_of(unknowns_.begin(), unknowns_.end(), [s](const Unknown& u) { return u.symbol == s; });
    });
  }

  /// Leaves in the result's roundings how far each law can be off at the solution.
  void verify() {
    const double own = kSolution * static_cast<double>(unknowns_.size());
    for (const Unknown& unknown : unknowns_) errors_[unknown.symbol.index()] = own * std::abs(at(unknown.symbol));
    for (const Unknown& unknown : unknowns_) {
      const double wanted = given_[unknown.given].value, is = evaluate(pool_, unknown.law, values_);
      const double rounding = rounding_of(pool_, unknown.law, values_, errors_);
      result_.rounding[unknown.given] = rounding;
      const double allowed = std::max(kAgreement * std::max(std::abs(is), std::abs(wanted)), rounding);
      if (result_.fault.empty() && !(std::abs(is - wanted) <= allowed))
        fail(unknown.given, "no value of " + name(unknown.symbol) + " gives it by the law");
    }
    for (const Unknown& unknown : unknowns_) errors_[unknown.symbol.index()] = 0.0;
  }

  const Model& model_;
  ExprPool& pool_;
  const Element& element_;
  ElementId id_;
  std::span<const StartValue> given_;
  std::vector<double>&values_, &errors_;
  std::vector<Unknown> unknowns_;
  StoredAtStart result_;
};

}  // namespace

StoredAtStart stored_at_start(const Model& model, ExprPool& pool, ElementId id, std::span<const StartValue> given,
                              double start, std::vector<double>& symbol_values, std::vector<double>& symbol_errors) {
  const auto from = [&](std::span<const StartValue> values) {
    return StoreStart(model, pool, id, values, start, symbol_values, symbol_errors).run();
  };
  StoredAtStart found = from(given);
  if (!found.fault.empty()) return found;
  // What is stored moves with each given value by as much as that value and its law can be off.
  std::vector<StartValue> moved(given.begin(), given.end());
  std::vector<double> rounding(given.size(), 0.0);
  for (std::size_t k = 0; k < given.size(); ++k) {
    moved[k].value += given[k].rounding + found.rounding[k];
    if (moved[k].value == given[k].value) continue;
    const StoredAtStart other = from(moved);
    for (std::size_t i = 0; other.fault.empty() && i < given.size(); ++i)
      rounding[i] += std::abs(other.stored[i] - found.stored[i]);
    moved[k].value = given[k].value;
  }
  found.rounding = std::move(rounding);
  return found;
}

}  // namespace bgsim
