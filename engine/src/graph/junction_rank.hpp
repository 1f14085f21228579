/// The junction structure as linear equations: which efforts and flows at its ports are free to choose, and what all
/// others are then. Where junctions form rings, terms may cancel, and strokes do not show it; the rank of the equations
/// does.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// The connected parts of junctions, TF and GY in which bonds form a ring.
std::vector<JunctionPart> ring_parts(const BondGraph& graph);

/// A factor: its residue tells whether it vanishes; the expression is there only where equations are written.
struct Coefficient {
  std::uint64_t residue = 0;
  ExprId expression;
};

/// The equations of one part, solved. Every Dirac structure has a choice of one variable at each port that determines
/// the others, and a choice at some ports that are independent can be completed (matroids: the ports that ask first
/// have their wish).
class JunctionRank {
 public:
  using Row = std::map<std::uint32_t, Coefficient>;  ///< by variable; in equations the sum is 0
  /// @param modulus  of a TF or GY.
  /// @param pool     where coefficients get their expressions; none: residues only.
  JunctionRank(const BondGraph& graph, const JunctionPart& part, const std::function<Coefficient(ElementId)>& modulus,
               ExprPool* pool);

  /// What the part gets at an outer port, from what the element there gives.
  [[nodiscard]] std::uint32_t variable(PortId outer, Gives gives) const;
  [[nodiscard]] std::uint32_t variable(BondId bond, Variable variable) const;

  /// Makes a variable at an outer port an input. False if the inputs so far determine it: determined() tells how.
  bool take(std::uint32_t variable);
  [[nodiscard]] Row determined(std::uint32_t variable) const;

  /// Whether everything within the part is determined, too: nothing runs round a ring and comes out nowhere.
  [[nodiscard]] bool determines_all() const { return inner_pivots_.size() == 2 * inner_bonds_; }

  /// By variable, once there is an input at each outer port: the sum over inputs that it is; none if nothing determines
  /// it (what runs round a ring and comes out nowhere).
  std::vector<std::optional<Row>> solutions();

 private:
  struct Pivot {
    std::uint32_t variable, row;
  };

  void write(const BondGraph& graph, const JunctionPart& part, const std::function<Coefficient(ElementId)>& modulus);
  void eliminate_inner();
  void reduce_outer();
  void pivot_on(std::uint32_t row, std::uint32_t variable);
  void subtract(Row& from, const Row& what, const Coefficient& times) const;
  [[nodiscard]] bool inner(std::uint32_t variable) const { return variable < 2 * inner_bonds_; }

  [[nodiscard]] Coefficient number(int value) const;
  [[nodiscard]] Coefficient product(const Coefficient& a, const Coefficient& b) const;
  [[nodiscard]] Coefficient quotient(const Coefficient& a, const Coefficient& b) const;
  [[nodiscard]] Coefficient difference(const Coefficient& a, const Coefficient& b) const;
  [[nodiscard]] Coefficient plain(Coefficient c) const;

  const BondGraph& graph_;
  ExprPool* pool_;
  std::size_t inner_bonds_ = 0;
  std::unordered_map<BondId, std::uint32_t> place_;  ///< of a bond: inner ones first
  std::vector<Row> rows_;
  std::vector<bool> used_;                               ///< by row: the pivot of an inner variable
  std::vector<Pivot> inner_pivots_;                      ///< in order of elimination
  std::unordered_map<std::uint32_t, std::uint32_t> of_;  ///< outer variable that is no input -> its row
  std::vector<bool> taken_;                              ///< by variable
};

}  // namespace bgsim
