#include "run/clock.hpp"

#include <algorithm>
#include <chrono>

namespace bgsim {

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RunClock::RunClock(const SimulateOptions& options, Clock clock, double start)
    : options_(options), clock_(std::move(clock)), begin_(clock_()), now_(begin_), t_(start) {}

void RunClock::ask() {
  if (end_ != End::none) return;
  if (options_.time_limit > 0.0 && seconds() >= options_.time_limit)
    end_ = End::time_over;
  else if (options_.progress && !options_.progress(t_))
    end_ = End::interrupted;
  ended_at_ = now_;
}

std::uint64_t RunClock::look() {
  constexpr double kSeldom = 0.01, kOften = 0.05;  // seconds
  constexpr std::uint64_t kMost = 1U << 16U;
  constexpr double kPatience = 0.3;  // seconds for a step to come to its end
  const double now = clock_();
  const double passed = now - now_;
  now_ = now;
  looked_ = true;
  if (passed < kSeldom) between_looks_ = std::min(2 * between_looks_, kMost);
  if (passed > kOften) between_looks_ = std::max<std::uint64_t>(between_looks_ / 4, 1);
  ask();
  return end_ != End::none && now_ - ended_at_ > kPatience ? 0 : between_looks_;
}

void RunClock::reach(double t) {
  constexpr unsigned kBetween = 64;  // steps and rows, in which a look by the clock may not have come
  t_ = t;
  if (++reached_ % kBetween == 0) ask();
}

}  // namespace bgsim
