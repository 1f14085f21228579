#include "program/own_borders.hpp"

namespace bgsim {

std::unordered_map<SymbolId, ExprId> own_borders(const Program& program, ExprPool& pool) {
  std::unordered_map<SymbolId, ExprId> values;
  for (const Element& element : program.model->elements)
    for (const ParameterId parameter : {element.own_border, element.share})
      if (parameter.valid()) values.emplace(program.parameters[parameter.index()], pool.constant(0.0));
  return values;
}

}  // namespace bgsim
