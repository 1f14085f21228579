/// Laws as the model has them, for messages.
#pragma once

#include "bgsim/program.hpp"

namespace bgsim {

/// An expression without the parameters Element::own_border and share, which are 0.
/// @param pool  of the expression; @p program names its symbols
ExprId without_own_borders(const Program& program, ExprPool& pool, ExprId expression);

}  // namespace bgsim
