/// What is solved for along a step, enclosed: loops' variables, and modes that are held between their sides.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bgsim/program.hpp"
#include "program/enclosure.hpp"

namespace bgsim {

/// Encloses over a stretch of time what solves F(t, x(t), y) = 0: loops' residuals, and the rates of the guards that
/// are held. With m what y is in the middle, C the inverse of the slopes F_y there, and A = 1 - C F_y over the stretch,
///     y(t) is in m - C F(t, m) + |A| [-e, e]   where   |C F(t, m)| + |A| e <= e
/// for all t of it (Krawczyk's operator), and what the same makes of F_t holds y'. So nothing is missed between two
/// points.
class SolvedAlong {
 public:
  SolvedAlong(const Program& program, std::span<const double> parameters)
      : program_(program), parameters_(parameters) {}

  /// What is to be solved for. False where its equations are not known, or it is too much for a dense inverse.
  /// @param tears  with all that their loops depend on these are needed(), afterwards
  bool look_at(std::vector<std::uint32_t> tears, std::vector<std::uint32_t> relations);
  /// Positions of the states that the equations depend on, increasing.
  [[nodiscard]] const std::vector<std::uint32_t>& states() const { return states_; }
  /// The tears that are solved for, increasing.
  [[nodiscard]] const std::vector<std::uint32_t>& tears() const { return tears_; }

  /// @param states  as many as states()
  /// @param modes   of all relations; those that are solved for do not matter
  /// @param middle  what is solved for in the middle of the stretch: tears(), then the relations' modes
  /// @param about   ranges that it is likely to keep to
  /// @return  false where nothing is known: on a shorter stretch there may be
  bool enclose(double from, double to, std::span<const Jet> states, std::span<const double> modes,
               std::span<const double> middle, std::vector<Range> about);
  /// Of what is solved for.
  [[nodiscard]] const Jet& operator[](std::size_t k) const { return found_[k]; }

 private:
  struct Partial {
    std::size_t row, column, root;
  };
  bool take(const std::vector<std::uint32_t>& tears);
  void put(std::span<const double> middle, const std::vector<Range>& ranges);
  bool solve(const std::vector<Range>& values, const Eigen::MatrixXd& inverse, std::vector<Range>& out) const;

  const Program& program_;
  std::span<const double> parameters_;
  std::vector<std::uint32_t> asked_, tears_, relations_, states_;
  bool looked_ = false, known_ = false;
  std::optional<Enclosure> equations_;  ///< the values, then the partials
  std::vector<Partial> partials_;
  std::vector<Jet> tear_jets_, found_;
  std::vector<Enclosure::MovingMode> modes_;
  Eigen::MatrixXd least_, most_;  ///< of the slopes over the stretch
};

}  // namespace bgsim
