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

}  // namespace bgsim
