/// Ordered equations in which expressions are replaced.
#pragma once

#include <vector>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// @p e of @p made, with its arguments replaced by their images.
/// @param images  by ExprId, of all that @p e is made of
ExprId with_images(BlockOrder& made, ExprId e, const std::vector<ExprId>& images);

/// Replaces what the equations and outputs of @p made are by their images.
/// @param images  by ExprId, of all that they are
void replace_by_images(BlockOrder& made, const std::vector<ExprId>& images);

}  // namespace bgsim
