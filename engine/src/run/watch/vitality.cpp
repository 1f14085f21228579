#include "run/watch/vitality.hpp"

#include <cmath>
#include <limits>

namespace bgsim {

bool Vitality::look(double step, double time) {
  constexpr double kRoundings = 100.0;
  constexpr std::uint64_t kPatience = 1000, kPatienceWithNone = 30;
  const bool tiny = step < kRoundings * std::numeric_limits<double>::epsilon() * std::abs(time);
  tiny_ = tiny ? tiny_ + 1 : 0;
  empty_ = step > 0.0 ? 0 : empty_ + 1;
  return tiny_ < kPatience && empty_ < kPatienceWithNone;
}

}  // namespace bgsim
