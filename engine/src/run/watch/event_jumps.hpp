/// The events of a model: stores that are set at the instant at which a condition becomes true.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// What is known of a model's events from before; each by event. The same in all programs of a model.
struct EventMemory {
  std::vector<bool> armed;                 ///< the condition has been false since it last took place
  std::vector<bool> starts;                ///< it takes place at the start, and has not yet
  std::vector<std::vector<double>> times;  ///< the latest at which it took place
  std::vector<double> longest;             ///< interval between two of these so far
  std::vector<std::uint64_t> counts;
  std::vector<double> energies;  ///< that it brought to the stores, in all
  std::uint64_t here = 0;        ///< how many took place at `here_at`
  double here_at = 0.0;
  [[nodiscard]] bool empty() const { return armed.empty(); }

  template <class Archive>
  void carry(Archive& archive) {
    archive("armed", armed);
    archive("starts", starts);
    archive("times", times);
    archive("longest", longest);
    archive("counts", counts);
    archive("energies", energies);
    archive("here", here);
    archive("here at", here_at);
  }
};

/// Looks which events are due. One is due where its condition holds and has not held since it last took place, so no
/// width of a hysteresis is needed: after a jump it stays as it is until the condition is false.
class EventJumps {
 public:
  EventJumps(const Program& program, Evaluator& evaluator, const RunInputs& inputs);

  [[nodiscard]] bool any() const { return !program_.events.empty(); }
  /// At the start of a run: of samples and latches. False: failure().
  bool begin(double t, const double* x, Branch& branch);
  /// Of the other events, once signals with memory are what they are at the start. A condition that holds there does
  /// not become true; a note says so. False: failure().
  bool begin_others(double t, const double* x, Branch& branch, std::vector<std::string>& notes);
  /// Finds what is due at (t, x), of these those of the highest priority, and what it sets. False: failure().
  /// @param memory  of samples and latches alone: signals with memory of one instant change together, and no other
  ///                condition is looked at while some of them have changed and others have not.
  bool look(double t, const double* x, Branch& branch, bool memory);
  /// Whether those that are due are samples or latches.
  [[nodiscard]] bool of_memory() const { return !due_.empty() && program_.events[due_.front()].memory; }
  /// Events that are due, by position in Program::events.
  [[nodiscard]] const std::vector<std::size_t>& due() const { return due_; }
  /// Sets what the event @p event sets, as found by look(). It counts, unless it leaves a latch on the side that it is
  /// on.
  void set(std::size_t event, std::vector<double>& x);
  /// What a state is set to changes by with the parameter of a program with Variations, and with the instant.
  struct SetSlope {
    std::uint32_t state = 0;
    double by_parameter = 0.0, by_time = 0.0;
  };
  /// Of all that the events that are due set, as found by look(). @pre the program has Variations.
  [[nodiscard]] std::vector<SetSlope> set_slopes() const;
  /// Sets what those that are due set, from the values at another time and point. False if these cannot be evaluated.
  bool set_elsewhere(double t, std::vector<double>& x, Branch branch);
  /// The events that are due have taken place at @p t. False: failure(), where they accumulate or have no end.
  bool taken(double t);
  /// Whether an event that took place in ever shorter intervals would be overdue at @p t: what lies between has become
  /// too small for the doubles. Then failure().
  bool overdue(double t);

  /// BG623: @p event is back at @p t before what it turned round was away by more than rounding.
  [[nodiscard]] Diagnostic accumulation(std::size_t event, double t) const;

  /// Whether one of those that are due has taken place at @p t before.
  [[nodiscard]] bool repeats(double t) const;
  /// BG604: those that are due follow from themselves. @param how  "1000 events so far".
  [[nodiscard]] Diagnostic endless(double t, const std::string& how) const;

  /// A note, once for each: what @p event set keeps its guard where it is.
  [[nodiscard]] std::optional<std::string> resting(std::size_t event, double t);

  [[nodiscard]] const std::optional<Diagnostic>& failure() const { return failure_; }
  [[nodiscard]] const EventMemory& memory() const { return memory_; }
  void remember(EventMemory memory) { memory_ = std::move(memory); }
  void bring(std::size_t event, double energy) { memory_.energies[event] += energy; }

  template <class Archive>
  void carry(Archive& archive) {
    memory_.carry(archive);
    archive("noted", noted_);
  }

 private:
  /// Intervals between the latest times of an event that shrink in a steady ratio.
  struct Series {
    double last = 0.0, ratio = 0.0, limit = 0.0;  ///< latest interval; time to which they add up
  };
  [[nodiscard]] std::optional<Series> series(std::size_t event, double steady) const;
  [[nodiscard]] Diagnostic accumulation(std::size_t event, const Series& series) const;
  [[nodiscard]] Diagnostic accumulated(std::size_t event, const std::string& where, const std::string& how) const;
  bool conflicts();
  /// Of all events. False: failure().
  bool see_conditions(double t, const double* x, Branch& branch);

  const Program& program_;
  Evaluator& evaluator_;
  std::vector<std::size_t> starting_;
  double stop_;
  EventMemory memory_;
  std::vector<double> conditions_, values_, values_elsewhere_;
  std::vector<std::size_t> due_;
  std::vector<bool> noted_;  ///< by event: see resting()
  std::optional<Diagnostic> failure_;
};

}  // namespace bgsim
