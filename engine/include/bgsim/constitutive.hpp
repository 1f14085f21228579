/// In which causality the law of a port can be used, and how; whether the laws of a field come from one energy.
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

/// A law solved for what its port is to give.
struct SolvedLaw {
  Variable wanted = Variable::effort;  ///< e or f; of a store that gives f (C) or e (I), what is stored
  LawUse use = LawUse::impossible;
  ExprId solution;  ///< `wanted` by the other variables; none if implicit or impossible
};

/// Maxwell reciprocity of a field given by laws: d e_i / d q_j == d e_j / d q_i; between a port that holds q and one
/// that holds p, d e_i / d p_j == d f_j / d q_i.
struct Reciprocity {
  enum class Verdict : std::uint8_t { by_energy, proved, sampled, violated, untested } verdict = Verdict::by_energy;
  std::uint32_t port_a = 0, port_b = 0;  ///< where violated
  std::string text;                      ///< the two partial derivatives, where violated; why not, where untested
};

}  // namespace bgsim
