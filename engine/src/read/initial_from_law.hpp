/// What a store holds at the start, from the effort or the flow that its law gives there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// A value at a port at the start: what is stored, or the effort or flow that the law makes of it.
struct StartValue {
  std::uint32_t port = 0;
  double value = 0.0;
  bool conjugate = false;
  double rounding = 0.0;  ///< how far the value can be off
};

/// What is stored, in the order of the given values; or why it cannot be said.
struct StoredAtStart {
  std::vector<double> stored;
  std::vector<double> rounding;  ///< how far each can be off by the roundings of the given values and of the laws
  std::string fault;             ///< empty if all is well; a clause: "its law holds for ..."
  std::size_t at = 0;            ///< of the given values: the one that the fault is about
};

/// Solves the laws of a store for what is stored. One unknown: by the closed-form inverse, or by bracketing where
/// interval arithmetic proves that the law is strictly monotone. Several at once: where the laws are linear in them.
/// @param given  ports that are not among them hold 0.
/// @param symbol_values  by SymbolId: parameters have their values; the element's own and the time's are written over.
/// @param symbol_errors  by SymbolId: roundings of the parameters; 0 for all others, before and after.
StoredAtStart stored_at_start(const Model& model, ExprPool& pool, ElementId id, std::span<const StartValue> given,
                              double start, std::vector<double>& symbol_values, std::vector<double>& symbol_errors);

}  // namespace bgsim
