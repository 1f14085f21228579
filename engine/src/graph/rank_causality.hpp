/// Strokes where junctions form rings: what the rank of the junction structure says where strokes alone fail.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "graph/given_starts.hpp"
#include "graph/junction_rank.hpp"
#include "graph/modulus_residues.hpp"
#include "graph/solved_laws.hpp"

namespace bgsim {

/// A part whose variables are found from the rank, with what the elements at its outer ports give.
struct RankedPart {
  JunctionPart part;
  std::vector<Stroke> outer;                         ///< by outer port
  std::map<PortId, std::vector<ElementId>> because;  ///< of store ports that are dependent, in model order
};

/// Looks at the parts with rings of one graph.
class RankCausality {
 public:
  RankCausality(const Model& model, const BondGraph& graph, const SolvedLaws& laws)
      : model_(model),
        graph_(graph),
        laws_(laws),
        given_(model),
        residues_(model),
        parts_(ring_parts(graph)),
        state_(parts_.size()) {}

  [[nodiscard]] std::span<const RankedPart> ranked() const { return ranked_; }
  [[nodiscard]] bool any() const { return !parts_.empty(); }

  /// Parts whose strokes @p strokes keep all rules and yet choose variables that are not free, or a store in derivative
  /// causality that seems to depend on what is none of its causes: solves them. True if there were any.
  /// @throws ModelError BG411 a source or a law for one direction gives what the ring determines.
  bool correct(std::span<const Stroke> strokes);
  /// The same for the parts in which no strokes keep the rules of @p conflicts; false if the rank finds no way either.
  bool settle(const std::vector<ElementId>& conflicts);

 private:
  enum class State : std::uint8_t { open, right, ranked };

  [[nodiscard]] ElementKind kind(PortId port) const { return graph_.kinds[graph_[port].element.index()]; }
  /// What a port of a store gives in integral causality.
  [[nodiscard]] Gives integral(PortId port) const {
    const Port& at = graph_[port];
    return stores_displacement(model_.elements[at.element.index()], at.number) ? Gives::effort : Gives::flow;
  }
  bool take_all(const JunctionPart& part, std::span<const Stroke> strokes, JunctionRank& rank) const;
  [[nodiscard]] bool only_states_determine(const JunctionPart& part, std::span<const Stroke> strokes,
                                           const JunctionRank& rank) const;
  void keep(const JunctionPart& part, std::span<const Stroke> strokes, const JunctionRank& rank);
  [[nodiscard]] std::vector<ElementId> elements_in(const JunctionPart& part, const JunctionRank& rank,
                                                   const JunctionRank::Row& row) const;
  [[nodiscard]] bool computes_in_sequence(const JunctionPart& part, std::span<const Stroke> strokes) const;
  [[nodiscard]] PortId giver(std::span<const Stroke> strokes, BondId bond, Variable variable) const;
  template <class Need>
  void computed_from(std::span<const Stroke> strokes, PortId giver, Variable variable, const Need& need) const;
  [[nodiscard]] bool seems_to_depend(const JunctionPart& part, std::span<const Stroke> strokes, PortId store) const;
  [[nodiscard]] std::vector<PortId> by_right(const JunctionPart& part) const;
  bool solve(const JunctionPart& part, std::span<const Stroke> strokes, std::vector<Diagnostic>* problems);
  [[nodiscard]] JunctionRank rank_of(const JunctionPart& part);
  [[nodiscard]] Diagnostic contradiction(const JunctionPart& part, PortId port, Gives gives,
                                         const std::vector<ElementId>& from) const;

  const Model& model_;
  const BondGraph& graph_;
  const SolvedLaws& laws_;
  GivenStarts given_;
  ModulusResidues residues_;
  std::vector<JunctionPart> parts_;
  std::vector<State> state_;
  std::vector<RankedPart> ranked_;
};

}  // namespace bgsim
