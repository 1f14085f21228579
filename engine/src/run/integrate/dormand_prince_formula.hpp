/// What the method of Dormand and Prince has beside its table (butcher_tables): dense output, and where it is stable.
#pragma once

#include <array>

namespace bgsim::dormand_prince {

inline constexpr int kDenseOrder = 4;

/// The dense output is y + u (dy + (1 - u) (l + u (r + (1 - u) b))) with dy the change over the step, l = h k1 - dy,
/// r = dy - h k7 - l, b = h sum(kBend[i] k[i]). @cite hairer1993 (II.6, program DOPRI5)
inline constexpr std::array<double, 7> kBend{-12715105075.0 / 11282082432.0,  0.0,
                                             87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
                                             701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
                                             69997945.0 / 29380423.0};

/// |h lambda| up to which a step does not magnify a mode of direction @p angle (radians from the negative real axis),
/// from the polynomial 1 + z + z^2/2 + z^3/6 + z^4/24 + z^5/120 + z^6/600: 3.3 on the real axis, 1.0 on the imaginary
/// one. 0 for modes that grow.
double stable_reach(double angle);

}  // namespace bgsim::dormand_prince
