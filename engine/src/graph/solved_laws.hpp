/// The law of each port, solved for what the port may give.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

class SolvedLaws {
 public:
  SolvedLaws(const Model& model, const BondGraph& graph);

  [[nodiscard]] LawUse use(PortId port, Gives gives) const {
    return solved_[port.index()][static_cast<std::size_t>(gives)].use;
  }
  [[nodiscard]] bool usable(PortId port, Gives gives) const { return use(port, gives) != LawUse::impossible; }

  /// Hands over the laws as @p strokes use them, the fields with their reciprocity (BG306 if it is violated), and the
  /// pool that holds both.
  void hand_over(std::span<const Stroke> strokes, CausalGraph& causal) &&;

 private:
  SolvedLaw solve(ElementId id, std::size_t number, const std::vector<Law>& laws, Gives gives);
  PortLaw used(std::span<const Stroke> strokes, PortId port);
  void test_field(ElementId id, CausalGraph& causal);

  const Model& model_;
  const BondGraph& graph_;
  ExprPool pool_;                                 ///< the model's, and the laws
  std::vector<Law> laws_;                         ///< by PortId
  std::vector<std::array<SolvedLaw, 2>> solved_;  ///< by PortId, by Gives
};

}  // namespace bgsim
