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
/// Of a run that a tighter one is to judge; leaps end here but for rounding.
constexpr double kTightestJudged = kTighter * kTightest, kNearly = 1.01;
/// Runs whose numbers of steps differ by less than this factor may have the same steps. A method of order 5 makes 1.6
/// times as many with a tenth of the tolerance.
constexpr double kSameSteps = 1.2;
/// How often a method begins again from a tighter tolerance, because another one does not come to what it gives.
constexpr int kTimesAgain = 2;
/// Cost of a second method, in runs of what was found, and what any scene may cost.
constexpr double kSecondRuns = 16.0, kSecondSeconds = 0.02;

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
      Found course = follow(method, accuracy_);
      // Where another method comes to something else, and stays there, this one's runs agreed too early.
      for (int again = 0; course == Found::yes; ++again) {
        const Confirmed confirmed = confirm();
        if (confirmed == Confirmed::yes) break;
        if (runs_.ended()) fail_without_runs();
        if (confirmed == Confirmed::no || again == kTimesAgain) fail_for_second();
        course = follow(method, found_.setting.relative / kLongestLeap);
      }
      if (course == Found::failed) continue;
      if (course == Found::missed) fail_for_reference();
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
    return true;
  }

  /// What @p point differs from the reference by, relative to the outputs' ranges; infinite where that is as much as an
  /// output varies by, and the reference is too loose to take it for zero. Both are of one method: what is zero in both
  /// is zero by symmetry.
  double distance(const Point& point) {
    Zeros zeros, of_point;
    mark_zeros(reference_.trace, zeros);
    mark_zeros(point.run.result.trace, of_point);
    for (std::size_t c = 0; c < zeros.size(); ++c) zeros[c] = zeros[c] && of_point[c];
    const double largest = compare({reference_.trace, reference_.events}, {point.run.result.trace, point.run.events},
                                   zeros, reference_.outputs);
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

  /// Whether two runs may have the same steps, those that a source allows: the same errors then, whatever their
  /// tolerances.
  [[nodiscard]] static bool same_steps(const Point& a, const Point& b) {
    const auto [fewer, more] = std::minmax({a.run.result.report.steps, b.run.result.report.steps});
    return static_cast<double>(more) < kSameSteps * static_cast<double>(fewer);
  }
  /// A run that a point can be judged by: of a tighter tolerance, and of other steps.
  bool run_reference(const Point& point, Point& tight) {
    double relative = point.setting.relative / kTighter;
    for (;; relative /= kLongestLeap) {
      relative = std::max(relative, kTightest);
      if (!run_into(point.setting.method, relative, tight, budget_, true)) return false;
      if (relative <= kTightest || !same_steps(point, tight)) return true;
    }
  }
  /// Whether a run says that something may have happened within its steps that it has not seen.
  [[nodiscard]] static bool undecided(const Point& point) { return !point.run.result.report.undecided.empty(); }

  /// The loosest tolerance of the method that is known to have the accuracy: found_, judged by reference_.
  enum class Found { yes, missed, failed };
  Found follow(Method method, double begin) {
    double relative = std::clamp(begin, kTightestJudged, kLoosest), missed = kLoosest * kTighter;
    Point point;
    if (!run_scene(method, relative, point)) return Found::failed;
    while (true) {
      Point tight;
      if (!run_reference(point, tight)) return Found::failed;
      const bool blind = undecided(point) || undecided(tight);
      // With a tenth of the tolerance it made the same steps.
      const bool stands = tight.setting.relative < 0.5 * relative / kTighter;
      Point next = absolute_ ? Point{} : tight;
      take_reference(std::move(tight));
      const double error = distance(point);
      if (blind) {
        if (relative <= kNearly * kTightestJudged) fail_for_undecided(point);
        missed = relative;
        relative = std::max(relative / kLongestLeap, kTightestJudged);
        if (!run_scene(method, relative, point)) return Found::failed;
        continue;
      }
      if (std::none_of(reference_.outputs.begin(), reference_.outputs.end(),
                       [](const TradeOutput& output) { return output.judged() || output.unresolved; }))
        fail_for_rest();
      if (error <= kShare * accuracy_) {
        found_ = std::move(point);
        loosen(method, relative, missed, error);
        return Found::yes;
      }
      missed = relative;
      if (relative <= kNearly * kTightestJudged) {
        // No tighter reference can be had; the looser of the two bounds the error of the tighter as well.
        if (absolute_ || !(error <= accuracy_)) return Found::missed;
        found_ = std::move(next);
        take_reference(std::move(point));
        distance(found_);
        return Found::yes;
      }
      missed_error_ = error;
      const double leap = stands
                              ? kLongestLeap
                              : std::clamp(std::pow(error / (kAim * accuracy_), 1.0 / kPower), kTighter, kLongestLeap);
      const double tightened = std::max(relative / leap, kTightestJudged);
      const bool is_reference = !absolute_ && !stands && tightened > 0.3 * reference_.facts.setting.relative;
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
    if (!undecided(point) && distance(point) <= kShare * accuracy_ && point.run.cpu_seconds < found_.run.cpu_seconds)
      found_ = std::move(point);
    else
      reference_ = before;
  }

  /// A second method comes to the same: within the accuracy, or, where the allowed runs do not get that far, nearer and
  /// nearer with its tolerance, up to some accuracies. TradeReference::error says how near.
  enum class Confirmed { yes, no, apart };  ///< apart: one stays at a distance of its own
  Confirmed confirm() {
    constexpr double kNear = 30.0;
    // At first the time is not one method's alone; what is cut then may have what is left.
    constexpr double kFirst = 0.125;
    const Program& program = runs_.program();
    const double end = thread_seconds() + kSecondRuns * found_.run.cpu_seconds + kSecondSeconds;
    const double first = kFirst * (end - thread_seconds());
    const std::vector<TradeOutput> outputs = reference_.outputs;
    by_second_ = std::numeric_limits<double>::infinity();
    Course nearest;
    bool apart = false;
    std::vector<Method> cut;
    const auto confirmed_by = [&](Method method, double limit) {
      const Course course = approach(method, limit, end, outputs);
      if (course.cut) cut.push_back(method);
      apart = apart || course.stays;
      if (!course.stays && course.distance < nearest.distance) nearest = course;
      return course.there;
    };
    bool there = false;
    for (const Method method : {Method::bdf, Method::dirk5, Method::radau, Method::adams, Method::ida, Method::radau9})
      if (!there && method != found_.setting.method &&
          (program.plan.explicit_form || solves_for_loops(facts_of(method))))
        there = confirmed_by(method, first);
    for (const Method method : std::exchange(cut, {}))
      there = there || confirmed_by(method, std::numeric_limits<double>::infinity());
    if (there || (nearest.distance <= kNear * accuracy_ && !runs_.ended())) {
      accept(outputs, nearest.setting, nearest.distance);
      return Confirmed::yes;
    }
    return apart ? Confirmed::apart : Confirmed::no;
  }

  /// How near a method comes to the reference as its tolerance is tightened.
  struct Course {
    TradeSetting setting;
    double distance = std::numeric_limits<double>::infinity();  ///< once it has fallen, or is within the accuracy
    bool there = false;                                         ///< within the accuracy
    bool stays = false;                                         ///< farther away, however tight
    bool cut = false;                                           ///< its first run was, by the limit
  };
  /// @param limit  of the first run, @p end of all, in this thread's seconds
  Course approach(Method method, double limit, double end, const std::vector<TradeOutput>& outputs) {
    constexpr double kFalls = 0.5, kTighterThan = 1e-2;
    Course course;
    double relative = std::max(std::min(found_.setting.relative, kTighterThan * accuracy_), kTightest), before = 0.0;
    Point point;
    while (run_into(method, relative, point, std::min(limit, end - thread_seconds()), true)) {
      limit = std::numeric_limits<double>::infinity();
      const double last = bgsim::judge({point.run.result.trace, point.run.events}, with(outputs)).largest();
      by_second_ = std::min(by_second_, last);
      course.there = last <= accuracy_ && !undecided(point);
      course.stays = !course.there && before > 0.0 && last > kFalls * before;
      if (course.there || (before > 0.0 && !course.stays)) {
        course.setting = point.setting;
        course.distance = last;
      }
      if (course.there) return course;
      before = last;
      const double leap = std::clamp(std::pow(last / (kAim * accuracy_), 1.0 / kPower), kTighter, kLongestLeap);
      if (relative / leap < kTightest) return course;  // another method may get there
      relative /= leap;
    }
    course.cut = before == 0.0 && point.run.cut;
    return course;
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
    if (absolute_)
      diagnostic.situation += "; the scene's absolute tolerances bound what a tighter relative one can do";
    else if (!unresolved && missed_error_ > 0.0 && facts.error > 0.2 * missed_error_)
      diagnostic.situation += "; tighter tolerances bring them no nearer, so this is rounding";
    else if (!unresolved)
      diagnostic.situation += "; a tighter tolerance is below what rounding leaves of a state";
    diagnostic.notes = std::move(notes_);
    diagnostic.rule = "what is measured must be larger than what it is measured with";
    diagnostic.help = (absolute_    ? "remove absolute tolerances from the scene"
                       : unresolved ? "record what \"" + facts.unresolved + "\" is made of, whose parts are larger"
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

  [[noreturn]] void fail_for_undecided(const Point& point) const {
    Diagnostic diagnostic = diagnostic_of("BG612");
    const RunReport& report = point.run.result.report;
    diagnostic.situation = "the accuracy " + number_text(accuracy_, 3) + " cannot be verified: with " +
                           setting_flags(point.setting) + " it is still open what happens within steps";
    for (const std::string& note : report.undecided) diagnostic.notes.push_back({std::nullopt, note});
    diagnostic.rule = "what is measured must be larger than what it is measured with";
    diagnostic.help = "run it with --relative, and see the notes of that run";
    throw TradeFailure(std::move(diagnostic));
  }

  /// No output can be judged: all are zero, or drown in what two runs differ by.
  [[noreturn]] void fail_for_rest() {
    for (const TradeOutput& output : reference_.outputs)
      if (output.drowned) {
        reference_.facts.unresolved = output.name;
        fail_for_reference();
      }
    Diagnostic diagnostic = diagnostic_of("BG611");
    diagnostic.situation = "no output of the scene moves: there is nothing to judge errors by";
    diagnostic.rule = "errors are measured against a reference, and a second method must vouch for it";
    diagnostic.help = "record outputs that vary";
    throw TradeFailure(std::move(diagnostic));
  }

  [[noreturn]] void fail_without_runs() {
    if (runs_.out_of_time()) {
      Diagnostic late = diagnostic_of("BG618");
      late.situation = "the limit of wall time was reached before a setting for the accuracy " +
                       number_text(accuracy_, 3) + " was found; runs so far: " + std::to_string(runs_.count());
      late.help = "allow more time, or ask for less accuracy";
      throw TradeFailure(std::move(late));
    }
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
