/// reduce: no more model than a scene requires, with the error that this makes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/study.hpp"
#include "bgsim/verify.hpp"

namespace bgsim {

/// What takes the place of an element that is cut out: no effort (a rigid link for a common flow, a short for a common
/// effort) or no flow (nothing for a common effort, a lock for a common flow).
enum class CutKind : std::uint8_t { zero_effort, zero_flow };
std::string cut_text(CutKind kind);  ///< "zero effort", "zero flow"

/// A one-port R, C, I or D that is cut out.
struct Cut {
  ElementId element;
  CutKind kind = CutKind::zero_effort;
};

/// How large what is run is.
struct ModelSize {
  std::size_t elements = 0;  ///< junctions among them
  std::size_t bonds = 0;
  std::size_t states = 0;      ///< integrated: after slicing
  std::size_t operations = 0;  ///< instructions for one evaluation of the rates, loops' residuals among them
};

/// What one run costs: without audit, what no output depends on left out.
struct ModelCost {
  std::uint64_t steps = 0, rate_evaluations = 0;
  double seconds = 0.0;  ///< least wall time of the integration over the repetitions
};

/// One cut that was tried.
struct CutTrial {
  Cut cut;
  double share = 0.0;   ///< of the element in the activity of the model it was cut from
  bool made = false;    ///< within the error asked for, hence kept
  std::string refusal;  ///< why it could not be tried to the end; empty if it could
  OutputError error;    ///< of the model with all cuts so far and this one, against the full model
};

struct Reduction {
  std::vector<ElementActivity> activity;  ///< of the full model
  std::vector<CutTrial> trials;           ///< in order
  std::vector<ElementId> unobserved;      ///< left away at first, since no output depends on them; junctions among them
  std::vector<Cut> cuts;                  ///< those that were made
  std::vector<OutputError> errors;        ///< of the reduced model
  std::string text;                       ///< the reduced model: one file of format 1
  Trace reference;                        ///< the full model's
  ModelSize size_before, size_after;
  ModelCost cost_before, cost_after;
};

struct ReduceOptions {
  std::string scene;              ///< empty: the model's first
  double error = 1e-2;            ///< allowed in the scene's outputs, relative to their ranges
  std::vector<std::string> keep;  ///< elements that are not to be cut
  std::string parent;             ///< how the new file is to name the model's
  std::string file;               ///< where the new file is to stand
  std::string reference;          ///< how the new file is to name the full model's trace; empty: not at all
  std::size_t repetitions = 3;    ///< runs by which the costs are measured
  Progress progress;              ///< of each run; false ends the whole
};

/// Leaves away what no output depends on and nothing names, then cuts out elements, the least active first, as long as
/// no output of the scene strays further from the full model's than allowed. For each element the cut that its
/// junctions speak for (its effort is small among those of a common flow: no effort; its flow among those of a common
/// effort: no flow) is tried first, then the other one. A cut that leads to a causal conflict, a singular loop or a run
/// that fails is refused. What could not go is tried again as long as anything else went.
///
/// Of models with switches, events or delays only what no bond and no signal connects with the outputs is left away
/// before the cuts: another mode may connect the rest. A store that an event sets is not cut.
///
/// @throws ModelError  BG710 the scene records nothing; BG711 the
///         error allowed is no larger than what the solver makes at the scene's tolerance; BG712 no such element is
///         there to be kept; what the stages throw for the full model; BG6xx its run fails or is interrupted.
/// @note Two runs for each R, C and I and each round: at most the number of cuts made and one.
/// @cite louca2010 (activity)
Reduction reduce(const Study& study, const ReduceOptions& options);

}  // namespace bgsim
