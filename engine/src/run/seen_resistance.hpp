/// How large a resistance is that does not hide what a diode sees of its circuit.
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
/// mean of these r, each weighed by how much the power, or the decades of the factor, change. Those above 1e6 times the
/// lowest do not count: where terms fall as r^-2 and cancel, what rounding leaves of them looks like a circuit from 1e8
/// times on. Nor do those of f' and f'' that are 1e-10 and less of the lowest of f: of two diodes side by side the
/// circuit is seen through what the other one's r leaves of it, and is rounding there.
///
/// Where a diode sees nothing of that kind (an inertance or a capacitance alone), the r of which the time constant L/r
/// or r C is the time @p span: what the resistance adds is slower than the run then. Where it sees nothing at all, 1.
/// Efforts times E and flows times F give r times E/F.
///
/// @param scan  at resistances that rise
double seen_resistance(const std::vector<SlopesThrough>& scan, double span);

}  // namespace bgsim
