/// In which causality the law of a port can be used, and how.
///
/// Conventions (docs/notation.md). Variables of R, C, I and fields are counted positive INTO the element: with a bond
/// whose half-arrow leaves the element, the effort is the bond's and the flow is minus the bond's. Sources and
/// two-ports use the bond's own variables, counted along the half-arrow.
#pragma once

#include "bgsim/model.hpp"

namespace bgsim {

/// What an element gives at a port: the effort (flow comes in) or the flow (effort comes in).
enum class Gives : std::uint8_t { effort, flow };

/// How a law yields the variable that the causality asks for.
enum class LawUse : std::uint8_t {
  as_written,  ///< it is alone on the left
  inverted,    ///< closed-form inverse
  implicit,    ///< equation to be solved during the run (smooth law without a closed-form inverse)
  impossible,  ///< the law cannot be used in this direction (sign, if, abs, min, ..., or the variable does not occur)
};

/// How the constitutive law of a port serves a causality. For stores, `effort` of a C (`flow` of an I) is integral
/// causality. Sources: as_written for what they give, else impossible. TF, GY and junctions: not a question of laws
/// (as_written). A linear R (coefficient) is usable both ways; a coefficient that is identically 0 only as written.
LawUse law_use(const Model& model, ElementId id, std::size_t port, Gives gives);
/// The same; what the test writes goes to @p pool, a copy of model.pool or a superset of it (a caller with many
/// elements copies once).
LawUse law_use(const Model& model, ExprPool& pool, ElementId id, std::size_t port, Gives gives);

/// A law solved for what its port is to give.
struct SolvedLaw {
  Variable wanted = Variable::effort;  ///< e or f; of a store that gives f (C) or e (I), what is stored
  LawUse use = LawUse::impossible;
  ExprId solution;  ///< `wanted` by the other variables; none if implicit or impossible
};
/// Solves one law, as port_laws() gives it. New expressions go to @p pool.
SolvedLaw solve_law(ExprPool& pool, const Element& element, const Law& law, Gives gives);

/// The laws of a field or one-port in terms of ModelSymbols, one per port, port i's at position i: written laws as they
/// stand, linear keys written out (e = R f, e = q/C, f = p/I; sources e = ... or f = ...), energies differentiated
/// (e_i = dE/dq_i, f_i = dE/dp_i). TF, GY and junctions have none. New expressions go to @p pool, a copy of model.pool
/// or a superset of it.
std::vector<Law> port_laws(const Model& model, ExprPool& pool, ElementId id);

/// Maxwell reciprocity of a field given by laws: d e_i / d q_j == d e_j / d q_i.
struct Reciprocity {
  enum class Verdict : std::uint8_t { by_energy, proved, sampled, violated, untested } verdict = Verdict::by_energy;
  std::uint32_t port_a = 0, port_b = 0;  ///< where violated
  std::string text;                      ///< the two partial derivatives, where violated; why not, where untested
};
/// Symbolic test; where the difference does not simplify to zero, at 64 seeded random points (relative 1e-9).
Reciprocity test_reciprocity(const Model& model, ElementId id);
Reciprocity test_reciprocity(const Model& model, ExprPool& pool, ElementId id);

}  // namespace bgsim
