#include "run/integrate/dense_solver.hpp"

#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
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
    std::copy_n(entries, n * n, lu_.real());
    return lu_.factor(scales_.data()) ? SUNLS_SUCCESS : SUNLS_LUFACT_FAIL;  // the latter makes the step shorter
  }

  int solve(SUNMatrix /*matrix*/, N_Vector solution, N_Vector right, double /*tolerance*/) {
    double* const to = N_VGetArrayPointer(solution);
    std::copy_n(N_VGetArrayPointer(right), scales_.size(), to);
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
