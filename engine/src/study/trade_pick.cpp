// Finding the cheapest setting for an accuracy without measuring the whole table.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "run/failures.hpp"
#include "run/integrate/separability.hpp"
#include "study/trade_runs.hpp"

namespace bgsim {

namespace {

/// A reference for an accuracy need be no more exact than this part of it, and is sought at a tolerance of that part.
constexpr double kReferenceShare = 0.05, kToleranceShare = 0.01;
/// A setting is only worth looking at while it costs no more than so many times the best.
constexpr double kWorthwhile = 1.5, kFamilyWorthwhile = 4.0;
/// Tolerances are tried in these ratios: half decades change the cost of a method of order 5 by a quarter.
constexpr double kDecade = 10.0, kHalfDecade = 3.1622776601683795;
constexpr double kLoosest = 0.1, kTightest = 1e-13;
/// The reference's error is part of what is measured.
constexpr double kMargin = 0.9;

/// Methods that share a fate on a scene: if the first is far too costly the others are not tried.
using Family = std::vector<TradeSetting>;

std::vector<Family> families(const Program& program) {
  const auto setting = [](Method method, int max_order = 0) { return TradeSetting{method, max_order, 0.0, 0.0}; };
  if (!program.plan.explicit_form || program.system_class == SystemClass::implicit_dae) return {{setting(Method::ida)}};
  std::vector<Family> all{
      {setting(Method::bdf)},
      {setting(Method::radau)},
      {setting(Method::dirk4), setting(Method::dirk5), setting(Method::dirk3)},
      {setting(Method::erk5), setting(Method::erk4), setting(Method::erk6), setting(Method::erk3),
       setting(Method::erk8), setting(Method::rk4)},
      {setting(Method::adams)},
      {setting(Method::bdf, 2), setting(Method::dirk2)},
  };
  NotSeparable obstacle;
  if (separate(program, obstacle)) all.push_back({setting(Method::verlet)});
  return all;
}

struct Trial {
  TradeSetting setting;
  bool reached = false;  ///< the accuracy
  bool cut = false;      ///< cost more than is worthwhile
  double error = 0.0, check_error = 0.0, cpu_seconds = 0.0;
};

class Search {
 public:
  Search(const Program& program, const RunInputs& inputs, double accuracy, const TradeOptions& options)
      : accuracy_(accuracy),
        budget_(options.budget),
        begin_(thread_seconds()),
        span_(inputs.stop - inputs.start),
        runs_(program, inputs, options) {
    // Half of what the error may be: the reference's part is known to that.
    reference_ =
        find_reference(runs_, std::max(kToleranceShare * accuracy, 1e-12), kReferenceShare * accuracy, options.budget);
    if (!reference_.facts.tells(accuracy, 2.0)) fail_for_reference();
  }

  TradePick find() {
    for (const Family& family : families(runs_.program())) {
      for (const TradeSetting& setting : family) {
        const Trial found = descend(setting);
        const bool dear = !found.reached || (best_ && found.cpu_seconds > kFamilyWorthwhile * best_->cpu_seconds);
        if (dear) break;
      }
    }
    if (!best_) fail_for_accuracy();
    TradePick pick;
    pick.setting = best_->setting;
    pick.accuracy = accuracy_;
    pick.error = best_->error;
    pick.check_error = best_->check_error;
    pick.cpu_seconds = best_->cpu_seconds;
    pick.reference = reference_.facts;
    pick.runs = runs_.count();
    pick.search_seconds = thread_seconds() - begin_;
    return pick;
  }

 private:
  /// From the accuracy itself: tighter by decades until it is reached, then looser by half decades while it is.
  Trial descend(TradeSetting setting) {
    const bool fixed = facts_of(setting.method).fixed_step();
    double knob = fixed ? 1e-2 : std::min(accuracy_, kLoosest);
    Trial trial = attempt(setting, knob);
    if (trial.reached) return loosen(setting, knob, trial);
    Trial last = trial;
    while (!trial.reached && !trial.cut && knob / kDecade >= (fixed ? 1e-7 : kTightest)) {
      knob /= kDecade;
      last = trial;
      trial = attempt(setting, knob);
    }
    if (!trial.reached) return trial;
    const Trial between = attempt(setting, knob * kHalfDecade);
    return between.reached ? between : trial;
  }

