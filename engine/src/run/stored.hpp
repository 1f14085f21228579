/// What stores hold, in the order in which it is looked up: by element and port, then signal.
#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// Of a RunInputs::Initial or a StateInfo.
auto stored_key(const auto& value) { return std::tuple(value.element, value.port, value.signal); }

inline void sort_stored(std::vector<RunInputs::Initial>& values) {
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return stored_key(a) < stored_key(b); });
}

/// Puts what a store or integral holds where it is among @p stored, which is in this order.
inline void put_stored(Stored& stored, const StateInfo& state, double value) {
  const auto key = stored_key(state);
  const auto at = std::lower_bound(stored.values.begin(), stored.values.end(), key,
                                   [](const RunInputs::Initial& v, const auto& k) { return stored_key(v) < k; });
  if (at != stored.values.end() && stored_key(*at) == key) at->value = value;
}

/// The same of all states and dependent stores of a program.
inline void put_stored(Stored& stored, const Program& program, const std::vector<double>& x,
                       const std::vector<double>& dependent) {
  for (std::size_t i = 0; i < x.size(); ++i) put_stored(stored, program.states[i], x[i]);
  for (std::size_t i = 0; i < dependent.size(); ++i) put_stored(stored, program.dependent[i], dependent[i]);
}

}  // namespace bgsim
