#include "equations/loops.hpp"

namespace bgsim {

std::vector<std::uint32_t> equations_in(const EquationSystem& system, ExprId expression) {
  std::vector<std::uint32_t> result;
  for (const SymbolId symbol : symbols_in(system.pool, {&expression, 1}))
    if (const SystemSymbol& meant = system.symbols[symbol.index()]; meant.kind == SystemSymbol::Kind::unknown)
      result.push_back(meant.index);
  return result;
}

Origin origin_of(const EquationSystem& system, const Equation& equation) {
  const std::size_t made = equation.expression.index();
  return equation.element.valid() || made >= system.origins.size() ? Origin{equation.element, {}}
                                                                   : system.origins[made];
}

}  // namespace bgsim
