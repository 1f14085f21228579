/// A run whose end is out of sight, and what limits its steps, in words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/watch/headway.hpp"
#include "run/watch/time_constants.hpp"

namespace bgsim {

/// What a run was busy with during the stretch that a pace was taken from.
struct PaceFacts {
  double t = 0.0, stop = 0.0, seconds = 0.0;  ///< seconds since the start
  Headway::Pace pace;
  double fixed_step = 0.0;              ///< of a method with steps of one length
  double events = 0.0, jumps = 0.0;     ///< by step: changes of conditions, known times
  double rows = 0.0;                    ///< by step
  std::optional<std::size_t> relation;  ///< that changed last
  double source_frequency = 0.0;        ///< of the source that limits the steps; 0: none does
  std::string unknown;                  ///< state or variable of a loop with the largest estimated error
  std::optional<Place> place;           ///< of its element
  std::optional<FastestMotion> fastest;
  bool iteration_fails = false;  ///< the integrator's, in more than every fourth step
};

Diagnostic slow_run_remark(const Program& program, const PaceFacts& facts);                          // BG616
Diagnostic endless_run_failure(const Program& program, const PaceFacts& facts, double longest_run);  // BG617
Diagnostic time_limit_failure(double t, double stop, double seconds);                                // BG618

}  // namespace bgsim
