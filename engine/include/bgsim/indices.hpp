/// Which quantities of a sweep make its results differ: indices of the variance (Sobol), elementary effects (Morris).
#pragma once

#include <cstdint>
#include <vector>

#include "bgsim/sweep.hpp"

namespace bgsim {

/// The part of one quantity in the variance of a result.
struct VarianceShare {
  double first = 0.0;  ///< what is expected to be gone of the variance if the quantity is known: S
  double total = 0.0;  ///< what is expected to be left if all others are known: T
  double first_within = 0.0, total_within = 0.0;  ///< half widths of the intervals of 95 %
  std::uint64_t points = 0;  ///< of the sample, of which all three runs that this takes have a value
};

struct VarianceShares {
  double mean = 0.0, deviation = 0.0;  ///< of the result
  std::uint64_t points = 0;            ///< of the sample, with both independent runs
  std::vector<VarianceShare> of;       ///< by variation; NaN where the result does not vary
};

/// Indices of a result over a sample of Sampling::saltelli: S by Saltelli et al. (Comput. Phys. Commun. 181, 2010), T
/// by Jansen (Comput. Phys. Commun. 117, 1999), with a quantity that has no effect at exactly 0. The intervals are
/// those of the delta method for random samples; Sobol's points come nearer.
/// @param results  by number of run; what is not finite is left out, and with it all that needs it
VarianceShares variance_shares(const SweepPoints& points, const std::vector<double>& results);

/// How a result changes when one quantity goes through its whole distribution, by steps of half of it.
struct ElementaryEffect {
  double mean = 0.0;       ///< mu
  double magnitude = 0.0;  ///< mu*, the mean of magnitudes
  double within = 0.0;     ///< half width of mu*'s interval of 95 % (Student's t)
  double deviation = 0.0;  ///< sigma: beside mu it says how far from linear, and from alone, the quantity acts
  std::uint64_t effects = 0;
};

/// Elementary effects over a sample of Sampling::morris (Morris, Technometrics 33, 1991; mu* by Campolongo, Cariboni,
/// Saltelli, Environ. Model. Softw. 22, 2007), by variation.
/// @param results  as above
std::vector<ElementaryEffect> elementary_effects(const SweepPoints& points, const std::vector<double>& results);

}  // namespace bgsim
