/// What is said where the integrator cannot go on.
#pragma once

#include "run/failures.hpp"
#include "run/integrate/integrator.hpp"
#include "run/sink/magnitudes.hpp"
#include "run/watch/events.hpp"

namespace bgsim {

/// The last accepted point of a run.
struct LastPoint {
  double t = 0.0, start = 0.0;  ///< there; of the scene
  const std::vector<double>& x;
  const Branch& branch;
};

/// The cause is a denominator at zero or the law without a value just ahead, if there is one; else what the states
/// show: BG601, BG605, BG608, BG613.
/// @param words  the integrator's.
Diagnostic stuck_at(const LastPoint& point, const std::string& words, const Program& program, Evaluator& evaluator,
                    Integrator& integrator, EventWatch& events, const Magnitudes& magnitudes);

}  // namespace bgsim
