/// A model to which deviations of inputs are added, as signals whose derivatives the equations know.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// @throws ModelError BG629 where the model has delayed signals: what they were is no state.
void refuse_delays(const Model& model);

/// An input of a linear system in the model that it was added to.
struct PerturbedInput {
  std::string name;
  std::size_t output = 0;       ///< position in Model::outputs: the quantity itself
  std::vector<SignalId> chain;  ///< the deviation and its derivatives, each the integral of the next one
};

struct PerturbedModel {
  std::shared_ptr<const Model> model;
  std::vector<PerturbedInput> inputs;
  std::shared_ptr<const Model> plain;  ///< with the outputs, without the deviations: for units
};

/// As many derivatives of an input as derive_equations() forms in a row, and one more.
constexpr std::size_t kInputDerivatives = 9;

/// Adds w, w', ... to each input: integrals that rest at 0. A store in derivative causality behind an input then
/// has its derivative in its equations, where one that is a mere parameter would be lost.
/// @throws ModelError BG406.
PerturbedModel perturbed_model(const Model& model, const RunInputs& point, const std::vector<std::string>& inputs);

}  // namespace bgsim
