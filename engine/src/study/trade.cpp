// The whole table: every method over its tolerances or steps.
#include "bgsim/trade.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "bgsim/study.hpp"
#include "run/choose.hpp"
#include "run/failures.hpp"
#include "run/integrate/separability.hpp"
#include "study/trade_runs.hpp"

namespace bgsim {

namespace {

constexpr double kReferenceTolerance = 1e-11, kReferenceWanted = 1e-9;
/// Tolerances of error-controlled methods.
constexpr std::array<double, 11> kTolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12};
/// Steps of one length: the scene in 100 to 1e7 of them.
constexpr double kFewestSteps = 100.0, kMostSteps = 1e7, kMoreSteps = 3.1622776601683795;
/// An error beyond so many ranges of the output is no inaccuracy but a solution that runs away.
constexpr double kRunaway = 10.0;
/// Errors nearer to the reference's own are not distinguished.
constexpr double kDistinguished = 3.0;
/// Nobody asks for an accuracy looser than this.
constexpr double kOfUse = 1e-2;
/// Settings are worth running to their end if they cost no more than so many times one that is asked for.
constexpr double kAsGood = 2.0;

/// A curve of the picture: one method.
struct Ladder {
  TradeSetting setting;
  bool over = false;  ///< nothing beyond here is worth running
  double next_steps = kFewestSteps;
  double error = 0.0;  ///< of the last row; 0: not known
};

/// Collocation of order 9 and 13 is for accurate runs: its first row is the one below this tolerance.
constexpr double kHighOrdersBelow = 1e-5;

std::vector<Ladder> ladders(const Program& program) {
  std::vector<Ladder> all;
  const bool explicit_form = program.plan.explicit_form && program.system_class != SystemClass::implicit_dae;
  NotSeparable obstacle;
  for (const MethodFacts& facts : all_methods()) {
    if (facts.method == Method::automatic) continue;
    if (!explicit_form && !solves_for_loops(facts)) continue;
    if (facts.method == Method::verlet && !separate(program, obstacle)) continue;
    const bool high = facts.family == MethodFamily::collocation && facts.method != Method::radau;
    all.push_back({{facts.method, 0, high ? kHighOrdersBelow : 0.0, 0.0}});
    // The highest order of BDF that is stable wherever the solution is.
    if (facts.method == Method::bdf) all.push_back({{facts.method, 2, 0.0, 0.0}});
  }
  return all;
}

/// Mean steps of an explicit method, times the fastest rate, that speak of its border of stability. The border is two
/// to about five; the fastest rate is that of the start, and not every step lies at the border.
constexpr double kBorderFrom = 1.0, kBorderTo = 8.0;

class TradeTable {
 public:
  TradeTable(const TradeScene& scene, const TradeOptions& options)
      : runs_(scene, options), options_(options), span_(scene.inputs.stop - scene.inputs.start) {
    const Program& program = scene.program;
    const RunInputs& inputs = scene.inputs;
    trade_.model = program.model->name;
    trade_.scene = inputs.scene;
    reference_ = find_reference(runs_, kReferenceTolerance, kReferenceWanted, options.budget);
    trade_.outputs = reference_.outputs;
    trade_.reference = reference_.facts;
    trade_.fastest_rate = fastest_rate(program, inputs);
    TradeSetting usual;
    usual.relative = inputs.relative;
    const TimedRun run = runs_.plain(usual, options.budget / 4.0);
    limit_ = std::max(options.budget / 60.0, run.completed() ? 3.0 * run.cpu_seconds : 0.0);
  }

