#include "by_hand.hpp"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace bgsim::bench {

namespace {

int call_rates(realtype t, N_Vector x, N_Vector f, void* data) {
  static_cast<const ByHand*>(data)->rates(t, N_VGetArrayPointer(x), N_VGetArrayPointer(f));
  return 0;
}

int call_dense(realtype t, N_Vector x, N_Vector /*f*/, SUNMatrix matrix, void* data, N_Vector /*a*/, N_Vector /*b*/,
               N_Vector /*c*/) {
  static_cast<const ByHand*>(data)->jacobian(t, N_VGetArrayPointer(x), SUNDenseMatrix_Data(matrix));
  return 0;
}

int call_sparse(realtype t, N_Vector x, N_Vector /*f*/, SUNMatrix matrix, void* data, N_Vector /*a*/, N_Vector /*b*/,
                N_Vector /*c*/) {
  const auto* model = static_cast<const ByHand*>(data);
  std::copy(model->column_start.begin(), model->column_start.end(), SUNSparseMatrix_IndexPointers(matrix));
  std::copy(model->row.begin(), model->row.end(), SUNSparseMatrix_IndexValues(matrix));
  model->jacobian(t, N_VGetArrayPointer(x), SUNSparseMatrix_Data(matrix));
  return 0;
}

void be_silent(int /*code*/, const char* /*module*/, const char* /*function*/, char* /*message*/, void* /*data*/) {}

/// One packet of the two models, with the numbers of models/packet.json.
struct Packet {
  double area = 0.0096, stiffness = 350.0, damping = 0.4, kp = 40.0, kd = 10.0, amplitude = 0.3, omega = 1.0,
         phase = 0.0, unit = 1e5, supply = 0.0, delta = 1e-3;
  double orifice = 0.8 * 0.008, compliance = 0.0096 * 0.3 / (1.225 * 8.31451 * 300.0);

  void take_sound_units() {
    compliance = area * amplitude / (1.225 * 287.0 * 300.0);
    orifice = 0.8 * std::numbers::pi * 0.008 * 0.008 / 4.0 * std::sqrt(2.0 / 1.225);
  }
  [[nodiscard]] double reference(double t) const { return amplitude * std::sin(omega * t + phase); }
  [[nodiscard]] double pump(double t, double x, double v) const {
    return supply + unit * (kp * (reference(t) - x) + kd * (amplitude * omega * std::cos(omega * t + phase) - v));
  }
  [[nodiscard]] double pressure(double q, double x) const { return (q - area * x) / compliance; }
  [[nodiscard]] double flow(double drop) const { return orifice * drop / std::sqrt(std::hypot(drop, delta)); }
  [[nodiscard]] double slope(double drop) const {
    const double size = std::hypot(drop, delta);
    return orifice * (0.5 * drop * drop + delta * delta) / (size * size * std::sqrt(size));
  }
  [[nodiscard]] double force(double q, double x, double v) const {
    return area * pressure(q, x) - stiffness * x - damping * v;
  }
};

struct Bellow final : ByHand {
  Packet packet;
  double mass = 0.015;

  explicit Bellow(const char* scene) {
    start.assign(3, 0.0);
    scale = {3e-3, 0.3, 5e-3};
    output_count = 5;
    if (std::strcmp(scene, "step") == 0) {
      packet.unit = 0.0;
      packet.supply = 10937.5;
    } else if (std::strcmp(scene, "literal") == 0) {
      packet.unit = 1.0;
      scale = {3e-6, 3e-4, 5e-6};
    } else if (std::strcmp(scene, "physical") == 0) {
      packet.take_sound_units();
    }
  }
  void rates(double t, const double* x, double* f) const override {
    const double v = x[2] / mass;
    f[0] = packet.flow(packet.pump(t, x[1], v) - packet.pressure(x[0], x[1]));
    f[1] = v;
    f[2] = packet.force(x[0], x[1], v);
  }
  void jacobian(double t, const double* x, double* j) const override {
    const double v = x[2] / mass;
    const double slope = packet.slope(packet.pump(t, x[1], v) - packet.pressure(x[0], x[1]));
    j[0] = -slope / packet.compliance;
    j[1] = 0.0;
    j[2] = packet.area / packet.compliance;
    j[3] = slope * (packet.area / packet.compliance - packet.unit * packet.kp);
    j[4] = 0.0;
    j[5] = -packet.area * packet.area / packet.compliance - packet.stiffness;
    j[6] = -slope * packet.unit * packet.kd / mass;
    j[7] = 1.0 / mass;
    j[8] = -packet.damping / mass;
  }
  void outputs(double t, const double* x, double* values) const override {
    values[0] = x[1];
    values[1] = packet.reference(t);
    values[2] = packet.pump(t, x[1], x[2] / mass);
    values[3] = packet.pressure(x[0], x[1]);
    values[4] = packet.flow(values[2] - values[3]);
  }
};

/// States: q and x on the left, the same on the right, momenta of heave and of pitch.
struct Actuator final : ByHand {
  Packet left, right;
  double arm = 0.4, mass = 0.03, inertia = 0.03 * 0.16;

