/// Which elements, bonds and junctions are left of a graph after cuts.
#pragma once

#include <vector>

#include "study/flat_model.hpp"

namespace bgsim {

class CutGraph {
 public:
  /// @throws std::invalid_argument if a cut element is no one-port R, C or I.
  CutGraph(const BondGraph& graph, const std::vector<Cut>& cuts, const std::vector<ElementId>& dropped);

  [[nodiscard]] bool is_cut(ElementId element) const { return cut_[element.index()]; }
  /// Dropped, or cut without a source in its place.
  [[nodiscard]] bool gone(ElementId element) const { return gone_element_[element.index()]; }
  [[nodiscard]] bool gone(BondId bond) const { return gone_bond_[bond.index()]; }
  /// Some expression uses a variable of @p element.
  void use(ElementId element) { used_[element.index()] = true; }

  /// Drops junctions that cuts have left with nothing to join: without a bond, or with a single one, to a junction of
  /// the same kind, which then has neither effort (1) nor flow (0) through it. Those whose variable is used stay.
  std::vector<ElementId> drop_dangling(const BondGraph& graph);

 private:
  std::vector<bool> cut_, gone_element_, gone_bond_, used_;
};

}  // namespace bgsim
