/// Conditions on states: when they change within a step, and which way they stand afterwards.
#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/integrate/integrator.hpp"
#include "run/watch/denominators.hpp"
#include "run/watch/guard_functions.hpp"
#include "run/watch/stiction.hpp"

namespace bgsim {

/// Watches the guards of a run on the dense output. A guard has crossed when it is on the other side of zero than the
/// mode means; a guard that is exactly zero at a start is undecided until it moves.
class EventWatch {
 public:
  /// @param hold  whether signs of resistors may be held at their border (see Stiction).
  EventWatch(const Program& program, const RunInputs& inputs, Evaluator& evaluator, const Tolerances& tolerances,
             bool hold);

  /// Sets all modes at the start of a run. False: failure().
  bool start(double t, const double* x, Branch& branch);
  /// Makes the modes agree with the guards at a point where something has jumped. False: failure().
  bool settle(double t, const double* x, Branch& branch);

  /// The same where an event of the model has set states: what a condition did before says nothing of a rest there.
  bool jumped(double t, const double* x, const ProgramEvent& event, Branch& branch);

  /// After all that events set at a state event: a guard that crossed there and is now on its way back, by the rates,
  /// is taken back at once, although rounding leaves it beyond its border: it has crossed again only when it is further
  /// beyond. True if any is.
  bool turn_back(double t, const double* x, Branch& branch);
  /// Whether a guard that was taken back crossed in the last event again before it was away by more than rounding or
  /// than the method tells, or one that is on its way back would not be away by more within the run.
  [[nodiscard]] bool unresolved() const { return unresolved_; }
  /// Whether a guard that crossed there is at its border still, and no step along the rates moves it.
  [[nodiscard]] bool rests() const { return rests_; }

  /// nearer: a denominator comes to zero, too far ahead to be believed; the step is to be made again, up to limit().
  enum class Search { none, found, failed, nearer };
  /// Looks for the first crossing in the integrator's last step; event_time() is the first moment beyond it, or the
  /// step's beginning where a guard that is 0 there goes at once to the other side. Changes nothing that a step made
  /// again would not find again.
  /// @param ends  of that step.
  Search search(Integrator& integrator, const StepEnds& ends);
  /// The end of the next stretch, which is @p end at most.
  [[nodiscard]] double limit(double t, double end) const { return cut_ && *cut_ > t ? std::min(*cut_, end) : end; }
  /// Whether the integrator has to restart at @p t because a stretch ends here.
  [[nodiscard]] bool is_limit(double t) const { return cut_ && *cut_ == t; }
  /// The step in which nothing was found is accepted.
  void pass();
  [[nodiscard]] double event_time() const { return event_time_; }
  /// Changes the modes whose guards have crossed at the event (states @p y at event_time()). False: failure().
  bool cross(const double* y, Branch& branch);

  /// The first of the guards that crossed in the last event.
  [[nodiscard]] std::optional<std::size_t> crossed_guard() const { return crossed_guard_; }

  /// Takes a guard across that the states' own tolerances cannot tell from zero, where the equations on its present
  /// side have come to an end (a square root at an empty tank). It comes back when it has clearly moved away. Where the
  /// other side cannot be evaluated there either (a root on each side), the mode is that of each point until then.
  /// False if there is no such guard, or failure() where it comes back again and again.
  bool take_across(double t, const double* x, Branch& branch);

  /// Whether a denominator of time alone that is zero at @p t leaves a rate without a bound: not in a branch of a
  /// condition that is not taken there.
  /// @param x  any states that are not yet those behind the singularity; @param branch  as it is before @p t
  bool is_singular(std::size_t relation, double t, const std::vector<double>& x, const Branch& branch);

  /// The relation of a denominator that has fallen to next to nothing of what it was where a run cannot go on at (t,
  /// x). None if there is no such one.
  [[nodiscard]] std::optional<std::size_t> singularity_ahead(double t, const double* x, Branch branch);

  /// Whether a condition changed again and again since the last call within what the tolerances leave open of its
  /// guard: these steps and changes are the method's own, not the model's.
  bool stays_within_tolerance() { return std::exchange(stays_within_tolerance_, false); }

