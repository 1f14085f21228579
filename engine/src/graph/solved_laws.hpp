/// The law of each port, solved for what the port may give.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bgsim/causality.hpp"
#include "model/constitutive.hpp"

namespace bgsim {

class SolvedLaws {
 public:
  /// @param number_of  the model's symbols, for laws with kinks; none: these are used as written only.
  SolvedLaws(const Model& model, const BondGraph& graph, NumberOf number_of = {});

  [[nodiscard]] LawUse use(PortId port, Gives gives) const {
    return solved_[port.index()][static_cast<std::size_t>(gives)].use;
  }
  [[nodiscard]] bool usable(PortId port, Gives gives) const { return use(port, gives) != LawUse::impossible; }

  /// Whether a law with kinks can be used in a direction in which it is not written.
  [[nodiscard]] bool any_by_pieces() const { return by_pieces_; }

  /// Hands over the laws as @p strokes use them, the fields with their reciprocity (BG306 if it is violated), and the
  /// pool that holds both.
  void hand_over(std::span<const Stroke> strokes, CausalGraph& causal) &&;

 private:
  SolvedLaw solved(const Element& element, const Law& law, Gives gives);
  SolvedLaw solve(ElementId id, std::size_t number, const std::vector<Law>& laws, Gives gives);
  PortLaw used(std::span<const Stroke> strokes, PortId port);
  void test_field(ElementId id, CausalGraph& causal);

  const Model& model_;
  const BondGraph& graph_;
  NumberOf number_;
  bool by_pieces_ = false;
  ExprPool pool_;                                 ///< the model's, and the laws
  std::vector<Law> laws_;                         ///< by PortId
  std::vector<std::array<SolvedLaw, 2>> solved_;  ///< by PortId, by Gives
};

}  // namespace bgsim
