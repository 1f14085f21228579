/// Slopes for Newton's iteration beside the border where a law begins with a slope without bound, as a root does.
///
/// A run that begins there, or goes on from an event there, is a rounding of the state beside the border. The slope at
/// that point is 1e7, and holds for a ten-thousandth of the tolerance: every correction that Newton's iteration makes
/// with it is far below the tolerance, wherever the solution is, so the iteration ends at once and the state stays.
/// With the slope a part of the tolerance away, a correction below the tolerance says that the solution is within it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/unequal.hpp"

namespace bgsim {

class BorderSlopes {
 public:
  /// @param unknowns  of the system; @param entries  of its Jacobian's pattern
  BorderSlopes(std::size_t unknowns, std::size_t entries)
      : unknowns_(unknowns), moved_(unknowns), near_(entries), far_(entries), other_(entries) {}

  /// A new stretch, which may begin beside a border.
  void begin() {
    beside_ = true;
    looked_ = replaced_ = false;
  }
  /// After a step that was accepted: the state has left the border where none of the step's points was beside it.
  void stepped() {
    if (looked_ && !replaced_) beside_ = false;
    looked_ = replaced_ = false;
  }

  /// Replaces the entries that are far steeper at @p y than a part of the tolerance away. Two evaluations of the
  /// Jacobian, four where there are such; none once the state has left the border.
  /// @param tolerance  tolerance(j) of unknown j at y
  /// @param evaluate   evaluate(y, entries): false where there are none
  /// @param entries    at y, by the pattern; anything if they are not known there
  /// @return  whether any was replaced
  template <class Tolerance, class Evaluate>
  bool replace(const double* y, Tolerance tolerance, Evaluate evaluate, double* entries, bool known = true) {
    if (!beside_) return false;
    looked_ = true;
    if (!steepest_beside(y, 1.0 / kNearer, tolerance, evaluate, known ? entries : nullptr, near_)) return false;
    if (!known) {
      std::copy(near_.begin(), near_.end(), entries);
      return replaced_ = true;
    }
    const auto steep = [&](std::size_t k) { return std::abs(entries[k]) > kSteep * std::abs(near_[k]); };
    bool any = false;
    for (std::size_t k = 0; k < near_.size(); ++k) any = any || steep(k);
    if (!any || !steepest_beside(y, 1.0, tolerance, evaluate, entries, far_)) return false;
    any = false;
    for (std::size_t k = 0; k < near_.size(); ++k)
      if (steep(k) && std::abs(near_[k]) < kNearer * std::abs(far_[k])) {
        entries[k] = near_[k];
        any = true;
      }
    replaced_ = replaced_ || any;
    return any;
  }

  /// The slopes that replace() would take where there are none at @p y itself, wherever the run is.
  template <class Tolerance, class Evaluate>
  bool take_beside(const double* y, Tolerance tolerance, Evaluate evaluate, double* entries) {
    if (!steepest_beside(y, 1.0 / kNearer, tolerance, evaluate, nullptr, near_)) return false;
    std::copy(near_.begin(), near_.end(), entries);
    return true;
  }

 private:
  /// Newton's iteration with a slope up to twice too steep halves the error each time: it knows how far it is.
  static constexpr double kSteep = 2.0;
  /// At a distance of a 64th of the tolerance a root is eight times as steep as at that of the tolerance. The slope of
  /// any power between 0 and 1 grows by less than 64 there: most of the change of the law lies farther away. A law that
  /// is steep on a narrow stretch alone (friction smoothed to less than the tolerance) changes there and nowhere else,
  /// and its states rest on that stretch: it keeps its slope.
  static constexpr double kNearer = 64.0;

  /// By entry the steeper one of both sides, as far as the law has a value there: on the side that it does not hold for
  /// it may fall where it rises on its own, so a slope of the other sign than at the point counts as none.
  /// @param at_point  null: not known
  template <class Tolerance, class Evaluate>
  bool steepest_beside(const double* y, double part, Tolerance tolerance, Evaluate evaluate, const double* at_point,
                       std::vector<double>& entries) {
    bool any = false;
    for (const double side : {1.0, -1.0}) {
      // Unequal moves, so that differences of states move, too.
      for (std::size_t j = 0; j < unknowns_; ++j)
        moved_[j] = y[j] + side * part * tolerance(j) * (0.5 + 0.5 * unequal_part(j + 1));
      if (!evaluate(moved_.data(), other_.data())) continue;
      for (std::size_t k = 0; at_point != nullptr && k < entries.size(); ++k)
        if (at_point[k] * other_[k] < 0.0) other_[k] = 0.0;
      for (std::size_t k = 0; k < entries.size(); ++k)
        entries[k] = any && std::abs(entries[k]) >= std::abs(other_[k]) ? entries[k] : other_[k];
      any = true;
    }
    return any;
  }

  std::size_t unknowns_;
  std::vector<double> moved_, near_, far_, other_;
  bool beside_ = false, looked_ = false, replaced_ = false;
};

}  // namespace bgsim
