/// The slope of a root beside a factor that vanishes with it: f |f|^0.75 has one at 0, which |f|^0.75 has not.
#pragma once

#include <functional>
#include <optional>

#include "bgsim/expression.hpp"

namespace bgsim {

/// What an expression changes by through a root in it, for a change of what the root is of.
struct RootSlope {
  ExprId by;  ///< whose change it is: what is below the root, or within that
  ExprId value;
};

/// Of a root (a power below 1, or one that is no number) that is multiplied by @p factor: `f` of f (K + |f|^0.75).
/// Where the factor has u, and the root is of c |u|, c u^2 and the like, u d(root)/du = n root is written for it, which
/// is 0 at u = 0; product and quotient of the two would be 0 times infinity there. None of other operators and factors.
/// @param varies  whether an expression does, by what is differentiated by; c does not
/// @note Cost: bounded. Of a product of more than a hundred factors not all are looked at.
std::optional<RootSlope> root_slope(ExprPool& pool, ExprId root, ExprId factor,
                                    const std::function<bool(ExprId)>& varies);

}  // namespace bgsim
