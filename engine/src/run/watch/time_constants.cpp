#include "run/watch/time_constants.hpp"

#include <algorithm>
#include <cmath>

#include "run/failures.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/spectrum.hpp"

namespace bgsim {

std::optional<Diagnostic> too_fast_state(Evaluator& evaluator, const RunInputs& inputs, const double* x,
                                         Branch branch) {
  constexpr double kFastest = 1e70;
  const Program& program = evaluator.program();
  const Sparsity& pattern = program.jacobian_pattern;
  const double span = inputs.stop - inputs.start;
  std::vector<double> entries(pattern.row.size());
  if (!evaluator.jacobian(inputs.start, x, branch, entries.data())) return std::nullopt;
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
         k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
      if (static_cast<std::size_t>(pattern.row[k]) == column && std::abs(entries[k]) * span > kFastest)
        return time_constant_failure(program.state_names[column], 1.0 / std::abs(entries[k]), span,
                                     program.states[column].place);
  return std::nullopt;
}

std::optional<FastestMotion> fastest_motion(const Program& program, Evaluator& evaluator, double t, const double* x,
                                            Branch branch) {
  const Sparsity& pattern = program.jacobian_pattern;
  std::vector<double> entries(pattern.row.size());
  if (entries.empty() || !evaluator.jacobian(t, x, branch, entries.data())) return std::nullopt;
  const auto first = [&](std::size_t column) {
    return pattern.row.begin() + static_cast<std::ptrdiff_t>(pattern.column_start[column]);
  };
  const auto entry = [&](std::size_t row, std::size_t column) {
    const auto end = first(column + 1);
    const auto found = std::lower_bound(first(column), end, static_cast<std::int64_t>(row));
    const bool there = found != end && *found == static_cast<std::int64_t>(row);
    return there ? entries[static_cast<std::size_t>(found - pattern.row.begin())] : 0.0;
  };
  FastestMotion fastest;
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = first(column); k != first(column + 1); ++k) {
      const auto row = static_cast<std::size_t>(*k);
      const double there = entries[static_cast<std::size_t>(k - pattern.row.begin())];
      // Of two states that move each other, the frequency or the rate of growth.
      const double rate = std::sqrt(std::abs(there)) * std::sqrt(std::abs(entry(column, row)));
      if (rate > fastest.rate) fastest = {row, column, rate};
    }
  if (!(fastest.rate > 0.0) || !std::isfinite(fastest.rate)) return std::nullopt;
  return fastest;
}

bool may_pick_up(const Program& program, Evaluator& evaluator, double t, const double* x, const Branch& branch,
                 double step, double elapsed, double reach) {
  constexpr double kFollowed = 0.02;  // rad a step
  constexpr double kOver = 21.0;      // time constants in which a mode falls to 1e-9
  if (program.state_names.size() > kDenseStates) return false;
  for (const std::complex<double> mode : eigenvalues(program, evaluator, t, x, branch)) {
    if (!(std::abs(mode) * step > kFollowed) || !(mode.real() < 0.0)) continue;
    const double over = kOver / -mode.real();
    if (elapsed < over && over < reach) return true;
  }
  return false;
}

}  // namespace bgsim
