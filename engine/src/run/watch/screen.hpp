/// A region of the unknowns within which nothing that is watched happens: as long as steps stay in it, nothing else has
/// to be looked at.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "program/enclosure.hpp"

namespace bgsim {

/// The ends of a step.
struct StepEnds {
  double begin = 0.0, end = 0.0;
  const double* states_at_begin = nullptr;
  const double* states_at_end = nullptr;
  const double* tears_at_begin = nullptr;  ///< loops' variables, solved or unknowns of the integrator
  const double* tears_at_end = nullptr;
};

/// A box around the latest steps, several times as wide as they are, in which the enclosure of what is watched proves
/// that nothing happens. Within a step an unknown is taken to leave the stretch between its ends by no more than it
/// moves in this step and the one before it.
class Screen {
 public:
  /// Whether a step is within the box; else a new one is tried.
  /// @param nothing_happens  by what the enclosure has just been evaluated to.
  bool passes(Enclosure& enclosure, const StepEnds& step, const std::function<bool()>& nothing_happens);
  /// When what is watched has changed (modes, sides).
  void clear() { *this = Screen(); }

 private:
  static constexpr double kWidest = 64.0, kLeast = 1.0;
  static constexpr int kPause = 4;  ///< steps after one around which there is no box

  bool covers(const Enclosure& enclosure, const StepEnds& step);
  void put(Enclosure& enclosure, const StepEnds& step, double factor);

  bool valid_ = false;
  std::vector<Range> box_;              ///< states, then tears, as the enclosure lists them
  std::vector<double> moved_, before_;  ///< in this step and the one before it
  Range time_ = Range(0.0, 0.0);
  double factor_ = 8.0;
  int pause_ = 0;
};

}  // namespace bgsim
