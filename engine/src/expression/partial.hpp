/// What a simplification leaves out that has no value everywhere: the logarithm of 0*log(x).
#pragma once

#include <span>
#include <string>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Whether an operator may have no value although its arguments have one: the logarithm of -1, the quotient by 0.
/// Values beyond the range of doubles do not count.
[[nodiscard]] bool is_partial(const ExprPool& pool, ExprId id);

/// The first expression below @p arguments that may have no value where those of @p result have one, or @p divisor
/// where @p result has one although that may be 0; none where @p result has all that may fail.
/// @param divisor  what one argument was divided by, or none
/// @note  Cost: what depends on both.
[[nodiscard]] ExprId lost_partial(const ExprPool& pool, std::span<const ExprId> arguments, ExprId divisor,
                                  ExprId result);

/// "this is taken as KEPT, also where LOST has no value", or is 0 where it is a divisor.
[[nodiscard]] std::string left_out_words(const ExprPool& pool, ExprId kept, ExprId lost, const SymbolName& name);

}  // namespace bgsim