  /// Whether modes are held that depend on the point: prepare() sets them before anything is evaluated there.
  [[nodiscard]] bool holding() const { return stiction_.any() || followed_any_; }
  [[nodiscard]] std::vector<AtBorder> held_laws() const { return stiction_.laws(); }
  /// Before start(): laws that are at their borders where this run goes on, though rounding may have left their guards
  /// the sign of the side that they leave.
  void know_at_border(std::vector<AtBorder> laws) { known_at_border_ = std::move(laws); }
  bool prepare(double t, const double* x, Branch& branch) {
    return (!followed_any_ || follow(t, x, branch)) && (!stiction_.any() || stiction_.balance(t, x, branch));
  }
  /// Where states are held: brings back what has left its border (see Stiction). True if any has.
  bool bring_back(double t, std::vector<double>& x, Branch& branch, double least) {
    return stiction_.any() && stiction_.bring_back(t, x, branch, least);
  }
  /// Rates with modes that depend on the point.
  bool rates(double t, const double* x, Branch& branch, double* rates) {
    if (!prepare(t, x, branch) || !evaluator_.rates(t, x, branch, rates)) return false;
    if (stiction_.any()) stiction_.still(rates);
    return true;
  }

  template <class Archive>
  void carry(Archive& archive) {
    archive("side", side_);
    archive("hold", hold_);
    archive("band", band_);
    archive("rest", rest_);
    archive("jumped at", jumped_at_);
    archive("turned at", turned_at_);
    archive("turned slope", turned_slope_);
    archive("turned hold", turned_hold_);
    archive("within", within_);
    archive("within way", within_way_);
    archive("returns", returns_);
    archive("excursion", excursion_);
    archive("crossed at", crossed_at_);
    archive("changed at", changed_at_);
    archive("passed", passed_);
    archive("idle", idle_);
    archive("followed", followed_);
    archive("followed any", followed_any_);
    archive("taken", taken_);
    archive("away", away_);
    archive("just crossed", just_crossed_);
    archive("largest", largest_);
    archive("count", count_);
    archive("times", times_);
    archive("relations", relations_);
    for (const std::size_t relation : relations_) archive.check(relation < program_.relations.size());
    archive("stiction", stiction_);
    archive("indefinite", indefinite_);
    for (const std::size_t output : indefinite_) archive.check(output < program_.output_names.size());
    archive("undecided", undecided_);
    for (const std::size_t relation : undecided_) archive.check(relation < program_.relations.size());
    archive("undecided at", undecided_at_);
    archive("cut", cut_);
    archive("onsets", onsets_);
    functions_.clear();
  }

  [[nodiscard]] bool any() const { return !side_.empty(); }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// That changed last; none if none has.
  [[nodiscard]] std::optional<std::size_t> latest_relation() const {
    return relations_.empty() ? std::nullopt : std::optional(relations_.back());
  }
  [[nodiscard]] const std::optional<Diagnostic>& failure() const { return failure_; }

  /// Outputs that were indefinite while more borders were held than the states have ways to move.
  [[nodiscard]] const std::vector<std::size_t>& indefinite() const { return indefinite_; }

  /// Relations of which the work allowed gave no proof that they did not change within a step, and when first.
  [[nodiscard]] const std::vector<std::size_t>& undecided() const { return undecided_; }
  [[nodiscard]] const std::vector<double>& undecided_at() const { return undecided_at_; }

 private:
  /// Guards that are 0 where a stretch begins, and which way they go (events_onset.cpp).
  struct Onsets {
    bool begins = true;  ///< the next step is the first of a stretch
    bool known = true;   ///< needs no search: nothing was 0, or it has been made
    double from = -std::numeric_limits<double>::infinity(), until = from;  ///< what is known holds between these times
    std::vector<double> states;                                            ///< at `from`
    std::vector<int> before;                                               ///< by guard: its side there; 0: none
    std::vector<int> side;     ///< by guard: the one it goes to; 0: not known, or it was not 0
    std::vector<double> size;  ///< by guard with a side: by how much it moves until then

    template <class Archive>
    void carry(Archive& archive) {
      archive("begins", begins);
      archive("known", known);
      archive("from", from);
      archive("until", until);
      archive("states", states);
      archive("before", before);
      archive("side", side);
      archive("size", size);
    }
  };
  /// Held for: a guard that is 0, on the side that it goes to at once.
  static constexpr double kSetOut = std::numeric_limits<double>::min();
  static constexpr double kClearlyOut = 16.0;  ///< of a band around a border that has been crossed in a row
  /// A change at most so many steps after the one before is a return.
  static constexpr std::uint64_t kStepsToReturn = 4;
  /// So many changes of one condition, each a few steps after the one before, may be those of a state at rest.
  static constexpr int kReturns = 8;

