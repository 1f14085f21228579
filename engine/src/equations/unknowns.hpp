/// Symbols of a system of equations, and the equations that define its unknowns.
#pragma once

#include <string>
#include <utility>

#include "bgsim/equations.hpp"

namespace bgsim {

inline SymbolId add_symbol(EquationSystem& system, SystemSymbol::Kind kind, std::size_t index, std::string name) {
  system.symbols.push_back({kind, static_cast<std::uint32_t>(index), std::move(name)});
  return SymbolId(system.symbols.size() - 1);
}

/// A new unknown; define() writes its equation later.
inline SymbolId add_unknown(EquationSystem& system, std::string name) {
  const SymbolId symbol = add_symbol(system, SystemSymbol::Kind::unknown, system.equations.size(), std::move(name));
  system.equations.push_back({symbol, {}, false, {}, {}, {}, {}});
  return symbol;
}

/// The equation of @p unknown: `unknown = expression`, or `0 = expression` if it is @p implicit.
inline void define(EquationSystem& system, SymbolId unknown, ExprId expression, ElementId element, Place place,
                   bool implicit = false) {
  Equation& equation = system.equations[system.symbols[unknown.index()].index];
  equation = {unknown, expression, implicit, element, place, {}, equation.whole};
}

/// Where the model says what an element does: its value, rather than its name.
[[nodiscard]] inline Place line_of(const Element& element) {
  return element.coefficient_place.document.valid() ? element.coefficient_place : element.place;
}

}  // namespace bgsim
