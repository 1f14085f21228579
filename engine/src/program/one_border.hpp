/// Laws of resistors with one border.
#pragma once

#include <optional>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// The system with laws of resistors that jump at one border written with one sign or condition, whose mode they are a
/// straight line over. Where the border is held a law takes whatever value between those of its two sides holds it.
/// Written with several (`if(f > 0, c, if(f < 0, -c, 0))`), or with a sign within something else (`exp(a*sign(f))`,
/// `max(sign(f), -0.5)`), a value between the modes of both sides may be none of these, or several modes may be.
/// So is one that has its border by a signal (`"mu": "if(n.f > 0, 0.5, 1)"`, `e = mu*sign(f)`): what a signal compares
/// is not held. What such a law is at the border itself counts where it is that of a side, or 0 between a value and its
/// negative. Laws whose guard follows no state are left as they are, since nothing holds them, and so are those whose
/// guard is on an algebraic loop.
/// @return  none where there is no such law
/// @note    Time linear in the pool, and in what is below each part of such a law.
std::optional<BlockOrder> with_one_border(const Model& model, const EquationSystem& system, const BlockOrder& order);

}  // namespace bgsim
