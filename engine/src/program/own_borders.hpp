/// Laws as the model has them, for messages.
#pragma once

#include <unordered_map>

#include "bgsim/program.hpp"

namespace bgsim {

/// The parameters Element::own_border and share of a program, each with the 0 that it is, for substitute().
std::unordered_map<SymbolId, ExprId> own_borders(const Program& program, ExprPool& pool);

}  // namespace bgsim