  Trade fill(std::vector<Ladder> all) {
    // Loose before tight, so that a budget that runs out leaves every curve with its cheap end.
    const double begin = thread_seconds();
    std::string unfinished;
    for (const TradeSetting& setting : options_.also) {
      const double limit = std::exchange(limit_, std::numeric_limits<double>::infinity());
      trade_.rows.push_back(measure(setting));
      // What is as good may cost as much.
      limit_ = std::max(limit, kAsGood * trade_.rows.back().cpu_seconds);
    }
    for (bool more = true; more && !runs_.ended();) {
      more = false;
      for (Ladder& ladder : all) {
        if (ladder.over || runs_.ended()) continue;
        if (thread_seconds() - begin > options_.budget) {
          ladder.over = true;
          unfinished += (unfinished.empty() ? "" : ", ") + curve_name(ladder.setting);
          continue;
        }
        climb(ladder);
        more = more || !ladder.over;
      }
    }
    if (!unfinished.empty())
      trade_.notes.push_back("the budget of " + number_text(options_.budget, 3) +
                             " s was spent before these came to their tight ends: " + unfinished);
    sort();
    mark_pareto();
    return std::move(trade_);
  }

 private:
  void climb(Ladder& ladder) {
    TradeSetting& setting = ladder.setting;
    const bool fixed = facts_of(setting.method).fixed_step();
    if (fixed) {
      setting.step = span_ / ladder.next_steps;
      ladder.next_steps *= kMoreSteps;
    } else {
      // Errors fall in proportion to the tolerance at best: what would be of no use all the same is passed over.
      const double before = setting.relative > 0.0 ? setting.relative : 1.0;
      const double below = std::min(0.99, kOfUse / ladder.error) * before;
      const auto next = std::find_if(kTolerances.begin(), kTolerances.end() - 1, [&](double t) { return t <= below; });
      setting.relative = *next;
    }
    const TradeRow row = measure(setting);
    const bool last = fixed ? ladder.next_steps > kMostSteps : setting.relative == kTolerances.back();
    const bool exact =
        row.verdict == TradeVerdict::stable && row.max_error < kDistinguished * std::max(trade_.reference.error, 1e-12);
    const bool hopeless = row.verdict == TradeVerdict::failed && !fixed;
    ladder.error = row.whole() ? std::min(row.max_error, kRunaway) : 0.0;
    ladder.over = last || exact || hopeless || row.verdict == TradeVerdict::too_costly;
    trade_.rows.push_back(row);
  }

  TradeRow measure(const TradeSetting& setting) {
    runs_.tell(setting_flags(setting));
    TradeRow row;
    row.setting = setting;
    const TimedRun judged = runs_.judge(setting, limit_);
    const RunReport& report = judged.result.report;
    row.steps = report.steps;
    row.rates = report.rate_evaluations;
    row.jacobians = report.jacobian_evaluations;
    row.factorizations = report.factorizations;
    row.cpu_seconds = judged.cpu_seconds;
    row.repeats = 1;
    if (!judged.completed()) {
      row.verdict = judged.cut ? TradeVerdict::too_costly : TradeVerdict::failed;
      row.why = judged.cut ? cut_words(setting, judged) : judged.result.failure.value().situation;
      if (!judged.cut && beyond_stability(setting)) {
        row.verdict = TradeVerdict::unstable;
        row.why = stability_words(setting) + "; " + row.why;
      }
      return row;
    }
    if (report.energy.done) row.energy_residual = report.energy.relative;
    const Judgement judgement = judge({judged.result.trace, judged.events}, reference_);
    row.errors = judgement.errors;
    row.max_error = judgement.max_error;
    row.rms_error = judgement.rms_error;
    row.check_error = judgement.check_error;
    if (row.max_error > kRunaway) {
      row.verdict = TradeVerdict::unstable;
      row.why = beyond_stability(setting) ? stability_words(setting)
                                          : "the error grows to " + number_text(row.max_error, 2) + " ranges";
      return row;
    }
    RunResult first;
    row.cpu_seconds = runs_.median_seconds(setting, 2.0 * limit_, row.repeats, first);
    // The audit asks for points between the steps, which costs rates of its own: the counts are those of a plain run.
    row.steps = first.report.steps;
    row.rates = first.report.rate_evaluations;
    row.jacobians = first.report.jacobian_evaluations;
    row.factorizations = first.report.factorizations;
    if (held_by_stability(row)) row.why = "its steps are held by the fastest mode, not by the tolerance";
    return row;
  }