  explicit Actuator(const char* scene) {
    start.assign(6, 0.0);
    scale = {3e-3, 0.3, 3e-3, 0.3, 1e-2, 4e-3};
    output_count = 12;
    if (std::strcmp(scene, "bending") == 0) right.phase = std::numbers::pi;
  }
  void rates(double t, const double* x, double* f) const override {
    const double heave = x[4] / mass, pitch = arm * x[5] / inertia;
    const double v = heave + pitch, w = heave - pitch;
    const double on_left = left.force(x[0], x[1], v), on_right = right.force(x[2], x[3], w);
    f[0] = left.flow(left.pump(t, x[1], v) - left.pressure(x[0], x[1]));
    f[1] = v;
    f[2] = right.flow(right.pump(t, x[3], w) - right.pressure(x[2], x[3]));
    f[3] = w;
    f[4] = on_left + on_right;
    f[5] = arm * (on_left - on_right);
  }
  void jacobian(double t, const double* x, double* j) const override {
    std::fill(j, j + 36, 0.0);
    const double by_heave = 1.0 / mass, by_pitch = arm / inertia;
    const double heave = x[4] * by_heave, pitch = x[5] * by_pitch;
    for (int side = 0; side < 2; ++side) {
      const Packet& p = side == 0 ? left : right;
      const double sign = side == 0 ? 1.0 : -1.0, *own = x + 2 * side, v = heave + sign * pitch;
      const double slope = p.slope(p.pump(t, own[1], v) - p.pressure(own[0], own[1]));
      double *by_q = j + 12 * side, *by_x = by_q + 6;
      by_q[2 * side] = -slope / p.compliance;
      by_q[4] = p.area / p.compliance;
      by_q[5] = sign * arm * by_q[4];
      by_x[2 * side] = slope * (p.area / p.compliance - p.unit * p.kp);
      by_x[4] = -p.area * p.area / p.compliance - p.stiffness;
      by_x[5] = sign * arm * by_x[4];
      for (int k = 0; k < 2; ++k) {
        const double by = k == 0 ? by_heave : sign * by_pitch;
        double* by_momentum = j + 24 + 6 * k;
        by_momentum[2 * side] = -slope * p.unit * p.kd * by;
        by_momentum[2 * side + 1] = by;
        by_momentum[4] -= p.damping * by;
        by_momentum[5] -= sign * arm * p.damping * by;
      }
    }
  }
  void outputs(double t, const double* x, double* values) const override {
    const double heave = x[4] / mass, pitch = arm * x[5] / inertia;
    const double left_pressure = left.pressure(x[0], x[1]), right_pressure = right.pressure(x[2], x[3]);
    values[0] = x[1];
    values[1] = left.reference(t);
    values[2] = x[3];
    values[3] = right.reference(t);
    values[4] = (x[1] - x[3]) / (2.0 * arm);
    values[5] = (x[1] + x[3]) / 2.0;
    values[6] = arm * (left.force(x[0], x[1], heave + pitch) - right.force(x[2], x[3], heave - pitch));
    values[7] = arm * (left.area * left_pressure - right.area * right_pressure);
    values[8] = left.pump(t, x[1], heave + pitch);
    values[9] = right.pump(t, x[3], heave - pitch);
    values[10] = left.flow(values[8] - left_pressure);
    values[11] = right.flow(values[9] - right_pressure);
  }
};

struct Ladder final : ByHand {
  std::vector<std::size_t> nodes;
  double resistance, capacitance;

