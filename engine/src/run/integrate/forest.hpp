/// Linear systems whose unknowns are coupled along trees: lines of sections, branches, anything without a ring.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// LU factors of such a matrix: eliminated from the leaves, it gets no entry that it has not, whatever its values are
/// (S. Parter, SIAM Review 3 (1961) 119). There are no pivots to choose.
class Forest {
 public:
  /// None if the pattern has a ring of three unknowns or more.
  static std::optional<Forest> of(const Sparsity& pattern);

  /// @param entries  of the pattern. False where pivots should have been chosen.
  bool factor(const double* entries);
  /// After a factor() that was true. @p right and @p solution may be the same.
  void solve(const double* right, double* solution);

 private:
  void find_arms();

  // By position: parents before their children, the middle of the longest path of a tree first.
  std::vector<std::uint32_t> unknown_, parent_;                   ///< a root is its own parent
  std::vector<std::int64_t> diagonal_, to_parent_, from_parent_;  ///< entries: (k, k), (parent, k), (k, parent); -1: 0
  std::vector<double> pivot_, below_, above_;                     ///< 1/U(k,k), L(parent,k), U(k,parent)/U(k,k)
  std::vector<double> terms_, work_;
  /// Positions whose parent is two before them: two arms in turn, as a line has from its middle on.
  struct Arms {
    std::uint32_t first, end;
  };
  std::vector<Arms> arms_;
};

}  // namespace bgsim
