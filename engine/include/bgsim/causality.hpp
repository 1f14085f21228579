/// CausalGraph: one causal stroke per bond, with its reason.
///
/// The stroke is at the end of the bond at which effort is imposed on the element. Hence a 0-junction has exactly
/// one stroke at it; a 1-junction exactly one bond without a stroke at it; TF exactly one of its two; GY both or none;
/// Se has its stroke at the far end, Sf at its own; C in integral causality at the far end; I at its own. (Karnopp,
/// Margolis, Rosenberg: System Dynamics.)
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/bond_graph.hpp"
#include "bgsim/constitutive.hpp"

namespace bgsim {

enum class BondEnd : std::uint8_t { tail, head };

/// Reason for a stroke.
enum class StrokeReason : std::uint8_t {
  source,          ///< `element` is a source
  one_way_law,     ///< the law of `element` can be used in this direction only
  zero_modulus,    ///< chosen: the other way TF or GY `element` would divide by a modulus that is 0 at the start
  integral,        ///< chosen: integral causality of the store `element`
  law_as_written,  ///< chosen: nonlinear R or RR `element` used as its law is written
  free_choice,     ///< chosen freely: an algebraic loop runs through this bond
  by_elimination,  ///< the other end was tried for `element` and led to a conflict
  by_rank,         ///< in a ring of junctions: what their equations leave, whatever strokes would say
  propagated,      ///< forced by the rule of `element` (junction, TF, GY) from the strokes of `causes`
};

struct Stroke {
  BondEnd end = BondEnd::head;
  StrokeReason reason = StrokeReason::propagated;
  ElementId element;  ///< see StrokeReason
  /// The one bond whose stroke forces this one; none if all other bonds of the junction together do.
  BondId cause;
  std::uint32_t order = 0;  ///< position in the sequence of assignments, so that causes always have a smaller one
};

/// A store port refused integral causality.
struct DependentPort {
  ElementId element;
  std::uint32_t port = 0;
  std::vector<ElementId> because;  ///< the stores, sources and laws whose strokes force it, in model order
  bool more = false;               ///< there are more of them than `because` names (at most kNamedCauses)
};
inline constexpr std::size_t kNamedCauses = 8;

/// A stroke that nothing forces once sources and stores have theirs, so that an algebraic loop runs through its bond.
struct FreeChoice {
  BondId bond;
  ElementId element;            ///< at the bond's tail, or the resistor at either end
  std::vector<ElementId> path;  ///< resistors, two-ports and junctions whose strokes follow from it, in model order
};

/// How the law of a port is used. It is decided with the strokes; later stages only read it.
struct PortLaw {
  Law law;           ///< as port_laws() gives it
  SolvedLaw solved;  ///< for what the port gives
  ExprId conjugate;  ///< stores: e of a C, f of an I, by what is stored; none if there is no closed form
  [[nodiscard]] bool valid() const { return law.right.valid(); }
};

/// Whether the laws of a store with several ports come from one energy.
struct FieldTest {
  ElementId element;
  Reciprocity reciprocity;
};

/// A connected part of the junction structure: junctions, TF and GY.
struct JunctionPart {
  std::vector<ElementId> elements;  ///< increasing
  std::vector<BondId> inner;        ///< bonds between them
  std::vector<PortId> outer;        ///< ports of other elements that are bonded to them, increasing
};

struct CausalGraph {
  std::vector<Stroke> strokes;           ///< by BondId
  ExprPool pool;                         ///< the model's, and the laws: the model's ids stay valid
  std::vector<PortLaw> laws;             ///< by PortId; none at junctions, TF, GY and detectors
  std::vector<FieldTest> fields;         ///< in model order
  std::vector<PortId> integral;          ///< store ports in integral causality, in model order
  std::vector<DependentPort> dependent;  ///< store ports in derivative causality, in model order
  std::vector<FreeChoice> free_choices;  ///< in order of assignment
  /// Parts with rings whose strokes do not tell what depends on what: their equations are solved as a whole, from what
  /// is given at the outer ports.
  std::vector<JunctionPart> ranked;
  std::vector<Diagnostic> warnings;

  /// What the element gives at @p port: effort if the stroke is at the other end.
  [[nodiscard]] Gives gives(const BondGraph& graph, PortId port) const {
    const bool stroke_here = (strokes[graph[port].bond.index()].end == BondEnd::head) == graph[port].head;
    return stroke_here ? Gives::flow : Gives::effort;
  }
};

/// Assigns one causal stroke to every bond by the sequential causality assignment procedure (SCAP) with a worklist:
/// sources, then laws usable in one direction only, each propagated until nothing is forced; then stores by priority
/// and model order in integral causality; then nonlinear resistors as written; then remaining bonds between junctions
/// (Lorenz and Wolper's choice: it leaves fewer loop variables), then any. Where a choice turns out to lead to a
/// conflict it is taken back and the bond gets the other stroke (`by_elimination`); this matters only in graphs whose
/// junctions form rings.
///
/// A ring may determine what strokes leave free, and the other way round. So the choice in each part with a ring is
/// held against the rank of its equations; where the two differ, the rank decides (`by_rank`): sources first, then laws
/// for one direction, stores by priority, resistors.
///
/// @throws ModelError BG301 two bonds set the effort of a 0-junction, BG302 two bonds set the flow of a 1-junction,
///         BG303 no bond sets a junction's effort or flow, BG304 a TF or GY gets contradictory strokes, BG305 a law is
///         forced against the only direction it can be used in; each with the chain of strokes that forces it, back to
///         the sources. BG411 a ring of junctions determines what a source or a law for one direction gives. BG306
///         (warning): a field given by laws is not reciprocal.
/// @note Time O(B + E), unless choices have to be taken back. Ties follow the order of elements in the model.
CausalGraph assign_causality(const Model& model, const BondGraph& graph);

/// What assign_causality comes to, also where no strokes keep all rules: for pictures of a model with errors.
struct CausalAttempt {
  std::vector<std::optional<Stroke>> strokes;  ///< by BondId; those assigned up to the conflict
  std::vector<ElementId> conflicts;            ///< whose rule or law cannot be kept; empty if all are
  std::vector<Diagnostic> problems;            ///< what assign_causality throws
};

/// As assign_causality, but keeps the strokes assigned so far instead of throwing. Same cost.
CausalAttempt attempt_causality(const Model& model, const BondGraph& graph);

/// The chain of strokes that forces the stroke of @p bond, root first.
std::vector<BondId> reason_chain(const BondGraph& graph, const CausalGraph& causal, BondId bond);

}  // namespace bgsim
