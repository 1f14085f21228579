#include "two_states_plain.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <ctime>

namespace bgsim::bench {

namespace {

int rates(realtype /*t*/, N_Vector y, N_Vector ydot, void* /*data*/) {
  const double* x = NV_DATA_S(y);
  double* f = NV_DATA_S(ydot);
  f[0] = x[1];
  f[1] = 1.0 - 0.2 * x[1] - x[0];
  return 0;
}

int jacobian(realtype /*t*/, N_Vector /*y*/, N_Vector /*fy*/, SUNMatrix matrix, void* /*data*/, N_Vector /*a*/,
             N_Vector /*b*/, N_Vector /*c*/) {
  SM_ELEMENT_D(matrix, 0, 0) = 0.0;
  SM_ELEMENT_D(matrix, 0, 1) = 1.0;
  SM_ELEMENT_D(matrix, 1, 0) = -1.0;
  SM_ELEMENT_D(matrix, 1, 1) = -0.2;
  return 0;
}

}  // namespace

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

PlainRun plain_oscillator(double stop, double relative, double absolute) {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector y = N_VNew_Serial(2, context);
  N_VConst(0.0, y);
  void* cvode = CVodeCreate(CV_BDF, context);
  CVodeInit(cvode, rates, 0.0, y);
  CVodeSStolerances(cvode, relative, absolute);
  SUNMatrix matrix = SUNDenseMatrix(2, 2, context);
  SUNLinearSolver solver = SUNLinSol_Dense(y, matrix, context);
  CVodeSetLinearSolver(cvode, solver, matrix);
  CVodeSetJacFn(cvode, jacobian);
  CVodeSetMaxNumSteps(cvode, -1);
  CVodeSetStopTime(cvode, stop);
  PlainRun run;
  for (double t = 0.0; t < stop; ++run.steps)
    if (CVode(cvode, stop, y, &t, CV_ONE_STEP) < 0) break;
  run.q = NV_Ith_S(y, 0);
  CVodeFree(&cvode);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return run;
}

}  // namespace bgsim::bench