  static int sign_of(double value) { return (value > 0.0) - (value < 0.0); }
  [[nodiscard]] bool crossed(std::size_t guard, double value, const Branch& branch) const;
  [[nodiscard]] bool any_crossed(const std::vector<double>& values, const Branch& branch) const;
  [[nodiscard]] bool changes_at_border(std::size_t guard, const Branch& branch) const;
  /// Of the two guards of a floor, round or table cell, that of the upper border.
  [[nodiscard]] bool is_upper(std::size_t guard) const { return guard > 0 && relation_[guard - 1] == relation_[guard]; }
  [[nodiscard]] double mode_at_zero(std::size_t relation) const;
  [[nodiscard]] bool changes_mode(std::size_t guard, int side, const Branch& branch) const;
  void decide(const std::vector<double>& values);
  void see_excursions();
  void widen_bands_of_returns(double t, const double* x, Branch& branch);
  bool rests_at_zero(std::size_t guard, double error, double t, const double* x, const Branch& branch);
  bool leads_back_only(std::size_t guard, double t, const double* x, const Branch& branch);
  bool change(const std::vector<double>& values, Branch& branch);
  bool guards(double t, const double* x, Branch& branch, std::vector<double>& values);
  bool evaluate(Integrator& integrator, double t, std::vector<double>& values);
  bool find_modes(double t, const double* x, Branch& branch);
  void keep_what_only_wavers(const Branch& branch);
  void keep_what_is_nothing(double t, const double* x, const Branch& branch);
  void release_what_jumped(double t, const double* x, Branch& branch);
  /// How the guards that have just crossed are known to be near their borders.
  enum class Near : std::uint8_t {
    here,     ///< by where they are
    crossed,  ///< they have crossed at this instant, and not by a jump
    surely,   ///< it is known from before the start
  };
  void hold_what_rests(double t, const double* x, Branch& branch, Near near, const std::vector<GuardMode>& known = {});
  std::optional<double> dip(double from, double to, const std::vector<double>& middle,
                            const std::vector<double>& end) const;
  bool locate(Integrator& integrator, double from, double to);
  bool fail_with_fault();
  Search check_denominators(Integrator& integrator);
  [[nodiscard]] Approach approach(Integrator& integrator);
  [[nodiscard]] bool stays(std::size_t guard, const Range& values, double at);
  bool is_nothing(std::size_t guard, double size, double at);
  void keep_start(const StepEnds& ends, const Branch& branch);
  void forget_onsets(const ProgramEvent& event);
  [[nodiscard]] bool may_set_out(std::size_t guard) const;
  bool sets_out_in_rounding(const StepEnds& ends, const Branch& branch);
  bool find_onsets(const Integrator& integrator, const StepEnds& ends);
  [[nodiscard]] bool crosses_at_once(double t, const Branch& branch) const;
  void keep_onsets(double t, std::vector<double>& values) const;
  std::optional<std::pair<double, double>> bracket(Integrator& integrator, double from, double to);
  FirstCrossing prove(double from, double to);
  [[nodiscard]] std::vector<std::size_t> followed_relations() const;
  [[nodiscard]] std::vector<GuardFunctions::Held> held() const;
  std::optional<std::pair<double, double>> bracket_by_samples(Integrator& integrator, double from, double to);
  bool follow(double t, const double* x, Branch& branch);
  void stop_following(std::size_t guard);
  void take_what_was_located(const Branch& branch);
  bool check_for_chattering(double t, const double* x, const Branch& branch);
  bool is_singular_at(double t, const double* x, const Branch& branch);
  [[nodiscard]] std::vector<double> guard_errors(double t, const double* x, const Branch& branch);
  struct Motion {
    double after, change;  ///< time; by how much a guard has moved then
  };
  [[nodiscard]] std::optional<Motion> motion(std::size_t guard, double t, const double* x,
                                             const std::vector<double>& rates, Branch branch, double rounding,
                                             bool& fault);
  [[nodiscard]] bool lost_since_turned(std::size_t guard, double t, const double* x, const Branch& branch);
  [[nodiscard]] std::vector<double> roundings(double t, const double* x, const Branch& branch);
  [[nodiscard]] std::vector<double> spread(double t, const double* x, const Branch& branch,
                                           const std::vector<double>& here, double later,
                                           const std::vector<double>& moves);
  [[nodiscard]] std::vector<double> shaken(double t, const double* x, Branch branch, const std::vector<double>& f);
  bool is_kink(std::size_t guard, double t, const double* x, const Branch& branch);
  [[nodiscard]] std::vector<double> uphill(std::size_t guard, double t, const double* x, const Branch& branch);
  bool both_go_on(std::size_t guard, double t, const double* x, const Branch& branch);
  bool meets_at_border(std::size_t guard, double t, const double* x, const Branch& branch);
  bool rest_at_kinks(double t, const double* x, const Branch& branch);
  /// No change is seen up to this size of a guard on its other side.
  [[nodiscard]] double slack(std::size_t guard) const { return std::max(hold_[guard], band_[guard]); }
  [[nodiscard]] std::vector<std::size_t> recent_relations() const;

