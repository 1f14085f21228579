/// Strokes and their reasons in words; what assign_causality and describe say of them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// Strokes that cannot stand together, by whose rule.
struct CausalConflict {
  enum class Kind : std::uint8_t {
    two_set,    ///< two or more `bonds` set what a junction's bonds share
    none_sets,  ///< no bond of a junction does
    two_port,   ///< `bonds` contradict the rule of a TF or GY
    one_port,   ///< `bonds` (one) asks of a source or a law what it cannot give
  } kind = Kind::two_set;
  ElementId element;
  PortId port;  ///< one_port only
  std::vector<BondId> bonds;
};

/// Whether the stroke of the bond at @p port is at that port.
inline bool stroke_at(const BondGraph& graph, std::span<const Stroke> strokes, PortId port) {
  const Port& at = graph[port];
  return (strokes[at.bond.index()].end == BondEnd::head) == at.head;
}

/// The bonds whose strokes force the stroke of a bond: one, all others of a junction, or none (a root).
std::vector<BondId> direct_causes(const BondGraph& graph, std::span<const Stroke> strokes, BondId bond);

/// All strokes from which those of @p bonds follow, themselves included, in order of assignment.
std::vector<BondId> strokes_behind(const BondGraph& graph, std::span<const Stroke> strokes, std::vector<BondId> bonds);

/// `stroke at "bus"`.
std::string stroke_place_text(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes, BondId bond);

/// Why the stroke is there: `"battery" is an effort source`, `0-junction "bus" has its effort from b1`.
std::string stroke_reason_text(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                               BondId bond);

/// BG301..BG305 with the chain of strokes that leads to the conflict.
Diagnostic explain_conflict(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                            const CausalConflict& conflict);

}  // namespace bgsim
