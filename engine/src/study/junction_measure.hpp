/// How large an element's effort and flow are beside those at its junctions: which of the two can rather be nothing.
#pragma once

#include <memory>
#include <vector>

#include "bgsim/simulate.hpp"
#include "study/flat_model.hpp"

namespace bgsim {

/// The same model with the effort and the flow of each bond as further outputs, behind its own: e then f by BondId.
/// @note Time linear in the model.
std::shared_ptr<const Model> with_bonds_as_outputs(const Model& model);

class JunctionMeasure {
 public:
  /// @param trace    of a run that recorded the bonds.
  /// @param outputs  how many columns come before them.
  JunctionMeasure(const BondGraph& graph, const Trace& trace, std::size_t outputs);

  /// For an R, C or I at a 1-junction: its effort's root mean square beside the largest at that junction, against the
  /// common flow's beside the largest at the 0-junctions next to it; at a 0-junction the other way round. The smaller
  /// ratio says which variable is the more negligible. An element that hangs on no junction gives no effort first.
  [[nodiscard]] CutKind first_choice(ElementId element) const;

 private:
  [[nodiscard]] double largest_at(ElementId junction, const std::vector<double>& size) const;

  const BondGraph& graph_;
  std::vector<double> efforts_, flows_;  ///< root mean squares, by BondId
};

}  // namespace bgsim
