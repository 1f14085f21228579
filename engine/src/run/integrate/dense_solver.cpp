#include "run/integrate/dense_solver.hpp"

#include <sunmatrix/sunmatrix_dense.h>

#include <cstddef>
#include <utility>

#include "run/integrate/column_lu.hpp"
#include "run/integrate/direct_solver.hpp"
#include "run/integrate/row_scales.hpp"

namespace bgsim {
namespace {

class DenseSolver {
 public:
  explicit DenseSolver(std::shared_ptr<const std::vector<double>> weight)
      : weight_(std::move(weight)), scales_(weight_->size()), lu_(weight_->size()) {}

  static int initialize() { return SUNLS_SUCCESS; }

  int set_up(SUNMatrix matrix) {
    const std::size_t n = scales_.size();
    const double* const entries = SUNDenseMatrix_Data(matrix);
    row_scales::of_full(n, 0, 0.0, 1.0, entries, weight_->data(), scales_.data());
    double* const scaled = lu_.real();
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = 0; i < n; ++i) scaled[j * n + i] = entries[j * n + i] * scales_[i];
    return lu_.factor() ? SUNLS_SUCCESS : SUNLS_LUFACT_FAIL;  // the latter makes the step shorter
  }

  int solve(SUNMatrix /*matrix*/, N_Vector solution, N_Vector right, double /*tolerance*/) {
    const double* const from = N_VGetArrayPointer(right);
    double* const to = N_VGetArrayPointer(solution);
    for (std::size_t i = 0; i < scales_.size(); ++i) to[i] = from[i] * scales_[i];
    lu_.solve(to);
    return SUNLS_SUCCESS;
  }

 private:
  std::shared_ptr<const std::vector<double>> weight_;
  std::vector<double> scales_;  ///< of the rows
  ColumnLu<false> lu_;
};

}  // namespace

SUNLinearSolver make_dense_solver(SUNContext context, std::shared_ptr<const std::vector<double>> weight) {
  return make_direct_solver(context, std::make_unique<DenseSolver>(std::move(weight)));
}

}  // namespace bgsim
