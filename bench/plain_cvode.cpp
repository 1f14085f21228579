// What CVODE makes of the inputs of docs/extremes.md if the same equations are handed to it as they are: BDF, dense,
// difference quotients for the Jacobian, scalar tolerances, one call from the start to the end. The table of
// docs/plain-cvode.md, as Markdown.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace {

constexpr long kMostSteps = 2'000'000;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

using State = std::vector<double>;
using Rates = std::function<State(double t, const State& x)>;

struct Case {
  const char* input;
  const char* truth;
  Rates rates;
  State start;
  double stop = 1.0;
  double relative = 1e-6, absolute = 1e-9;
  /// What is reported of the final state; by default the first component.
  std::function<std::string(const State&)> end = {};
};

std::string text(const char* name, double value) {
  char buffer[60];
  std::snprintf(buffer, sizeof buffer, "%s = %.6g", name, value);
  return buffer;
}

int call_rates(realtype t, N_Vector x, N_Vector rates, void* data) {
  const double* values = NV_DATA_S(x);
  const State f = static_cast<const Case*>(data)->rates(t, State(values, values + NV_LENGTH_S(x)));
  for (std::size_t i = 0; i < f.size(); ++i) NV_Ith_S(rates, static_cast<sunindextype>(i)) = f[i];
  return 0;
}

void be_silent(int /*code*/, const char* /*module*/, const char* /*function*/, char* /*message*/, void* /*data*/) {}

void run(const Case& what) {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  const auto size = static_cast<sunindextype>(what.start.size());
  N_Vector x = N_VNew_Serial(size, context);
  for (sunindextype i = 0; i < size; ++i) NV_Ith_S(x, i) = what.start[static_cast<std::size_t>(i)];
  void* cvode = CVodeCreate(CV_BDF, context);
  CVodeSetErrHandlerFn(cvode, be_silent, nullptr);
  CVodeInit(cvode, call_rates, 0.0, x);
  CVodeSetUserData(cvode, const_cast<Case*>(&what));
  CVodeSStolerances(cvode, what.relative, what.absolute);
  SUNMatrix matrix = SUNDenseMatrix(size, size, context);
  SUNLinearSolver solver = SUNLinSol_Dense(x, matrix, context);
  CVodeSetLinearSolver(cvode, solver, matrix);
  CVodeSetMaxNumSteps(cvode, kMostSteps);
  CVodeSetMaxHnilWarns(cvode, -1);
  double t = 0.0;
  const int flag = CVode(cvode, what.stop, x, &t, CV_NORMAL);
  long steps = 0;
  CVodeGetNumSteps(cvode, &steps);
  const State end(NV_DATA_S(x), NV_DATA_S(x) + size);
  char* name = CVodeGetReturnFlagName(flag);
  std::printf("| %s | %s | %g | %s | %ld | %.9g | %s |\n", what.input, what.truth, what.relative,
              flag >= 0 ? "success" : name, steps, t, what.end ? what.end(end).c_str() : text("x", end[0]).c_str());
  std::fflush(stdout);
  std::free(name);
  CVodeFree(&cvode);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  N_VDestroy(x);
  SUNContext_Free(&context);
}

double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/// q' = p/L, p' = -q/C.
Rates oscillator(double inertance, double capacitance) {
  return [=](double, const State& x) { return State{x[1] / inertance, -x[0] / capacitance}; };
}

/// Mass 1 on a spring 1 under Coulomb friction of 0.08.
Rates sliding() {
  return [](double, const State& x) { return State{x[1], -x[0] - 0.08 * sign(x[1])}; };
}

/// A mass of 1 against a gas, e = 1 - 1/q, with a little damping.
Rates gas() {
  return [](double, const State& x) { return State{x[1], 1.0 / x[0] - 1.0 - 0.1 * x[1]}; };
}

