/// The laws of an element as equations, and what they can be solved for (bgsim/constitutive.hpp).
#pragma once

#include "bgsim/constitutive.hpp"
#include "expression/pieces.hpp"

namespace bgsim {

/// How the constitutive law of a port serves a causality. For stores, `effort` of a C (`flow` of an I) is integral
/// causality. Sources: as_written for what they give, else impossible. TF, GY and junctions: not a question of laws
/// (as_written). A linear R (coefficient) is usable both ways; a coefficient that is identically 0 only as written.
LawUse law_use(const Model& model, ElementId id, std::size_t port, Gives gives);
/// The same; what the test writes goes to @p pool, a copy of model.pool or a superset of it (a caller with many
/// elements copies once).
LawUse law_use(const Model& model, ExprPool& pool, ElementId id, std::size_t port, Gives gives);

/// Solves one law, as port_laws() gives it. New expressions go to @p pool.
SolvedLaw solve_law(ExprPool& pool, const Element& element, const Law& law, Gives gives);
/// The same. A law with kinks that is continuous and strictly monotone with the numbers of @p number is solved too:
/// part by part where each part has a closed form, else as an implicit equation.
SolvedLaw solve_law(ExprPool& pool, const Element& element, const Law& law, Gives gives, const NumberOf& number);

/// The laws of a field or one-port in terms of ModelSymbols, one per port, port i's at position i: written laws as they
/// stand, linear keys written out (e = R f, e = q/C, f = p/I; sources e = ... or f = ...), energies differentiated
/// (e_i = dE/dq_i, f_i = dE/dp_i). TF, GY and junctions have none. New expressions go to @p pool, a copy of model.pool
/// or a superset of it.
std::vector<Law> port_laws(const Model& model, ExprPool& pool, ElementId id);

/// Symbolic test; where the difference does not simplify to zero, at 64 seeded random points (relative 1e-9).
Reciprocity test_reciprocity(const Model& model, ElementId id);
Reciprocity test_reciprocity(const Model& model, ExprPool& pool, ElementId id);

}  // namespace bgsim
