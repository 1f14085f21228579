/// Where the present cell of a floor, a round or a table ends.
#pragma once

#include <cstddef>
#include <utility>

#include "bgsim/program.hpp"

namespace bgsim {

/// @param relation  one that has borders.
inline std::pair<double, double> mode_borders(const Program& program, const Relation& relation, double mode) {
  if (relation.kind == Relation::Kind::floor) return {mode, mode + 1.0};
  if (relation.kind == Relation::Kind::round) return {mode - 0.5, mode + 0.5};
  const auto& x = program.pool.table(relation.table).x;
  const auto k = static_cast<std::size_t>(mode);
  return {x[k], x[k + 1]};
}

}  // namespace bgsim
