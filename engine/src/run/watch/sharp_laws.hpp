/// Laws whose values between the points that an integrator evaluates may differ from what it saw there.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "expression/graph.hpp"
#include "program/enclosure.hpp"
#include "run/integrate/step_polynomial.hpp"
#include "run/watch/operator_screen.hpp"
#include "run/watch/screen.hpp"

namespace bgsim {

/// Whether an operator is neither a sum, nor a product, nor a low power, nor a choice.
[[nodiscard]] bool may_be_sharp(const ExprPool& pool, const ExprNode& node);

/// By symbol: whether it is the time, a state or a loop's variable; and whether it is a loop's variable.
struct VaryingSymbols {
  std::vector<char> any, tears;
};
VaryingSymbols varying_symbols(const Program& program);

/// An accepted step, as far as this watch needs it.
struct SharpStep {
  double begin = 0.0, end = 0.0;
  int degree = 1;
  std::size_t states = 0, unknowns = 0;  ///< unknowns: states, then tears if these are unknowns of the integrator
  double relative = 0.0;                 ///< tolerance
  StepEnds ends;
  bool fixed = false;  ///< of one length: its error is the user's choice, as far as it is in sight
  std::function<void(double t, double* y)> at;  ///< the dense output
  /// Rates at a point of it, and the loops' solution there; false at a fault.
  std::function<bool(double t, const double* y, double* rates, double* tears)> rates;
  std::function<double(std::size_t state)> tolerance;  ///< by how much the state may be wrong after one step
};

/// Watches the *sharp* operators of rates and loops: all that are neither sums nor products nor low powers
/// (exponentials, quotients, roots, trigonometric and hyperbolic functions, splines, kinks), and products and powers of
/// these. In a step in which the
/// arguments of one move farther than the operator is smooth on, the rates are integrated along the dense output, in
/// parts within which no operator is sharp, and compared with what the step added to the states. The difference is the
/// step's defect: where it is far beyond the tolerance, the integrator has seen too little.
class SharpLaws {
 public:
  SharpLaws(const Program& program, std::span<const double> parameters);

  [[nodiscard]] bool any() const { return !sharp_.empty(); }
  /// When modes have changed; before the first step, too.
  void set_modes(std::span<const double> modes);

  struct Verdict {
    std::optional<double> shorter;  ///< with which the step is to be made again; none if it holds
    std::size_t state = 0;          ///< whose increment is not what the rates add up to
    bool undecided = false;         ///< the work allowed did not suffice
  };
  /// The step up to @p until.
  /// @note Without a sharp operator that bends within the step: one evaluation of enclosures.
  Verdict look(const SharpStep& step, double until);
  /// Whether the states at @p end, within the step, are what the rates up to there add up to. If not, what lies beyond
  /// has come into the dense output: a power past the border at which its condition ends.
  bool holds_until(const SharpStep& step, double end);

  template <class Archive>
  void carry(Archive& archive) {
    archive("largest", largest_);
    archive("narrow until", narrow_until_);
    if (screen_) screen_->clear();
  }

 private:
  struct Point {
    double t = 0.0;
    bool good = false;
    std::vector<double> rate;    ///< by state: by the laws
    std::vector<double> defect;  ///< that, less the slope of the dense output
    std::vector<double> tears;
  };
  /// The defects along a step, added up.
  struct Sums {
    struct Part {
      double from = 0.0, to = 0.0;
      std::vector<double> sum;  ///< by affected state: of the defects up to its end
    };
    std::vector<Part> parts;   ///< none where the rates move by less than what is allowed
    std::vector<double> most;  ///< by affected state: the largest of these sums
    bool undecided = false;    ///< the work allowed did not suffice
    bool cut = false;          ///< nor beyond the last part
  };
  Point point_at(const SharpStep& step, double t);
  Sums add_up(const SharpStep& step, Point first, Point last, std::span<const double> limit);
  std::vector<double> change_by_states(const SharpStep& step, double until, const Sums& sums,
                                       std::span<const double> limit);
  void find_operators_of_rates(const std::vector<ExprId>& roots, const std::vector<char>& by_loops,
                               const IdMap<std::uint32_t>& position);
  bool ends_show_it(const SharpStep& step, double until);
  void enclose(const SharpStep& step, const Point& a, const Point& middle, const Point& b);
  [[nodiscard]] bool is_sharp() const;
  [[nodiscard]] double allowed(const SharpStep& step, std::size_t state, const Point& first, const Point& last) const;
  void add_error_of_states(const SharpStep& step, double from, double to, std::vector<double>& of_states);
  double forgetting(const SharpStep& step, double until, std::size_t state);

  const Program& program_;
  std::vector<ExprId> sharp_;
  std::vector<char> bends_;  ///< by operator, in this step: 0 no, 1 while only rising or only falling, 2 otherwise
  std::vector<std::vector<std::uint32_t>> operators_of_rate_;  ///< by affected state
  std::vector<std::uint32_t> affected_;                        ///< states whose rates depend on a sharp operator
  std::optional<Enclosure> operators_;  ///< of the sharp operators, then of what turns in their arguments
  std::optional<Enclosure> rates_too_;  ///< of these, then of the affected rates
  std::optional<OperatorScreen> screen_;
  StepPolynomial polynomial_;
  std::vector<std::uint32_t> all_, unknowns_;                  ///< unknowns of the polynomial
  double narrow_until_ = -std::numeric_limits<double>::max();  ///< a force narrower than its state acts before this
  std::vector<double> largest_;  ///< by state: the largest defect seen, a scale for states that have none yet
  std::vector<Jet> states_, tears_;
  std::vector<double> y_, slopes_, solution_;
};

}  // namespace bgsim
