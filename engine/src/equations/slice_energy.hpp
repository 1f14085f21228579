/// What the energy balance of a sliced run can still look at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bgsim/bond_graph.hpp"
#include "bgsim/ordering.hpp"
#include "equations/slice_needs.hpp"

namespace bgsim {

inline constexpr std::uint32_t kNoBlock = 0xffffffffU;

/// The elements whose powers are known from what is kept, and the bonds over which they exchange energy with others.
struct AuditedPart {
  std::vector<bool> elements;  ///< by ElementId
  struct Border {
    ElementId beyond;  ///< the element at the far end
    BondId bond;
    bool inward = false;  ///< the half-arrow points at the audited element
  };
  std::vector<Border> borders;
};

/// An element is audited if neither the effort nor the flow of any of its bonds, nor what it stores, depends on
/// anything that is left out. The balance of all audited elements closes, since junctions and two-ports among them
/// conserve power.
AuditedPart audited_part(const BondGraph& graph, const EquationSystem& system, const BlockOrder& order,
                         const Needs& needs, const std::vector<std::uint32_t>& block_of_equation);

/// Gives @p sliced and @p sliced_order the energies of the audited elements, and the powers over the borders.
void keep_energies(const AuditedPart& part, const EquationSystem& system, const BlockOrder& order,
                   EquationSystem& sliced, BlockOrder& sliced_order);

}  // namespace bgsim
