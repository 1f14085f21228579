/// The part of a model that its outputs depend on, as a model of its own: for models with switches, events or delays,
/// whose equations differ from mode to mode, so that what one mode leaves out another may need.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// Whether a model's equations are the same throughout a run: no switches, no events, no delays.
[[nodiscard]] bool equations_stay(const Model& model);

/// A part of a model that the rest has no influence on, whatever its modes, events and delays.
struct ObservedPart {
  std::shared_ptr<const Model> model;
  std::vector<ElementId> elements;                 ///< by ElementId of the whole; invalid: left out
  std::vector<SignalId> signals;                   ///< by SignalId of the whole; invalid: left out
  std::vector<std::optional<std::size_t>> events;  ///< by position in the whole's Model::events
  LeftOut left_out;
};

/// Follows what @p outputs (positions in Model::outputs) name: an element needs all that bonds connect it with, and all
/// that its laws and conditions name; a signal what its expressions name, and the events that set it;
/// an event what its condition and values name, and all that it sets. What is not reached shares no bond and no
/// variable with the rest, so in no mode do the outputs depend on it.
///
/// Bonds alone decide, not strokes: a branch behind an ideal source is kept with the others.
/// @return  none if nothing can be left out.
/// @note Time linear in the model.
std::optional<ObservedPart> observed_part(const Model& model, const std::vector<std::size_t>& outputs);

/// The inputs of a run of the whole as those of a run of the part: without the initial values of what is left out.
RunInputs inputs_of_part(RunInputs inputs, const ObservedPart& part);

}  // namespace bgsim
