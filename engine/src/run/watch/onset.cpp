#include "run/watch/onset.hpp"

#include <cmath>

namespace bgsim {

bool take_first_scales(const std::vector<double>& begin, const double* end, Tolerances& tolerances) {
  constexpr double kFirstScale = 1e-3;
  if (tolerances.watches_all()) return false;
  bool any = false;
  for (std::size_t i = 0; i < begin.size(); ++i) {
    if (begin[i] != 0.0 || end[i] == 0.0 || tolerances.watched(i)) continue;
    any = tolerances.begin_with(i, kFirstScale * std::fabs(end[i])) || any;
  }
  return any;
}

}  // namespace bgsim
