/// How long the rest of a run takes, by the pace that it keeps.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace bgsim {

/// Marks of how far a run had come at what time. Times are handed in, so that what follows from them can be tested.
///
/// A pace counts only if it is steady: a stretch of time is cut into four, and the mean progress with each piece of
/// work (a step, a row) in the last quarter must not be above that in the best of the others. A run that starts slowly
/// and picks up is never judged by its start.
class Headway {
 public:
  explicit Headway(double stop) : stop_(stop) {}

  /// The run has come to @p t with @p work steps and rows, @p seconds after its start.
  void add(double seconds, double t, std::uint64_t work);

  struct Pace {
    double rest = 0.0;      ///< seconds to the stop, at the best of the four quarters' paces
    double progress = 0.0;  ///< of t, with each piece of work
    double stretch = 0.0;   ///< of t, that was judged
    double seconds = 0.0;   ///< that it took
  };
  /// The pace over the last @p seconds, or over as many as hold enough work. None if it is not steady, or the run too
  /// young.
  [[nodiscard]] std::optional<Pace> pace(double seconds) const;

 private:
  struct Mark {
    double seconds, t;
    std::uint64_t work;
  };
  [[nodiscard]] const Mark& mark_before(double seconds) const;

  double stop_;
  std::deque<Mark> marks_;  ///< some hundred at most
};

}  // namespace bgsim