std::vector<Case> cases() {
  constexpr double kPi = std::numbers::pi;
  const auto filled = [](auto source) { return [=](double t, const State& x) { return State{source(t) - x[0]}; }; };
  std::vector<Case> all;
  all.push_back({"pulse of 1000 V and 1 ms at t = 5 on R = C = 1",
                 "x = 6.741317e-3",
                 filled([](double t) { return t >= 5.0 && t < 5.001 ? 1000.0 : 0.0; }),
                 {0.0},
                 10.0});
  all.push_back({"bell of area 1, 1e-8 s wide, at t = 5",
                 "x = exp(-5) = 6.737947e-3",
                 filled([](double t) {
                   const double z = (t - 5.0) / 1e-8;
                   return std::exp(-z * z) / (1e-8 * std::sqrt(kPi));
                 }),
                 {0.0},
                 10.0});
  all.push_back({"square wave of 1 kHz on R = C = 1",
                 "x = -tanh(T/4)(1 - exp(-1)) = -1.580e-4",
                 filled([](double t) { return sign(std::sin(2.0 * kPi * 1000.0 * t)); }),
                 {0.0},
                 1.0});
  const auto share = [](const State& x) { return text("x/x0", x[0] / 1e-160); };
  all.push_back({"L = C = 1e-150, q0 = 1e-160, one period, absolute tolerance 1e-9",
                 "x/x0 = 1",
                 oscillator(1e-150, 1e-150),
                 {1e-160, 0.0},
                 2.0 * kPi * 1e-150,
                 1e-6,
                 1e-9,
                 share});
  all.push_back({"the same, absolute tolerance 1e-170",
                 "x/x0 = 1",
                 oscillator(1e-150, 1e-150),
                 {1e-160, 0.0},
                 2.0 * kPi * 1e-150,
                 1e-6,
                 1e-170,
                 share});
  all.push_back({"oscillator from q = 1, p = 0 with absolute tolerance 0",
                 "x = cos(1) = 0.540302",
                 oscillator(1.0, 1.0),
                 {1.0, 0.0},
                 1.0,
                 1e-6,
                 0.0,
                 {}});
  all.push_back({"oscillator over 1000 periods",
                 "energy 0.5",
                 oscillator(1.0, 1.0),
                 {1.0, 0.0},
                 2000.0 * kPi,
                 1e-6,
                 1e-9,
                 [](const State& x) { return text("energy", 0.5 * (x[0] * x[0] + x[1] * x[1])); }});
  all.push_back({"tank with outflow sqrt(x)/10 past the moment at which it is empty",
                 "x = 0 from t = 20 on",
                 [](double, const State& x) { return State{-std::sqrt(x[0]) / 10.0}; },
                 {1.0},
                 30.0});
  all.push_back({"a law without a value from t = 0.5 on",
                 "none",
                 [](double t, const State&) { return State{t < 0.5 ? 1.0 : kNan}; },
                 {0.0},
                 1.0});
  all.push_back({"gas 1/x against 1, pushed by a momentum of -1000 from x = 1",
                 "the law ends at x = 0",
                 gas(),
                 {1.0, -1000.0},
                 10.0});
  all.push_back({"the same gas from rest at x = -0.01", "no gas has such a volume", gas(), {-0.01, 0.0}, 10.0});
  all.push_back({"electrostatic gap above pull-in, 0.36/(2(1 - x)^2)",
                 "the plates touch at x = 1",
                 [](double, const State& x) {
                   return State{x[1], 0.36 / (2.0 * (1.0 - x[0]) * (1.0 - x[0])) - x[0] - 0.5 * x[1]};
                 },
                 {0.0, 0.0},
                 20.0});
  all.push_back({"x' = x^2",
                 "grows without bound at t = 1",
                 [](double, const State& x) { return State{x[0] * x[0]}; },
                 {1.0},
                 2.0});
  all.push_back({"relay x' = -sign(x)",
                 "stays at x = 0 from t = 1 on",
                 [](double, const State& x) { return State{-sign(x[0])}; },
                 {1.0},
                 2.0});
  all.push_back({"Coulomb friction 0.08 sign(v) under a mass on a spring, from x = 1",
                 "rest at x = 0.04",
                 sliding(),
                 {1.0, 0.0},
                 50.0});
  all.push_back({"hard stop of stiffness 1e6 at x = 1, met with 1 m/s",
                 "x = 0.5031416",
                 [](double, const State& x) {
                   return State{x[1], x[0] > 1.0 ? -1e6 * (x[0] - 1.0) : 0.0};
                 },
                 {0.0, 1.0},
                 1.5,
                 1e-3,
                 1e-6,
                 {}});
  all.push_back({"x' = -x/1e-320 over 1e-320 s",
                 "x = exp(-1) = 0.367879",
                 [](double, const State& x) { return State{-x[0] / 1e-320}; },
                 {1.0},
                 1e-320});
  return all;
}

}  // namespace

int main() {
  std::printf(
      "| input | correct result | relative | CVODE returns | steps | t reached | final value |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const Case& one : cases()) run(one);
  return 0;
}
