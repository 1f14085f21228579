/// A table by two integrators that share no code, with what they disagree by.
#pragma once

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "integrate.hpp"
#include "table.hpp"

namespace reference {

/// Where the tables go, and which of them (those whose name begins so; empty: all).
struct Target {
  std::string folder, only;
};

/// Solves by both methods, compares column by column, writes the Radau solution. Columns that a symmetry keeps at zero
/// are compared on the scale given in `magnitudes`.
template <std::size_t N, class Row>
void solve(const Target& target, const std::string& name, const std::vector<std::string>& columns,
           const Rates<N>& rates, const Vector<N>& start, const Vector<N>& scale, const Grid& grid, const Row& row,
           const std::vector<Real>& magnitudes = {}, Real tolerance = 1e-15L) {
  if (name.compare(0, target.only.size(), target.only) != 0) return;
  std::vector<Real> times = times_of(grid);
  // Every solution starts at 0, whether or not its table does.
  const std::size_t skipped = grid.first > 0 ? 1 : 0;
  if (skipped != 0) times.insert(times.begin(), 0);
  const auto tabulate = [&](const std::vector<Vector<N>>& states) {
    Table table{columns, {}};
    for (std::size_t i = skipped; i < times.size(); ++i) table.rows.push_back(row(times[i], states[i]));
    return table;
  };
  const Table radau = tabulate(by_radau<N>(rates, start, scale, times, tolerance));
  const Table second = tabulate(by_extrapolation<N>(rates, start, scale, times, tolerance / 10));
  std::printf("%-28s", name.c_str());
  Real worst = 0;
  for (std::size_t c = 1; c < columns.size(); ++c) {
    const Real least = magnitudes.empty() ? 0 : magnitudes[c];
    const Real difference = scaled_difference(radau, second, c, least);
    worst = std::max(worst, difference);
    std::printf(" %s %.1Le", columns[c].c_str(), difference);
  }
  std::printf("\n");
  std::fflush(stdout);
  if (!(worst < 1e-9L)) throw std::runtime_error(name + ": the two methods disagree");
  write_csv(target.folder + "/" + name + ".csv", radau);
}

}  // namespace reference
