/// activity: which elements of a run turned over how much energy.
#pragma once

#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// Activity of an element: integral of |power| over the scene, a measure of what it contributes to the motion.
/// @cite louca2010 (activity index)
struct ElementActivity {
  ElementId element;
  double activity = 0.0;    ///< in joules if the model is in SI units
  double share = 0.0;       ///< of the sum over all elements
  double cumulative = 0.0;  ///< share of this element and all more active ones
};

/// Activities of all R, C, I and fields, the largest first; ties in model order. Sources are what the scene does to the
/// model and have none. The activity of a field is that of its whole power: what one port hands on to another does not
/// count.
/// @param result  of a run of @p program with its energy audit; empty if that was not done.
std::vector<ElementActivity> activities(const Program& program, const RunResult& result);

}  // namespace bgsim
