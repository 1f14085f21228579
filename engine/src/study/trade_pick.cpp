// Finding a setting for an accuracy without measuring the whole table: one method, from tolerance to tolerance by what
// its own runs differ by, then a second method.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/codes.hpp"
#include "bgsim/study.hpp"
#include "run/choose.hpp"
#include "run/failures.hpp"
#include "study/trade_runs.hpp"

namespace bgsim {

namespace {

/// Of the accuracy: what a run may differ from the reference by. The reference's own error is of that size at most.
constexpr double kShare = 0.45, kAim = 0.3;
/// The reference's tolerance is so many times tighter than that of the run it judges: methods of order 5 cost 1.6 to
/// 1.8 times as much then.
constexpr double kTighter = 10.0;
/// Errors fall as a power of the tolerance, mostly as it or a little less.
constexpr double kPower = 0.8;
constexpr double kLongestLeap = 1e3, kLoosest = 1e-2, kTightest = 1e-14;
/// Cost of a second method, in runs of what was found, and what any scene may cost.
constexpr double kSecondRuns = 12.0, kSecondSeconds = 0.02;

std::vector<Method> first_methods(const Program& program, const RunInputs& inputs) {
  RunInputs free = inputs;
  free.method = Method::automatic;
  free.max_order = 0;
  const MethodChoice choice = begins_with_loops(program, free) ? choose_method_with_loops(program, free, std::nullopt)
                                                               : choose_method(program, free, std::nullopt);
  std::vector<Method> methods{choice.method};
  for (const Method other : {Method::bdf, Method::dirk5, Method::adams, Method::erk5})
    if (other != methods.front() && program.plan.explicit_form) methods.push_back(other);
  return methods;
}

class Search {
 public:
  Search(const TradeScene& scene, double accuracy, const TradeOptions& options)
      : accuracy_(accuracy),
        budget_(options.budget),
        begin_(thread_seconds()),
        absolute_(scene.inputs.absolute || !scene.inputs.absolute_by_state.empty()),
        runs_(scene, options) {
    require_measurable(runs_);
  }

  TradePick find() {
    for (const Method method : first_methods(runs_.program(), runs_.inputs())) {
      const Found course = follow(method);
      if (course == Found::failed) continue;
      if (course == Found::missed) fail_for_reference();
      confirm();
      TradePick pick;
      pick.setting = found_.setting;
      pick.accuracy = accuracy_;
      const Judgement judgement = bgsim::judge({found_.run.result.trace, found_.run.events}, reference_);
      pick.error = judgement.max_error;
      pick.check_error = judgement.check_error;
      pick.cpu_seconds = found_.run.cpu_seconds;
      pick.reference = reference_.facts;
      pick.runs = runs_.count();
      pick.search_seconds = thread_seconds() - begin_;
      return pick;
    }
    fail_without_runs();
  }

 private:
  struct Point {
    TradeSetting setting;
    TimedRun run;
  };

  /// With the scene's absolute tolerances, if it has any, as it will be run.
  bool run_scene(Method method, double relative, Point& point) {
    return run_into(method, relative, point, budget_, false);
  }
  bool run_into(Method method, double relative, Point& point, double limit, bool exact) {
    if (runs_.ended()) return false;
    point.setting = {method, 0, relative, 0.0};
    runs_.tell(setting_flags(point.setting));
    point.run = exact ? runs_.exact(point.setting, limit) : runs_.between(point.setting, limit);
    if (!point.run.completed()) {
      if (!point.run.cut && point.run.result.failure)
        notes_.push_back({std::nullopt, setting_flags(point.setting) + ": " + point.run.result.failure->situation});
      return false;
    }
    mark_zeros(point.run.result.trace, zeros_);
    return true;
  }

  /// What @p point differs from the reference by, relative to the outputs' ranges; infinite where that is as much as an
  /// output varies by, and the reference is too loose to take it for zero.
  double distance(const Point& point) {
    const double largest = compare({reference_.trace, reference_.events}, {point.run.result.trace, point.run.events},
                                   zeros_, reference_.outputs);
    reference_.facts.unresolved.clear();
    for (TradeOutput& output : reference_.outputs) {
      output.unresolved = output.unresolved && reference_.facts.setting.relative > kTellsZero;
      if (output.unresolved && reference_.facts.unresolved.empty()) reference_.facts.unresolved = output.name;
    }
    reference_.facts.second = point.setting;
    reference_.facts.error = largest;
    return reference_.facts.unresolved.empty() ? largest : std::numeric_limits<double>::infinity();
  }
  void take_reference(Point point) {
    reference_.facts.setting = point.setting;
    reference_.facts.cpu_seconds = point.run.cpu_seconds;
    reference_.trace = std::move(point.run.result.trace);
    reference_.events = std::move(point.run.events);
  }