  Trial loosen(const TradeSetting& setting, double knob, Trial reached) {
    while (knob * kHalfDecade <= kLoosest) {
      knob *= kHalfDecade;
      const Trial trial = attempt(setting, knob);
      if (!trial.reached) break;
      reached = trial;
    }
    return reached;
  }

  /// @param knob  the tolerance, or the step as a part of the scene.
  Trial attempt(TradeSetting setting, double knob) {
    (facts_of(setting.method).fixed_step() ? setting.step = knob* span_ : setting.relative = knob);
    Trial trial;
    trial.setting = setting;
    trial.cut = true;
    const double spent = thread_seconds() - begin_;
    if (runs_.ended() || (best_ && spent > budget_)) return trial;
    runs_.tell(setting_flags(setting));
    // The judging run has twice the output times, and an audit, of which the cost is not the setting's.
    const double limit = best_ ? kJudging * kWorthwhile * best_->cpu_seconds + kLeastSeconds : budget_;
    const TimedRun judged = runs_.judge(setting, limit);
    trial.cut = judged.cut;
    if (!judged.completed()) return trial;
    const Judgement judgement = bgsim::judge(judged.result.trace, reference_);
    trial.error = judgement.max_error;
    trial.check_error = judgement.check_error;
    trial.cpu_seconds = judged.cpu_seconds;
    trial.reached = std::max(trial.error, trial.check_error) <= kMargin * accuracy_ - reference_.facts.error;
    least_error_ = std::min(least_error_, std::max(trial.error, trial.check_error));
    if (!trial.reached) return trial;
    int repeats = 0;
    RunResult first;
    trial.cpu_seconds = runs_.median_seconds(setting, budget_, repeats, first);
    if (!best_ || trial.cpu_seconds < best_->cpu_seconds) best_ = trial;
    return trial;
  }

  [[noreturn]] void fail_for_reference() const {
    Diagnostic diagnostic = diagnostic_of("BG612");
    const TradeReference& facts = reference_.facts;
    const bool unresolved = !facts.unresolved.empty();
    diagnostic.situation =
        "the accuracy " + number_text(accuracy_, 3) + " cannot be verified: the best reference, " +
        setting_flags(facts.setting) + ", differs from " + setting_flags(facts.second) + " by " +
        (unresolved ? "as much as \"" + facts.unresolved + "\" varies" : number_text(facts.error, 2));
    diagnostic.rule = "what is measured must be larger than what it is measured with";
    diagnostic.help =
        (unresolved ? "bgsim trade takes a larger --budget, with which a tighter reference comes to its end"
                    : "ask for an accuracy above " + number_text(2.0 * facts.error, 1)) +
        std::string("; where a solution is unstable in itself no method follows it for long");
    throw TradeFailure(std::move(diagnostic));
  }

  [[noreturn]] void fail_for_accuracy() const {
    Diagnostic diagnostic = diagnostic_of("BG612");
    diagnostic.situation = "no setting was found that reaches the accuracy " + number_text(accuracy_, 3) +
                           (std::isfinite(least_error_) ? "; the best came to " + number_text(least_error_, 2) : "");
    diagnostic.rule = "a setting is accepted if its outputs are within the accuracy at and between the output times";
    diagnostic.help =
        "bgsim trade takes a larger --budget; remove absolute tolerances from the scene, which bound what a relative "
        "one can do";
    throw TradeFailure(std::move(diagnostic));
  }

  static constexpr double kJudging = 4.0, kLeastSeconds = 2e-3;

  double accuracy_, budget_, begin_, span_;
  TradeRuns runs_;
  ReferenceTrace reference_;
  std::optional<Trial> best_;
  double least_error_ = std::numeric_limits<double>::infinity();
};

}  // namespace

TradePick find_setting(const Program& program, const RunInputs& inputs, double accuracy, const TradeOptions& options) {
  return Search(program, inputs, accuracy, options).find();
}

}  // namespace bgsim
