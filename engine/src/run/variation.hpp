/// Sensitivities at events: what the run of a system with Variations does where a condition changes.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

/// What guards change by with time, and with what is varied: one parameter, or all states and parameters at once.
class GuardSlopes {
 public:
  virtual ~GuardSlopes() = default;
  GuardSlopes() = default;
  GuardSlopes(const GuardSlopes&) = delete;
  GuardSlopes& operator=(const GuardSlopes&) = delete;

  /// At this point from now on; false if the equations have no value there.
  virtual bool at(double t, const std::vector<double>& x, Branch& branch) = 0;
  [[nodiscard]] virtual double by_time(std::size_t relation) = 0;
  /// By what is varied, always in the same order.
  [[nodiscard]] virtual std::vector<double> by_variation(std::size_t relation) = 0;
  /// In what unit each of these is counted where two of them are compared: the magnitude of what is varied.
  [[nodiscard]] virtual double unit(std::size_t of) const = 0;
};

/// The same by the one parameter of a program with Variations.
class VariedGuards : public GuardSlopes {
 public:
  explicit VariedGuards(Evaluator& evaluator)
      : evaluator_(evaluator), values_(2 * evaluator.program().relations.size()) {}
  bool at(double t, const std::vector<double>& x, Branch& branch) override {
    return evaluator_.crossings(t, x.data(), branch, values_.data());
  }
  double by_time(std::size_t relation) override { return values_[2 * relation + 1]; }
  std::vector<double> by_variation(std::size_t relation) override { return {values_[2 * relation]}; }
  [[nodiscard]] double unit(std::size_t) const override { return 1.0; }

 private:
  Evaluator& evaluator_;
  std::vector<double> values_;
};

/// Where conditions change, the instant of the event depends on what is varied, too: with t' its derivative, the
/// sensitivities of the states jump by (f- - f+) t', f- and f+ being the rates before and after. Where an event sets
/// the states to h(x, z, p, t), they become dh/dp + dh/dt t' - f+ t'.
class VariationEvents {
 public:
  /// @param own_states   those whose rates are looked at: the first ones
  /// @param with_outputs whether the outputs count as rates, of integrals over them
  /// @param span         length of the run
  VariationEvents(std::size_t own_states, bool with_outputs, double span)
      : states_(own_states), with_outputs_(with_outputs), span_(span) {}

  /// @param sets  whether an event takes place at the start
  /// @return BG414 if a condition that decides rates, or an event, is at its border at the start of the run, and moves
  /// away from it.
  std::optional<Diagnostic> begin(Evaluator& evaluator, GuardSlopes& guards, double t, const std::vector<double>& x,
                                  const Branch& branch, bool sets);

  /// Begins at an instant of another run, whose t' is that: what takes place here at once has it as well.
  void follow(double t, double instant) {
    time_ = t;
    changes_.push_back({0, {instant}, 0.0, 0.0});
  }

  /// What an event does.
  struct Jump {
    std::vector<double> instant;  ///< t' by what is varied
    std::vector<double> rates;    ///< f- - f+ by state; then, with outputs, the same of these
  };
  /// Looks at an event.
  /// @param x        the states
  /// @param before, after  the event
  /// @param crossed  the relation whose guard was found at its border; none at a known time
  /// @param refused  BG414 where the derivative does not exist or cannot be found
  /// @return none if nothing jumps
  std::optional<Jump> take(Evaluator& evaluator, GuardSlopes& guards, double t, const std::vector<double>& x,
                           const Branch& before, const Branch& after, std::optional<std::size_t> crossed,
                           std::optional<Diagnostic>& refused);

  /// A condition at its border as the run ends, which has not changed yet.
  struct Ahead {
    Branch behind;      ///< where it has
    Jump jump;          ///< `rates` is empty where these have no value there
    bool sets = false;  ///< an event of the model is due behind it
  };
  /// Those whose instants move with what is varied.
  std::vector<Ahead> ahead(Evaluator& evaluator, GuardSlopes& guards, double t, const std::vector<double>& x,
                           const Branch& branch) const;

  /// t', by what is varied, of all that has changed at @p t; empty: nothing has. None: they are not the same, or not
  /// known.
  std::optional<std::vector<double>> instant(const GuardSlopes& guards, double t) const;

  /// What t', by what is varied, of the event that was last taken is for what is set there; empty: 0 by all.
  /// @param event  that sets it, at @p t
  /// @param refused  BG414 if that is not known, or does not exist: conditions that another value of the parameter
  ///                 parts changed there, or their border is touched and not passed.
  std::optional<std::vector<double>> instant_of_set(const GuardSlopes& guards, const ProgramEvent& event, double t,
                                                    std::optional<Diagnostic>& refused) const;

  /// Whether a condition that changed, from that mode, has a part in what takes place.
  using Decides = std::function<bool(std::size_t relation, double before)>;
  /// The same of the switches that leave their sides at @p t.
  std::optional<std::vector<double>> instant_of_leaving(const GuardSlopes& guards, double t, const Decides& decides,
                                                        std::optional<Diagnostic>& refused) const;

 private:
  [[nodiscard]] std::optional<std::vector<double>> instant_at(const GuardSlopes& guards, double t,
                                                              const Decides& decides) const;
  /// BG414: why there is no instant_at(), of what takes place.
  [[nodiscard]] Diagnostic no_instant(const std::string& what, double t, std::optional<Place> place,
                                      std::string rule) const;
  /// A condition that has changed, and what its instant changes by with the parameter.
  struct Change {
    std::size_t relation = 0;
    std::vector<double> instant;
    double before = 0.0, after = 0.0;  ///< its mode
  };
  [[nodiscard]] bool rates(Evaluator& evaluator, double t, const std::vector<double>& x, Branch& branch,
                           std::vector<double>& values) const;
  [[nodiscard]] bool matters(Evaluator& evaluator, const GuardSlopes& guards, double t, const std::vector<double>& x,
                             const Branch& after, const std::vector<double>& instant) const;

  std::size_t states_;
  bool with_outputs_;
  double span_;
  // What has changed at one time, maybe by several events of the run.
  double time_ = 0.0;
  std::optional<Branch> start_;
  std::vector<Change> changes_;
  bool touched_ = false;  ///< a condition changed whose border is touched and not passed
};

/// Whether an event at @p t is one at the end of a run: which of the two comes first, rounding says.
bool is_end(double t, double start, double stop);

/// Where a run with variations has left its mode.
struct Departure {
  std::vector<double> x, rates;
  Branch branch;
  std::optional<double> instant;  ///< t' by what is varied; none: the mode was left as it began
};

/// BG414: signs of resistors are held at their border, where rates are no expressions of the states.
Diagnostic held_variation_failure(const Program& program, double t);
/// BG414: impacts of a contact accumulate.
Diagnostic accumulation_variation_failure(const Element& contact, double t);
/// BG414: a law ends at the border of its own condition.
Diagnostic ended_law_failure(double t);

}  // namespace bgsim
