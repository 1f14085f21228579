/// Which operators may bend within a step, by what their arguments are at its ends.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "program/enclosure.hpp"
#include "run/watch/screen.hpp"

namespace bgsim {

/// An operator bends where it is far from linear over the stretch that its arguments move on. Within a step an argument
/// is taken to leave the stretch between its values at the ends by no more than it moves in this step and the one
/// before it: its own operators do not bend, or are named themselves. Around each argument lies a box, up to 64 times
/// as wide as it moves, in which the operator does not bend; so a step costs the evaluation of the arguments and some
/// comparisons.
class OperatorScreen {
 public:
  /// @param operators  the roots of it are watched; what it was last evaluated to is overwritten.
  explicit OperatorScreen(Enclosure& operators) : operators_(&operators), watched_(operators.size()) {}

  /// When modes have changed.
  void clear();
  /// Whether an operator may bend in a step.
  bool any_bends(const StepEnds& step);

 private:
  struct Argument {
    double begin = 0.0, end = 0.0, before = 0.0;  ///< before: moved in the step before this one
    Range box = Range(0.0, 0.0);
    [[nodiscard]] double moved() const { return std::max(begin, end) - std::min(begin, end); }
    [[nodiscard]] double room() const { return moved() + before; }
    [[nodiscard]] Range within(double factor) const;
    [[nodiscard]] bool covered() const;
  };
  struct Watched {
    Argument a, b;
    bool boxed = false;
    double factor = 8.0;
  };
  void evaluate(double t, const double* states, const double* tears);
  void take_ends(const StepEnds& step);
  bool bends(std::size_t root);

  Enclosure* operators_;
  std::vector<Watched> watched_;
  std::vector<double> states_, tears_;
  double begin_ = std::numeric_limits<double>::quiet_NaN(), end_ = begin_;  ///< of the last step seen
};

}  // namespace bgsim
