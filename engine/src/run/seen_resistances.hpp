/// How large resistances are that do not hide what diodes see of their circuits.
#pragma once

#include <array>
#include <vector>

namespace bgsim {

/// Of a diode as a resistor r in series with a source s, as all others are: by how much its f, f' and f'' (in time)
/// change with its s.
struct SlopesThrough {
  double resistance = 0.0;
  std::array<double, 3> slopes{};  ///< those that are rounding are 0
};

/// Times r and a power of the time slopes are numbers without units, and powers of r as long as the circuit is small or
/// large beside r: r/(R + r) of a resistance R, r/L of an inertance L, 1/(r C) of a capacitance C. Where a power ends,
/// or its factor changes, both are of the same size: R, or sqrt(L/C) where both are seen. The result is the geometric
/// mean of these r, each weighed by how much the power, or the decades of the factor, change.
///
/// Where r is 1e16 times what the circuit has, or a part of that, rounding looks like a circuit, too. What is 1e12
/// times the lowest r of a diode does not count. And what is there is seen by slopes of several orders, and by several
/// diodes: of all ranges of 1e8 that with the most weight counts, a diode's own twice. Where a diode sees nothing of
/// that kind (an inertance or a capacitance alone), the r of which the time constant L/r or r C is the time @p span:
/// what the resistance adds is slower than the run then. Where it sees nothing at all, 1. Efforts times E and flows
/// times F give each r times E/F.
///
/// @param scans  by diode; at resistances that rise
/// @note  Cost: k log k of k slopes.
std::vector<double> seen_resistances(const std::vector<std::vector<SlopesThrough>>& scans, double span);

}  // namespace bgsim
