/// Sensitivities where a switched run goes from one mode to the next.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/arrivals.hpp"
#include "run/diodes.hpp"
#include "run/switched.hpp"
#include "run/variation.hpp"

namespace bgsim {

/// At one instant the stores go through one or several jumps: from what the mode that was left makes of its states, by
/// impacts and by ties, to the states of the mode that comes. With d the change of all this by what is varied, at an
/// instant that follows it (x by s + f- t', the time by t'), the sensitivities become d - f+ t'. The jumps are
/// functions that a run has as code and not as expressions: d is the limit of differences of the same jumps, with the
/// same sides, extrapolated. The run of the next mode subtracts f+ t', since it alone knows the sides of conditions at
/// their borders.
class ModeVariation {
 public:
  /// @param slopes  must outlive this
  ModeVariation(const SwitchedVariation& slopes, const RunInputs& inputs) : of_(slopes), inputs_(inputs) {}

  /// A mode is left at @p t. @param stored  what all stores hold there
  /// @param scales  by state of @p program: the largest magnitude so far
  void leave(const Program& program, const std::vector<double>& parameters, double t, Departure departure,
             const Stored& stored, std::vector<double> scales);
  /// An impact. @param kick  see DiodeSides::kick
  void impact(const ImpactProgram& impact, const DiodeNetwork& network, const std::vector<std::optional<double>>& kick);
  /// The mode has been left where a contact has come to its gap. @param contact  by diode
  void arrive(std::size_t contact);
  /// It closes there for good, since its impacts add up. What leaves the mode is then what the infinitely many leave,
  /// at the instant at which they end; the next mode begins before it all the same, as the run does.
  /// @return  false where that has no limit
  [[nodiscard]] bool close(std::size_t contact, const Accumulation& series);
  /// A jump into a mode that is not the last one of the instant.
  void tie(const Program& program, const std::vector<double>& parameters);
  /// d in @p x as the mode begins. None if it is known; else BG414, or a fault.
  /// @param scales  by state: the largest magnitude so far
  std::optional<Diagnostic> enter(const Program& program, const std::vector<double>& parameters, double t,
                                  const std::vector<double>& scales, std::vector<double>& x);

  /// t' of the present instant.
  [[nodiscard]] double instant() const { return instant_; }

 private:
  /// What takes what the stores hold before it to what they hold after it.
  struct Step {
    const Program* program = nullptr;
    std::vector<double> parameters;
    const ImpactProgram* impact = nullptr;
    const DiodeNetwork* network = nullptr;
    std::vector<bool> kicked;  ///< by diode
    bool lands = false;        ///< some contact takes an impulse and does not rebound
  };
  struct Left {
    const Program* program = nullptr;
    std::vector<double> parameters;
    Departure departure;
    Stored stored;
    std::vector<double> scales;
  };
  /// The states of @p program with what is varied moved by @p h; empty where something has no value.
  [[nodiscard]] std::vector<double> at(double h, double t, const Step& last) const;
  [[nodiscard]] std::optional<Stored> before(double h, double t) const;
  [[nodiscard]] std::vector<double> moved(std::vector<double> parameters, double h) const;
  [[nodiscard]] bool take(const Step& step, double h, double t, Stored& stored) const;
  /// The name of a contact that does not rebound, and would with what is varied moved by @p h; else empty.
  [[nodiscard]] std::string begins_to_rebound(double h, double t) const;
  [[nodiscard]] std::optional<std::vector<double>> kicks(const Step& step, double h, double t,
                                                         const Stored& stored) const;
  [[nodiscard]] bool set_kicks(const Step& step, double h, double t, const Stored& stored,
                               std::vector<double>& parameters) const;
  [[nodiscard]] double step_size() const;
  [[nodiscard]] double beyond(double h, double t, const Step& last) const;
  [[nodiscard]] bool begins_at_border(double h, double t, const Step& last) const;
  /// Takes sensitivities from the end of infinitely many impacts back to where the run goes on.
  [[nodiscard]] std::optional<Diagnostic> take_back(const Program& program, const std::vector<double>& parameters,
                                                    double t, const std::vector<double>& limit,
                                                    std::vector<double>& x) const;
  [[nodiscard]] std::optional<Diagnostic> differentiate(double h, double t, const Step& last,
                                                        const std::vector<double>& sizes, std::vector<double>& x) const;

  const SwitchedVariation& of_;
  const RunInputs& inputs_;
  std::optional<Left> left_;  ///< none: the run begins
  std::vector<Step> steps_;
  double instant_ = 0.0;                      ///< t' of the present instant
  std::map<std::size_t, Arrivals> arrivals_;  ///< by diode
  std::optional<double> end_;                 ///< of infinitely many impacts, at the present instant
  std::vector<std::size_t> closed_;           ///< contacts that closed for good at it
};

}  // namespace bgsim
