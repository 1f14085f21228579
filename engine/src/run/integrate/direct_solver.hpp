/// Own direct linear solvers as SUNDIALS calls them.
#pragma once

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <memory>

namespace bgsim {

/// A solver that owns @p content, which has
///
///     int initialize();
///     int set_up(SUNMatrix matrix);
///     int solve(SUNMatrix matrix, N_Vector solution, N_Vector right, double tolerance);
///
/// with SUNDIALS' return codes. Null when memory runs out.
template <class Content>
SUNLinearSolver make_direct_solver(SUNContext context, std::unique_ptr<Content> content) {
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  if (solver == nullptr) return nullptr;
  solver->content = content.release();
  solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
  solver->ops->initialize = [](SUNLinearSolver self) { return static_cast<Content*>(self->content)->initialize(); };
  solver->ops->setup = [](SUNLinearSolver self, SUNMatrix matrix) {
    return static_cast<Content*>(self->content)->set_up(matrix);
  };
  solver->ops->solve = [](SUNLinearSolver self, SUNMatrix matrix, N_Vector solution, N_Vector right, double tolerance) {
    return static_cast<Content*>(self->content)->solve(matrix, solution, right, tolerance);
  };
  solver->ops->free = [](SUNLinearSolver self) {
    delete static_cast<Content*>(self->content);
    SUNLinSolFreeEmpty(self);
    return static_cast<int>(SUNLS_SUCCESS);
  };
  return solver;
}

}  // namespace bgsim
