// Uses the engine as a stranger would: one include, one target, from a model's text to its trace.
#include <bgsim/bgsim.hpp>
#include <cmath>
#include <iostream>

int main() {
  const char* text = R"({
    "bgsim": 1, "name": "decay",
    "elements": {
      "store": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
      "drain": { "kind": "R", "resistance": 1 },
      "joint": { "kind": "0" }
    },
    "bonds": [ { "from": "joint", "to": "store" }, { "from": "joint", "to": "drain" } ],
    "outputs": { "q": "store.q" },
    "scenes": { "run": { "stop": 1, "samples": 2 } }
  })";
  const auto model = std::make_shared<const bgsim::Model>(bgsim::read_model_text("decay.json", text));
  const auto graph = bgsim::build_bond_graph(*model);
  const auto causal = bgsim::assign_causality(*model, graph);
  const auto system = bgsim::derive_equations(*model, graph, causal);
  const auto order = bgsim::order_equations(*model, system);
  const auto inputs = bgsim::prepare_scene(*model, "run");
  const auto program = bgsim::compile(model, system, order, {inputs.outputs, true});
  const auto result = bgsim::simulate(*model, system, program, inputs);
  bgsim::write_trace_csv(std::cout, result.trace);
  // exp(-1) within ten times the default relative tolerance
  return std::abs(result.trace.values.back() - std::exp(-1.0)) < 1e-5 ? 0 : 1;
}