  /// The loosest tolerance of the method that is known to have the accuracy: found_, judged by reference_.
  enum class Found { yes, missed, failed };
  Found follow(Method method) {
    double relative = std::clamp(accuracy_, kTighter * kTightest, kLoosest), missed = kLoosest * kTighter;
    Point point;
    if (!run_scene(method, relative, point)) return Found::failed;
    while (true) {
      Point tight;
      if (!run_into(method, std::max(relative / kTighter, kTightest), tight, budget_, true)) return Found::failed;
      Point next = absolute_ ? Point{} : tight;
      take_reference(std::move(tight));
      const double error = distance(point);
      if (std::none_of(reference_.outputs.begin(), reference_.outputs.end(),
                       [](const TradeOutput& output) { return output.judged() || output.unresolved; }))
        fail_for_rest();
      if (error <= kShare * accuracy_) {
        found_ = std::move(point);
        loosen(method, relative, missed, error);
        return Found::yes;
      }
      missed = relative;
      if (relative <= kTighter * kTightest) {
        // No tighter reference can be had; the looser of the two bounds the error of the tighter as well.
        if (absolute_ || !(error <= accuracy_)) return Found::missed;
        found_ = std::move(next);
        take_reference(std::move(point));
        distance(found_);
        return Found::yes;
      }
      missed_error_ = error;
      const double leap = std::clamp(std::pow(error / (kAim * accuracy_), 1.0 / kPower), kTighter, kLongestLeap);
      const double tightened = std::max(relative / leap, kTighter * kTightest);
      const bool is_reference = !absolute_ && tightened > 0.3 * reference_.facts.setting.relative;
      relative = is_reference ? reference_.facts.setting.relative : tightened;
      if (is_reference)
        point = std::move(next);
      else if (!run_scene(method, relative, point))
        return Found::failed;
    }
  }

  /// One looser run where the found one is far more exact than asked for.
  void loosen(Method method, double relative, double missed, double error) {
    constexpr double kFarBetter = 4.0;
    if (!(kFarBetter * error < kAim * accuracy_)) return;
    const double leap = std::pow(kAim * accuracy_ / std::max(error, 1e-3 * accuracy_), 1.0);
    const double looser = std::min({relative * leap, std::sqrt(relative * missed), kLoosest});
    Point point;
    if (!(looser > 1.5 * relative) || !run_scene(method, looser, point)) return;
    const ReferenceTrace before = reference_;
    if (distance(point) <= kShare * accuracy_ && point.run.cpu_seconds < found_.run.cpu_seconds)
      found_ = std::move(point);
    else
      reference_ = before;
  }

  /// A second method comes to the same: within the accuracy, or, where the allowed runs do not get that far, nearer and
  /// nearer with its tolerance, up to some accuracies. TradeReference::error says how near.
  void confirm() {
    constexpr double kFalls = 0.5, kNear = 30.0;
    const Program& program = runs_.program();
    const double limit = kSecondRuns * found_.run.cpu_seconds + kSecondSeconds, begin = thread_seconds();
    const std::vector<TradeOutput> outputs = reference_.outputs;
    double nearest = std::numeric_limits<double>::infinity();
    TradeSetting by;
    for (const Method method : {Method::bdf, Method::dirk5, Method::radau, Method::adams, Method::ida}) {
      if (method == found_.setting.method) continue;
      if (!program.plan.explicit_form && !solves_for_loops(facts_of(method))) continue;
      double relative = found_.setting.relative, first = 0.0, last = 0.0;
      Point point;
      while (run_into(method, relative, point, limit - (thread_seconds() - begin), true)) {
        last = bgsim::judge({point.run.result.trace, point.run.events}, with(outputs)).largest();
        by_second_ = std::min(by_second_, last);
        if (first == 0.0) first = last;
        if (last <= accuracy_) {
          accept(outputs, point.setting, last);
          return;
        }
        if (last < nearest && last < kFalls * first) {
          nearest = last;
          by = point.setting;
        }
        const double leap = std::clamp(std::pow(last / (kAim * accuracy_), 1.0 / kPower), kTighter, kLongestLeap);
        if (relative / leap < kTightest) break;  // another method may get there
        relative /= leap;
      }
      if (thread_seconds() - begin > limit) break;
    }
    if (runs_.ended()) return;
    if (nearest <= kNear * accuracy_) return accept(outputs, by, nearest);
    fail_for_second();
  }
  const ReferenceTrace& with(const std::vector<TradeOutput>& outputs) {
    reference_.outputs = outputs;
    return reference_;
  }
  void accept(const std::vector<TradeOutput>& outputs, const TradeSetting& second, double agreement) {
    reference_.outputs = outputs;
    reference_.facts.second = second;
    reference_.facts.error = agreement;
  }

