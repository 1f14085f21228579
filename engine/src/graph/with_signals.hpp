/// Expressions of a model with what stands behind their symbols, in an order in which each can be computed.
#pragma once

#include <functional>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// The expression of the signal that @p expression is; none for other expressions and for signals that are states.
ExprId signal_behind(const Model& model, ExprId expression);

/// What @p root depends on and @p known does not hold yet: children before parents, @p root last, and before a symbol
/// what @p behind says it stands for (none: nothing). Marks all of it as known. Circles through symbols are cut.
std::vector<ExprId> in_order(const ExprPool& pool, ExprId root, std::vector<bool>& known,
                             const std::function<ExprId(ExprId)>& behind);

}  // namespace bgsim