  Ladder(std::size_t n, const std::vector<std::size_t>& shown)
      : nodes(shown), resistance(1.0 / static_cast<double>(n)), capacitance(resistance) {
    start.assign(n, 0.0);
    scale.assign(n, 1.0);
    output_count = nodes.size();
    for (std::size_t i = 0; i < n; ++i) {
      column_start.push_back(static_cast<long>(row.size()));
      for (std::size_t k = i > 0 ? i - 1 : 0; k <= std::min(i + 1, n - 1); ++k) row.push_back(static_cast<long>(k));
    }
    column_start.push_back(static_cast<long>(row.size()));
  }
  void rates(double /*t*/, const double* x, double* f) const override {
    const double g = 1.0 / (resistance * capacitance);
    const std::size_t n = start.size();
    f[0] = g * (1.0 - 2.0 * x[0] + x[1]);
    for (std::size_t i = 1; i + 1 < n; ++i) f[i] = g * (x[i - 1] - 2.0 * x[i] + x[i + 1]);
    f[n - 1] = g * (x[n - 2] - x[n - 1]);
  }
  void jacobian(double /*t*/, const double* /*x*/, double* values) const override {
    const double g = 1.0 / (resistance * capacitance);
    const std::size_t n = start.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) *values++ = g;
      *values++ = i + 1 < n ? -2.0 * g : -g;
      if (i + 1 < n) *values++ = g;
    }
  }
  void outputs(double /*t*/, const double* x, double* values) const override {
    for (const std::size_t node : nodes) *values++ = x[node];
  }
};

/// States: stretch and momentum in turn, from the moved end.
struct Chain final : ByHand {
  std::vector<std::size_t> masses;
  static constexpr double kResistance = 0.01;

  Chain(std::size_t n, const std::vector<std::size_t>& shown) : masses(shown) {
    start.assign(2 * n, 0.0);
    scale.assign(2 * n, 0.5);
    output_count = masses.size();
    for (std::size_t i = 0; i < n; ++i) {
      column_start.push_back(static_cast<long>(row.size()));  // by the stretch: the diagonal, both momenta
      if (i > 0) row.push_back(static_cast<long>(2 * i - 1));
      row.push_back(static_cast<long>(2 * i));
      row.push_back(static_cast<long>(2 * i + 1));
      column_start.push_back(static_cast<long>(row.size()));  // by the momentum: both stretches, itself
      row.push_back(static_cast<long>(2 * i));
      row.push_back(static_cast<long>(2 * i + 1));
      if (i + 1 < n) row.push_back(static_cast<long>(2 * i + 2));
    }
    column_start.push_back(static_cast<long>(row.size()));
  }
  void rates(double t, const double* x, double* f) const override {
    const std::size_t n = start.size() / 2;
    double before = 0.5 * std::sin(t), force = x[0] + x[0] * x[0] * x[0];
    for (std::size_t i = 0; i < n; ++i) {
      const double q = i + 1 < n ? x[2 * i + 2] : 0.0, next = q + q * q * q, v = x[2 * i + 1];
      f[2 * i] = before - v;
      f[2 * i + 1] = force - next - kResistance * v;
      before = v;
      force = next;
    }
  }
  void jacobian(double /*t*/, const double* x, double* values) const override {
    const std::size_t n = start.size() / 2;
    for (std::size_t i = 0; i < n; ++i) {
      const double slope = 1.0 + 3.0 * x[2 * i] * x[2 * i];
      if (i > 0) *values++ = -slope;
      *values++ = 0.0;
      *values++ = slope;
      *values++ = -1.0;
      *values++ = -kResistance;
      if (i + 1 < n) *values++ = 1.0;
    }
  }
  void outputs(double /*t*/, const double* x, double* values) const override {
    for (const std::size_t mass : masses) *values++ = x[2 * mass + 1];
  }
};

