#include "run/watch/vitality.hpp"

#include <cmath>
#include <limits>

namespace bgsim {

namespace {
constexpr double kRoundings = 100.0;
}

bool Vitality::look(double step, double time) {
  constexpr std::uint64_t kPatience = 1000, kPatienceWithNone = 30;
  const bool tiny = step < kRoundings * std::numeric_limits<double>::epsilon() * std::abs(time);
  tiny_ = tiny ? tiny_ + 1 : 0;
  empty_ = step > 0.0 ? 0 : empty_ + 1;
  return tiny_ < kPatience && empty_ < kPatienceWithNone;
}

bool Vitality::blocked(double step, double from, double fault) {
  constexpr double kShortly = 100.0;
  constexpr std::uint64_t kPatience = 30;
  blocked_ = fault > from && fault - from < kShortly * step ? blocked_ + 1 : 0;
  if (blocked_ < kPatience) return false;
  blocked_ = 0;
  return true;
}

}  // namespace bgsim