  const Program& program_;
  Evaluator& evaluator_;
  double span_;
  bool may_hold_, fixed_steps_;
  const Tolerances& tolerances_;
  Stiction stiction_;
  std::vector<AtBorder> known_at_border_;  ///< at the start
  std::vector<std::size_t> relation_;      ///< by guard
  Denominators denominators_;
  std::vector<bool> border_;  ///< by guard: of a floor or table cell
  std::vector<int> side_;     ///< by guard: side of its mode; 0 undecided
  std::vector<double> hold_;  ///< by guard: not seen as crossed up to this size; see take_across
  std::vector<double> band_;  ///< by guard: the same, around a kink that what rests there crossed in a row
  std::vector<double> rest_;  ///< by guard: its sign is 0, and stays so up to this size
  std::vector<double> turned_at_, turned_slope_, turned_hold_;  ///< by guard: of turn_back(); slope 0: never
  std::vector<std::size_t> within_;        ///< by guard: so often in a row it came back from within the tolerances
  std::vector<double> within_way_;         ///< by guard: how far it had gone in the first of these
  std::vector<std::size_t> crossed_here_;  ///< guards that crossed in the last event, until turn_back()
  bool unresolved_ = false, rests_ = false;
  double jumped_at_ = -std::numeric_limits<double>::infinity();  ///< when an event of the model last set states
  std::vector<int> returns_;                                     ///< by guard: changes in a row, a few steps apart
  std::vector<double> excursion_;          ///< by guard: its largest magnitude since the first of these
  std::vector<std::uint64_t> crossed_at_;  ///< by guard: passed_ at its last change
  std::uint64_t passed_ = 0;               ///< steps without a change
  std::uint64_t changed_at_ = 0;           ///< passed_ at the last change of any
  bool stays_within_tolerance_ = false;
  std::vector<bool> idle_;      ///< by guard: beyond the last border, nothing left to change
  std::vector<bool> followed_;  ///< by guard: its mode is that of each point; see take_across
  bool followed_any_ = false;
  std::vector<std::size_t> taken_;   ///< by guard: times taken across a jump since it was clearly away
  std::vector<double> away_;         ///< by guard: what is clearly away
  std::vector<double> guards_here_;  ///< of follow()
  std::vector<int> sides_here_;
  std::optional<std::size_t> crossed_guard_;
  std::vector<bool> just_crossed_;       ///< by guard
  std::vector<bool> changed_;            ///< by guard: within the event that is being settled
  std::vector<double> largest_;          ///< by guard: its largest magnitude so far
  bool screened_ = false;                ///< the last step stayed where no guard can cross
  std::vector<std::size_t> candidates_;  ///< guards to be searched
  std::vector<double> values_, middle_, end_, at_probe_;
  std::vector<int> direction_;
  Onsets onsets_;
  std::vector<double> y_;
  Branch probe_;  ///< within the step that is searched
  double event_time_ = 0.0;
  std::optional<std::size_t> located_;  ///< a guard that the search saw beyond its border at the event
  std::optional<double> cut_;           ///< no step passes this time: a denominator may come to zero behind it
  std::uint64_t count_ = 0;
  std::deque<double> times_;           ///< of the latest events
  std::deque<std::size_t> relations_;  ///< that changed in them
  std::optional<Diagnostic> failure_;
  std::vector<std::size_t> indefinite_;
  std::vector<std::size_t> undecided_;
  std::vector<double> undecided_at_;
  Integrator* searched_ = nullptr;                                ///< whose last step is searched
  double nothing_at_ = std::numeric_limits<double>::quiet_NaN();  ///< where nothing_ is known, within that step
  double probed_at_ = std::numeric_limits<double>::quiet_NaN();   ///< of a search: when at_probe_ was evaluated last
  bool setting_out_ = false;     ///< the stretch that is searched ends before onset_until_
  std::vector<double> nothing_;  ///< by guard: of is_nothing()
  GuardFunctions functions_;
};

}  // namespace bgsim
