/// Quantities whose derivative the rates contain must not jump where conditions change: each change is looked at.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

class ContinuityWatch {
 public:
  /// @param span  of the scene; @param relative  tolerance of the run: what jumps by less is beyond its accuracy.
  ContinuityWatch(Evaluator& evaluator, double span, double relative);

  /// Remembers the values before a change at @p t.
  void before(double t, const double* x, const Branch& branch);
  /// BG402 if one of them is another one after it.
  std::optional<Diagnostic> after(double t, const double* x, const Branch& branch);
  /// The same where events set states: of Program::jumps_if_set alone, since what bonds tie to such a state is set with
  /// it.
  std::optional<Diagnostic> after_sets(double t, const double* x, const Branch& branch);
  /// Whether there are any of these.
  [[nodiscard]] bool watches_sets() const { return watches_sets_; }
  /// The same for a model without states, wherever modes change between two times.
  std::optional<Diagnostic> between(double from, double to, const std::function<bool(double, Branch&)>& modes_at);

 private:
  std::optional<Diagnostic> compare(double t, const double* x, const Branch& branch, bool sets_alone);
  bool evaluate(double t, const double* x, const Branch& branch, std::vector<double>& values,
                std::vector<double>& bounds);
  [[nodiscard]] double lateness(const Branch& branch) const;
  void vary(double t, const double* x, const Branch& branch, double step, const std::vector<double>& values);

  Evaluator& evaluator_;
  double span_, relative_;
  std::vector<double> before_, after_, before_bounds_, after_bounds_, beside_, beside_bounds_;
  std::vector<double> variation_;  ///< within a short time before and after
  std::vector<double> rates_, x_;
  std::vector<double> guards_, earlier_guards_;  ///< before the change, and a short time earlier
  std::vector<double> modes_;                    ///< before the change
  Branch branch_;
  bool known_ = false, watches_sets_ = false;
};

}  // namespace bgsim
