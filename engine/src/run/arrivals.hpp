/// How what a contact comes to its wall with depends on a parameter, impact after impact, and in the limit of
/// infinitely many.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/program.hpp"
#include "run/contacts.hpp"

namespace bgsim {

/// One time that a contact came to its gap, just before the impact.
struct Arrival {
  const Program* program = nullptr;
  double t = 0.0;
  std::vector<double> x;      ///< by state
  std::vector<double> moved;  ///< by state: dx/dp at the instant as it moves with p, s + f t'
  std::vector<double> terms;  ///< by state: |s| + |f t'|
  double instant = 0.0;       ///< t'
};

/// Of one contact: the latest, and what their derivatives are measured by: the largest terms so far, and a
/// millionth of the largest values over that of the parameter, below which a derivative is taken for rounding.
struct Arrivals {
  std::vector<Arrival> latest;
  std::vector<double> sizes;  ///< of `moved`, by state
  double size_of_instant = 0.0;

  /// @param value  magnitude of the parameter; 0: it has none
  void add(Arrival arrival, double value);
};

/// Where the impacts of @p series end. With r the ratio of the intervals, what depends on p along the impacts k goes as
/// y_k = y + (a + b k) r^k + O(r^2k): its limit and amplitude move with p, and so does r. The shift E of k gives
/// (E - r)^2 y_k = (1 - r)^2 y, from three arrivals; states themselves have b = 0, from two. What is left of r^2k falls
/// from arrival to arrival, and what rounding makes of an instant at a speed of r^k grows: of all limits the one is
/// taken that differs least from the one before it.
/// @return  none where no two agree to a millionth, or less than four arrivals in one mode are known.
std::optional<Arrival> limit_of(const Arrivals& arrivals, const Accumulation& series);

}  // namespace bgsim