  [[noreturn]] void fail_for_reference() {
    Diagnostic diagnostic = diagnostic_of("BG612");
    const TradeReference& facts = reference_.facts;
    const bool unresolved = !facts.unresolved.empty();
    diagnostic.situation =
        "the accuracy " + number_text(accuracy_, 3) + " cannot be verified: the best reference, " +
        setting_flags(facts.setting) + ", differs from " + setting_flags(facts.second) + " by " +
        (unresolved ? "as much as \"" + facts.unresolved + "\" varies" : number_text(facts.error, 2));
    // A tolerance ten times tighter makes the error of a method of order 5 nearly that much smaller.
    if (!unresolved && missed_error_ > 0.0 && facts.error > 0.2 * missed_error_)
      diagnostic.situation += "; tighter tolerances bring them no nearer, so this is rounding";
    else if (!unresolved)
      diagnostic.situation += "; a tighter tolerance is below what rounding leaves of a state";
    diagnostic.notes = std::move(notes_);
    diagnostic.rule = "what is measured must be larger than what it is measured with";
    diagnostic.help = (unresolved ? "remove absolute tolerances from the scene, which bound what a relative one can do"
                                  : "ask for an accuracy above " + number_text(3.0 * facts.error, 1)) +
                      std::string("; where a solution is unstable in itself no method follows it for long");
    throw TradeFailure(std::move(diagnostic));
  }

  [[noreturn]] void fail_for_second() {
    const bool tried = std::isfinite(by_second_);
    Diagnostic diagnostic = diagnostic_of("BG612");
    diagnostic.situation = "the accuracy " + number_text(accuracy_, 3) +
                           " cannot be verified: no second method comes " +
                           (tried ? "nearer than " + number_text(by_second_, 2) + " to what " : "to its end beside ") +
                           setting_flags(found_.setting) + (tried ? " gives" : "");
    diagnostic.notes = std::move(notes_);
    diagnostic.rule = "a method does not vouch for itself";
    diagnostic.help = "bgsim trade takes a larger --budget, with which more methods come to their end";
    throw TradeFailure(std::move(diagnostic));
  }

  [[noreturn]] void fail_for_rest() {
    Diagnostic diagnostic = diagnostic_of("BG611");
    diagnostic.situation = "no output of the scene moves: there is nothing to judge errors by";
    diagnostic.rule = "errors are measured against a reference, and a second method must vouch for it";
    diagnostic.help = "record outputs that vary";
    throw TradeFailure(std::move(diagnostic));
  }

  [[noreturn]] void fail_without_runs() {
    Diagnostic diagnostic = diagnostic_of("BG611");
    diagnostic.situation = runs_.ended() ? "the search was ended before it had found a setting"
                                         : "no method comes to the end of the scene with a tight tolerance";
    diagnostic.notes = std::move(notes_);
    diagnostic.rule = "errors are measured against a reference, and a second method must vouch for it";
    diagnostic.help = runs_.ended() ? "let it run on" : "a scene that fails by itself must be corrected first";
    throw TradeFailure(std::move(diagnostic));
  }

  double accuracy_, budget_, begin_;
  bool absolute_;  ///< tolerances are given by the scene
  TradeRuns runs_;
  ReferenceTrace reference_;
  Zeros zeros_;
  Point found_;
  double by_second_ = std::numeric_limits<double>::infinity();  ///< how near any second method came
  double missed_error_ = 0.0;  ///< of the tolerance before the tightest, where that misses the accuracy, too
  std::vector<Note> notes_;
};

}  // namespace

TradePick find_setting(const Simulation& scene, double accuracy, const TradeOptions& options) {
  return Search(trade_scene(scene), accuracy, options).find();
}

TradePick find_setting(const Program& program, const RunInputs& inputs, double accuracy, const TradeOptions& options) {
  return Search(trade_scene(program, inputs), accuracy, options).find();
}

}  // namespace bgsim
