/// The oscillator of bench_two_states as one would write it by hand.
#pragma once

namespace bgsim::bench {

/// Processor time of this process.
double cpu_seconds();

struct PlainRun {
  unsigned long steps = 0;
  double q = 0.0;
};

/// q' = p, p' = 1 - 0.2 p - q from rest to @p stop: CVODE BDF, dense, exact Jacobian, one step at a time.
PlainRun plain_oscillator(double stop, double relative, double absolute);

}  // namespace bgsim::bench
