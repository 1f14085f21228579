/// The guards of conditions along an integrator's step, enclosed.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "run/integrate/integrator.hpp"
#include "run/integrate/step_polynomial.hpp"
#include "run/watch/first_crossing.hpp"
#include "run/watch/screen.hpp"
#include "run/watch/solved_along.hpp"

namespace bgsim {

/// Guards as functions of time within the last step: enclosed by the polynomials of the states, evaluated by the
/// evaluator. Loops' variables that are no unknowns of the integrator have no polynomial, and neither have modes that
/// are held between their sides: they are enclosed by the equations that they solve (SolvedAlong). Where these say
/// nothing (a law without a slope), they are taken to follow, on each eighth of the step, the parabola through their
/// values at its ends and in its middle, with a quarter of what it bends as room on both sides.
class GuardFunctions final : public CrossingFunctions {
 public:
  /// What the owner knows of guards. Guards are numbered as by Evaluator::guards.
  struct Owner {
    std::function<bool(double t)> evaluate;  ///< all guards at a time within the step
    std::function<bool(std::size_t guard)> crossed;
    /// On a stretch with @p at in its middle; NaN: of a region of which no time is known.
    std::function<bool(std::size_t guard, const Range& values, double at)> stays;
    std::function<const Branch&()> branch;  ///< of the latest evaluation
  };
  GuardFunctions(const Program& program, std::span<const double> parameters, Owner owner);

  /// Whether none of @p guards can have crossed between the ends of a step on @p branch, without looking at its inside.
  /// None may be held.
  bool screened(const StepEnds& step, const Branch& branch, const std::vector<std::size_t>& guards);
  /// When a guard's side or what is held of it has changed.
  void clear() { screen_.clear(); }
  /// A guard whose mode is held between its sides: its function is what the mode has left of them.
  struct Held {
    std::size_t guard = 0;
    bool rests = false;  ///< its mode is no matter: it has all left
    friend bool operator==(const Held&, const Held&) = default;
  };
  /// For the integrator's last step.
  void begin(Integrator& integrator, std::vector<Held> held);

  /// By guard: whether it is a function of time and states alone, whatever values the modes of @p relations take within
  /// a step. Cost: linear in the guards' expressions, where the relations are other ones than in the call before.
  const std::vector<bool>& free_of(const std::vector<std::size_t>& relations);

  bool enclose(double from, double to) override;
  [[nodiscard]] Jet jet(std::size_t guard) const override;
  [[nodiscard]] bool stays(std::size_t guard, const Jet& jet) const override {
    return owner_.stays(guard, jet.value, middle_);
  }
  bool evaluate(double t) override;
  [[nodiscard]] bool crossed(std::size_t guard) const override { return owner_.crossed(guard); }

 private:
  struct Guard {
    std::size_t root = 0;
    std::uint32_t relation = 0;
    int border = 0;  ///< -1: distance to the lower border of the present cell, 1: to the upper, 0: the guard itself
  };
  /// What has no polynomial, where it is known.
  struct Solved {
    double t = 0.0;
    std::vector<double> tears, modes;  ///< all tears; by held_
  };
  const Solved* solved_at(double t);
  bool enclose_solved(double from, double to, const std::array<const Solved*, 3>& at);
  [[nodiscard]] bool is_enclosed_by_polynomials() const;
  [[nodiscard]] Jet left(std::size_t held) const;
  void hold(std::vector<Held> held);
  void take_modes(const Branch& branch);

  const Program& program_;
  Owner owner_;
  std::vector<Guard> guards_;
  Enclosure enclosure_;
  Screen screen_;
  StepPolynomial polynomial_;
  SolvedAlong equations_;
  bool known_ = false;                     ///< equations_ hold for all that is solved for
  std::vector<std::uint32_t> unknowns_;    ///< of the polynomial: the states, then the tears if these are unknowns
  std::vector<std::size_t> of_equations_;  ///< positions in unknowns_ of the states that the equations depend on
  double least_ = 0.0;                     ///< of a stretch that is taken for a parabola's only if it is shorter
  bool given_ = false;
  bool unsolved_ = false;  ///< a guard depends on a loop that no rate needs: steps come without its solution
  double middle_ = 0.0;    ///< of the stretch last enclosed
  std::vector<double> modes_;
  std::vector<std::size_t> varying_;  ///< relations of the latest free_of()
  std::vector<bool> free_;            ///< its result
  std::vector<Jet> states_, tears_, of_equations_over_;
  std::vector<Held> held_;
  std::vector<Enclosure::MovingMode> moving_;  ///< by held_
  std::vector<Solved> solved_;                 ///< within this step
};

}  // namespace bgsim
