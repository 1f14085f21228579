/// A model at a point, ready for partial derivatives in symbols.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bgsim/linear.hpp"
#include "linear/perturbed.hpp"
#include "linear/symbolic.hpp"

namespace bgsim {

struct SymbolicSystem {
  std::shared_ptr<const Model> model;  ///< with the deviation of the input, and one output
  std::string input, output;
  EquationSystem system;
  BlockOrder order;
  ExprPool pool;                                ///< a superset of both
  std::unordered_map<SymbolId, int> deviation;  ///< the input's own, its derivative, ...: 0, 1, ...
  std::optional<SymbolicRing> ring;
  std::vector<std::uint32_t> states;  ///< of the system, without deviations
  [[nodiscard]] SymbolName names() const {
    return [this](SymbolId symbol) { return system.symbols[symbol.index()].name; };
  }
  /// What is no parameter, with its value.
  [[nodiscard]] std::vector<std::pair<std::string, double>> values_in(const std::vector<PowerSum>& sums) const;
  std::vector<double> numbers;  ///< by SymbolId at the point; NaN: not computed
};

/// What each variable follows from, to first order, law by law. Nodes are symbols, and one beyond: the output.
struct SignalFlow {
  using Node = std::uint32_t;
  struct Edge {
    Node from, to;
    PowerSum gain;  ///< with 1/s into a state
  };
  std::vector<Edge> edges;
  std::vector<std::vector<std::uint32_t>> out, in;  ///< edges by node
  std::vector<std::string> element_of;              ///< by node: whose law gives it; empty for junctions
  Node input = 0, output = 0;
};

/// Slopes that depend on the point are atoms "slope(orifice.f, orifice.e)", but for products of symbols.
SignalFlow signal_flow(SymbolicSystem& symbolic);

/// @throws ModelError as linear_system()
std::unique_ptr<SymbolicSystem> symbolic_system(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                                const std::string& input);

}  // namespace bgsim