  [[nodiscard]] bool beyond_stability(const TradeSetting& setting) const {
    const MethodFacts& facts = facts_of(setting.method);
    return facts.fixed_step() && !facts.implicit() && setting.step * trade_.fastest_rate > 2.0;
  }
  [[nodiscard]] std::string stability_words(const TradeSetting& setting) const {
    return "the step is " + number_text(setting.step * trade_.fastest_rate, 2) +
           " times what the fastest mode takes (1/" + number_text(trade_.fastest_rate, 2) +
           " at the start), beyond what is stable";
  }
  /// An explicit method whose mean step lies at its border of stability.
  [[nodiscard]] bool held_by_stability(const TradeRow& row) const {
    const MethodFacts& facts = facts_of(row.setting.method);
    if (facts.family != MethodFamily::explicit_runge_kutta || row.steps == 0) return false;
    return at_border(span_ / static_cast<double>(row.steps));
  }
  [[nodiscard]] bool at_border(double mean_step) const {
    const double reach = mean_step * trade_.fastest_rate;
    return reach > kBorderFrom && reach < kBorderTo;
  }
  [[nodiscard]] std::string cut_words(const TradeSetting& setting, const TimedRun& run) const {
    const double done = (run.result.report.reached - runs_.inputs().start) / span_;
    std::string text = "cut after " + number_text(limit_, 2) + " s, " + number_text(100.0 * done, 2) +
                       " % of the scene done in " + std::to_string(run.result.report.steps) + " steps";
    const MethodFacts& facts = facts_of(setting.method);
    const double mean = done * span_ / static_cast<double>(std::max<std::uint64_t>(run.result.report.steps, 1));
    if (!facts.implicit() && !facts.fixed_step() && at_border(mean))
      text += "; stability holds an explicit method's steps below a few times 1/" +
              number_text(trade_.fastest_rate, 2) + ", the fastest mode's time";
    return text;
  }

  /// By curve, each from its cheap to its exact end.
  void sort() {
    std::stable_sort(trade_.rows.begin(), trade_.rows.end(), [](const TradeRow& a, const TradeRow& b) {
      return std::pair(a.setting.method, a.setting.max_order) < std::pair(b.setting.method, b.setting.max_order);
    });
  }

  void mark_pareto() {
    std::vector<std::size_t> order(trade_.rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return trade_.rows[a].cpu_seconds < trade_.rows[b].cpu_seconds;
    });
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t i : order) {
      TradeRow& row = trade_.rows[i];
      if (row.verdict != TradeVerdict::stable || row.max_error >= least) continue;
      row.pareto = true;
      least = row.max_error;
    }
  }

  TradeRuns runs_;
  const TradeOptions& options_;
  double span_;
  double limit_ = 0.0;  ///< seconds for one run
  ReferenceTrace reference_;
  Trade trade_;
};

}  // namespace

const char* verdict_text(TradeVerdict verdict) {
  switch (verdict) {
    case TradeVerdict::stable:
      return "stable";
    case TradeVerdict::unstable:
      return "unstable";
    case TradeVerdict::failed:
      return "failed";
    case TradeVerdict::too_costly:
      return "too costly";
  }
  return "";
}

Trade measure_trade(const Simulation& scene, const TradeOptions& options) {
  return TradeTable(trade_scene(scene), options).fill(ladders(scene.program()));
}

Trade measure_trade(const Program& program, const RunInputs& inputs, const TradeOptions& options) {
  return TradeTable(trade_scene(program, inputs), options).fill(ladders(program));
}

std::optional<std::size_t> pick_row(const Trade& trade, double accuracy) {
  if (!trade.reference.tells(accuracy, kDistinguished)) return std::nullopt;
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < trade.rows.size(); ++i) {
    const TradeRow& row = trade.rows[i];
    if (row.verdict != TradeVerdict::stable || row.max_error > accuracy || row.check_error > accuracy) continue;
    if (!best || row.cpu_seconds < trade.rows[*best].cpu_seconds) best = i;
  }
  return best;
}

}  // namespace bgsim