/// n x n nodes with a capacitor of 1 each, resistors of 1 between neighbours, and one of 1 from a source of sin t to
/// the first.
struct Grid final : ByHand {
  std::size_t n;
  std::vector<std::size_t> nodes;
  Grid(std::size_t size, std::vector<std::size_t> of) : n(size), nodes(std::move(of)) {
    start.assign(n * n, 0.0);
    scale.assign(n * n, 1.0);
    output_count = nodes.size();
    for (std::size_t k = 0; k < n * n; ++k) {
      column_start.push_back(static_cast<long>(row.size()));
      each_entry(k, [this](std::size_t i) { row.push_back(static_cast<long>(i)); });
    }
    column_start.push_back(static_cast<long>(row.size()));
  }
  template <class Visit>
  void each_entry(std::size_t k, const Visit& visit) const {
    if (k >= n) visit(k - n);
    if (k % n > 0) visit(k - 1);
    visit(k);
    if (k % n + 1 < n) visit(k + 1);
    if (k + n < n * n) visit(k + n);
  }
  void rates(double t, const double* x, double* f) const override {
    for (std::size_t k = 0; k < n * n; ++k) {
      double sum = k == 0 ? std::sin(t) - x[0] : 0.0;
      each_entry(k, [&](std::size_t i) { sum += x[i] - x[k]; });
      f[k] = sum;
    }
  }
  void jacobian(double /*t*/, const double* /*x*/, double* values) const override {
    for (std::size_t k = 0; k < n * n; ++k) {
      double own = k == 0 ? -1.0 : 0.0;
      each_entry(k, [&](std::size_t i) { own -= i == k ? 0.0 : 1.0; });
      each_entry(k, [&](std::size_t i) { *values++ = i == k ? own : 1.0; });
    }
  }
  void outputs(double /*t*/, const double* x, double* values) const override {
    for (const std::size_t node : nodes) *values++ = x[node];
  }
};

}  // namespace

HandRun run_by_hand(const ByHand& model, const std::vector<double>& times, double relative) {
  const auto size = static_cast<sunindextype>(model.start.size());
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector x = N_VNew_Serial(size, context), tolerances = N_VNew_Serial(size, context);
  for (sunindextype i = 0; i < size; ++i) {
    NV_Ith_S(x, i) = model.start[static_cast<std::size_t>(i)];
    NV_Ith_S(tolerances, i) = relative * model.scale[static_cast<std::size_t>(i)];
  }
  void* cvode = CVodeCreate(CV_BDF, context);
  CVodeSetErrHandlerFn(cvode, be_silent, nullptr);
  CVodeInit(cvode, call_rates, times.front(), x);
  CVodeSetUserData(cvode, const_cast<ByHand*>(&model));
  CVodeSVtolerances(cvode, relative, tolerances);
  const bool dense = model.row.empty();
  SUNMatrix matrix = dense ? SUNDenseMatrix(size, size, context)
                           : SUNSparseMatrix(size, size, static_cast<sunindextype>(model.row.size()), CSC_MAT, context);
  SUNLinearSolver solver = dense ? SUNLinSol_Dense(x, matrix, context) : SUNLinSol_KLU(x, matrix, context);
  CVodeSetLinearSolver(cvode, solver, matrix);
  CVodeSetJacFn(cvode, dense ? call_dense : call_sparse);
  CVodeSetMaxNumSteps(cvode, 20'000'000);
  HandRun run;
  std::vector<double> values(model.output_count);
  run.columns.resize(model.output_count);
  for (std::vector<double>& column : run.columns) column.reserve(times.size());
  run.whole = true;
  for (const double at : times) {
    double t = times.front();
    if (at > t && CVode(cvode, at, x, &t, CV_NORMAL) < 0) {
      run.whole = false;
      break;
    }
    model.outputs(at, N_VGetArrayPointer(x), values.data());
    for (std::size_t i = 0; i < values.size(); ++i) run.columns[i].push_back(values[i]);
  }
  CVodeGetNumSteps(cvode, &run.steps);
  CVodeFree(&cvode);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  N_VDestroy(x);
  N_VDestroy(tolerances);
  SUNContext_Free(&context);
  return run;
}

std::unique_ptr<ByHand> bellow_by_hand(const char* scene) { return std::make_unique<Bellow>(scene); }
std::unique_ptr<ByHand> actuator_by_hand(const char* scene) { return std::make_unique<Actuator>(scene); }
std::unique_ptr<ByHand> ladder_by_hand(std::size_t n, const std::vector<std::size_t>& nodes) {
  return std::make_unique<Ladder>(n, nodes);
}
std::unique_ptr<ByHand> chain_by_hand(std::size_t n, const std::vector<std::size_t>& masses) {
  return std::make_unique<Chain>(n, masses);
}
std::unique_ptr<ByHand> grid_by_hand(std::size_t n, const std::vector<std::size_t>& nodes) {
  return std::make_unique<Grid>(n, nodes);
}

}  // namespace bgsim::bench
