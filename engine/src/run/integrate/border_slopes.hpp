/// Slopes for Newton's iteration beside the border where a law begins with a slope without bound, as a root does.
///
/// A run that begins there, or goes on from an event there, is a rounding of the state beside the border. The slope at
/// that point is 1e7, and holds for a ten-thousandth of the tolerance: every correction that Newton's iteration makes
/// with it is far below the tolerance, wherever the solution is, so the iteration ends at once and the state stays.
/// With the slope a part of the tolerance away, a correction below the tolerance says that the solution is within it.
///
/// Where loops' variables are unknowns as well, such a law is the inverse of one that begins flat: e - k f |f| = 0 has
/// the slope 2 k |f| by f, and with next to nothing of that no other unknown moves.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace bgsim {

class BorderSlopes {
 public:
  /// @param rows    of the Jacobian's entries, by its pattern
  /// @param states  unknowns whose equations are of rates; those of the others are of loops
  BorderSlopes(std::size_t unknowns, std::span<const std::int64_t> rows, std::size_t states)
      : unknowns_(unknowns), moved_(unknowns), near_(rows.size()), far_(rows.size()), other_(rows.size()) {
    for (const std::int64_t row : rows) of_loop_.push_back(static_cast<std::size_t>(row) >= states);
  }

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

  /// Replaces the entries that are far steeper at @p y than a part of the tolerance away, and those of loops that are
  /// far flatter. Two evaluations of the Jacobian, four where there are such; none once the state has left the border.
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
    const auto flat = [&](std::size_t k) { return of_loop_[k] && kSteep * std::abs(entries[k]) < std::abs(near_[k]); };
    bool any = false;
    for (std::size_t k = 0; k < near_.size(); ++k) any = any || steep(k) || flat(k);
    if (!any || !steepest_beside(y, 1.0, tolerance, evaluate, entries, far_)) return false;
    any = false;
    for (std::size_t k = 0; k < near_.size(); ++k)
      if ((steep(k) && std::abs(near_[k]) < kNearer * std::abs(far_[k])) ||
          (flat(k) && kGrows * std::abs(near_[k]) < std::abs(far_[k]))) {
        entries[k] = near_[k];
        any = true;
      }
    replaced_ = replaced_ || any;
    return any;
  }

 private:
  /// Newton's iteration with a slope up to twice too steep halves the error each time: it knows how far it is.
  static constexpr double kSteep = 2.0;
  /// At a distance of a 64th of the tolerance a root is eight times as steep as at that of the tolerance. The slope of
  /// any power between 0 and 1 grows by less than 64 there: most of the change of the law lies farther away. A law that
  /// is steep on a narrow stretch alone (friction smoothed to less than the tolerance) changes there and nowhere else,
  /// and its states rest on that stretch: it keeps its slope.
  static constexpr double kNearer = 64.0;
  /// A slope that begins at 0 as that of a power does is larger at the tolerance; that of a law which is flat on a
  /// narrow stretch alone is not.
  static constexpr double kGrows = 1.01;

  /// By entry the steeper one of both sides, as far as the law has a value there: on the side that it does not hold for
  /// it may fall where it rises on its own, so a slope of the other sign than at the point counts as none.
  /// @param at_point  null: not known
  template <class Tolerance, class Evaluate>
  bool steepest_beside(const double* y, double part, Tolerance tolerance, Evaluate evaluate, const double* at_point,
                       std::vector<double>& entries) {
    bool any = false;
    for (const double side : {1.0, -1.0}) {
      // Unequal moves, so that differences of states move, too.
      constexpr double kGolden = 0.6180339887498949;
      for (std::size_t j = 0; j < unknowns_; ++j) {
        const double fraction = kGolden * static_cast<double>(j + 1);
        moved_[j] = y[j] + side * part * tolerance(j) * (0.5 + 0.5 * (fraction - std::floor(fraction)));
      }
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
  std::vector<bool> of_loop_;  ///< by entry
  std::vector<double> moved_, near_, far_, other_;
  bool beside_ = false, looked_ = false, replaced_ = false;
};

}  // namespace bgsim
