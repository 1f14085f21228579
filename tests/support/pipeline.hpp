/// Runs all stages for a model given as text.
#pragma once

#include <memory>
#include <string>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

/// Every stage's value, kept so that a test can look at any of them.
struct Pipeline {
  explicit Pipeline(const std::string& text, const std::string& scene = {}, const SceneOverrides& overrides = {},
                    bool energies = true)
      : Pipeline(std::make_shared<const Model>(read_model_text("test.json", text)), scene, overrides, energies) {}
  explicit Pipeline(std::shared_ptr<const Model> m, const std::string& scene = {}, const SceneOverrides& overrides = {},
                    bool energies = true)
      : model(std::move(m)),
        study(model),
        graph(study.graph()),
        causal(study.causality()),
        system(study.equations()),
        order(study.order()),
        inputs(prepare_scene(*model, scene, overrides)),
        program(study.scene(inputs, {.energy_audit = energies, .keep_all = true}).program()) {}

  [[nodiscard]] RunResult run(const SimulateOptions& options = {}) const { return simulate(program, inputs, options); }

  std::shared_ptr<const Model> model;
  Study study;
  BondGraph graph;
  CausalGraph causal;
  EquationSystem system;
  BlockOrder order;
  RunInputs inputs;
  Program program;
};

/// A model with the usual wrapping: @p body is the content between "bgsim" and the closing brace.
inline std::string model_text(const std::string& body) { return R"({ "bgsim": 1, "name": "test", )" + body + " }"; }

}  // namespace bgsim::test
