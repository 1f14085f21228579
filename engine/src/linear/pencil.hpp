/// What each state follows from, as sums of products of powers.
#pragma once

#include <map>
#include <vector>

#include "linear/symbolic_system.hpp"

namespace bgsim {

using SparseRow = std::map<std::uint32_t, PowerSum>;  // by column

/// The states, and variables at which loops without a store are cut, with what each follows from.
struct Pencil {
  std::vector<SignalFlow::Node> nodes;  ///< by variable
  std::size_t states = 0;               ///< the first of them
  std::vector<SparseRow> rows;          ///< of A; of a cut: what it is equal to
  std::vector<PowerSum> input;          ///< by row: B0 + B1 s + ...
  SparseRow output;
  PowerSum direct;
};

Pencil pencil_of(const SignalFlow& flow, const SymbolicSystem& symbolic);

}  // namespace bgsim
