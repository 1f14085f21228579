/// The exponential of a matrix, of what it is applied to.
#pragma once

#include <cstddef>
#include <vector>

#include "run/integrate/column_lu.hpp"

namespace bgsim {

/// exp(h J) x by the Pade approximant of degrees 3 and 4, as the sum of its poles' parts: right to the seventh order in
/// hJ where h follows an oscillation, and nothing of what is stiff (it is L-stable).
class PadeExponential {
 public:
  explicit PadeExponential(std::size_t n) : lu_(n), part_(n), imaginary_part_(n) {}

  /// @param jacobian  J, column by column
  /// @param[out] out  by row
  /// @return  false where a pole is an eigenvalue of hJ, or hJ is not finite.
  /// @note    Cost: two complex factorizations.
  bool apply(const std::vector<double>& jacobian, double h, const std::vector<double>& x, std::vector<double>& out);

 private:
  ColumnLu<true> lu_;
  std::vector<double> part_, imaginary_part_;  ///< scratch
};

}  // namespace bgsim
