/// The derivatives of a scene's states, loops and outputs by one parameter, as states, loops and outputs of one system.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bgsim/ordering.hpp"
#include "bgsim/program.hpp"
#include "scene/given_values.hpp"

namespace bgsim {

/// What is varied: a parameter, or an initial value of a store or integral.
struct Seed {
  std::string name;
  ParameterId parameter;   ///< none: an initial value
  StateKey state;          ///< of an initial value
  bool conjugate = false;  ///< the initial effort of a C or flow of an I
};

/// @throws ModelError BG413.
Seed find_seed(const Model& model, const std::string& name);

/// The derivative of each parameter by the seed, over parameters, in given.pool; none: 0. Parameters that are computed
/// from one that is varied follow it; those that a scene or --set gives are what is written there.
std::vector<ExprId> parameter_variations(const Model& model, GivenValues& given, const Seed& seed);

/// Signals of a model for the states that with_variations() adds. Which stores are independent differs from mode to
/// mode of a model with switches; with these a state means the same in all of them.
struct VariationSignals {
  std::vector<SignalId> integrals;           ///< of the outputs, or of their squares
  std::map<StateKey, SignalId> derivatives;  ///< of all stores, integrals, and `integrals`
};

/// What is derived beside the sensitivities of the outputs.
struct VariedParts {
  bool squares = false;                       ///< the integrals of the outputs' squares
  bool slopes = false;                        ///< the outputs' derivatives by time
  bool integrals = false;                     ///< the integrals of the outputs; not with squares
  const VariationSignals* signals = nullptr;  ///< those of the model; none: others are added for each state
};

/// The model with such signals: values of 0, until with_variations() makes some of them states.
Model with_variation_signals(Model model, std::size_t outputs, const VariedParts& parts, VariationSignals& signals);

/// A system with the derivatives by a seed. Its states are those of the model, then integrals, then the
/// derivatives of all of them in the same order.
struct VariedSystem {
  std::shared_ptr<const Model> model;  ///< with an integral for each added state, and the added outputs
  EquationSystem system;
  BlockOrder order;
  Variations variations;
  std::size_t own_states = 0;  ///< those of the model: the first ones
  /// Positions among the outputs: those asked for, then their derivatives by the seed, then by time (VariedParts), then
  /// the integrals and the derivatives of these.
  std::vector<std::size_t> outputs;
};

/// @param outputs  positions in Model::outputs
VariedSystem with_variations(const Model& model, const EquationSystem& system, const BlockOrder& order,
                             GivenValues& given, const Seed& seed, const std::vector<std::size_t>& outputs,
                             const VariedParts& parts);

/// @throws ModelError BG414 an expression of parameters alone, among the first @p rates, the loops, the @p outputs or
///         the events, or in what parameters and initial values are computed from, has a kink or a jump at this value
///         of the seed.
void refuse_kinks(const Model& model, const EquationSystem& system, const BlockOrder& order, std::size_t rates,
                  const std::vector<std::size_t>& outputs, GivenValues& given, const Seed& seed,
                  const RunInputs& inputs);

/// In inputs of a scene: outputs of a varied program, and no absolute tolerance that would be one of the derivatives.
/// @param own_states  names of the states that are the model's
RunInputs with_varied_outputs(RunInputs inputs, const std::vector<std::size_t>& outputs,
                              const std::vector<std::string>& own_states);

/// By how much parameters and initial values change with a seed, at the start of a scene.
struct SeedSlopes {
  std::vector<double> parameters;     ///< by ParameterId
  std::map<StateKey, double> states;  ///< of stores and integrals with a given value
};
/// @throws ModelError BG414 a law that gives an initial value has no slope there.
SeedSlopes seed_slopes(const Model& model, GivenValues& given, const Seed& seed, const RunInputs& inputs);

/// The start of a run of @p varied: what the model's states begin with changes with the seed by that.
/// @param inputs  of the model itself, at the point
/// @throws ModelError BG414 a law that gives an initial value has no slope there; an expression of parameters alone has
/// a
///         kink or a jump there.
RunInputs varied_inputs(const Model& model, const VariedSystem& varied, GivenValues& given, const Seed& seed,
                        const RunInputs& inputs);

/// The value of what is varied, at the start of a scene.
double value_of(const Model& model, GivenValues& given, const Seed& seed, const RunInputs& inputs);

}  // namespace bgsim
