#include "program/own_borders.hpp"

#include <unordered_map>

#include "bgsim/expression.hpp"

namespace bgsim {

ExprId without_own_borders(const Program& program, ExprPool& pool, ExprId expression) {
  std::unordered_map<SymbolId, ExprId> none;
  for (const Element& element : program.model->elements)
    for (const ParameterId parameter : {element.own_border, element.share})
      if (parameter.valid()) none.emplace(program.parameters[parameter.index()], pool.constant(0.0));
  return none.empty() ? expression : substitute(pool, expression, none);
}

}  // namespace bgsim
