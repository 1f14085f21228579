#include "run/integrate/spectrum.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numbers>

#include "run/integrate/dense_jacobian.hpp"

namespace bgsim {

namespace {

std::optional<Eigen::MatrixXd> dense_jacobian(const Program& program, Evaluator& evaluator, double t, const double* x,
                                              Branch branch) {
  const Sparsity& pattern = program.jacobian_pattern;
  std::vector<double> entries(pattern.row.size());
  if (!evaluator.jacobian(t, x, branch, entries.data())) return std::nullopt;
  const auto size = static_cast<Eigen::Index>(pattern.size);
  Eigen::MatrixXd jacobian(size, size);
  spread_entries(pattern, entries.data(), jacobian.data());
  if (!jacobian.allFinite()) return std::nullopt;
  return jacobian;
}

/// Scales states by powers of two until row and column of each are about equally large: states in units of 1e-6 beside
/// others of 1e5 would cost the eigenvalues of small magnitude their digits. (Eigen's solver does not balance.)
/// @cite osborne1960
void balance(Eigen::MatrixXd& matrix) {
  constexpr int kMostSweeps = 100;
  constexpr double kWorthIt = 0.95;
  bool changed = true;
  for (int sweep = 0; changed && sweep < kMostSweeps; ++sweep) {
    changed = false;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      const double own = std::abs(matrix(i, i));
      const double column = matrix.col(i).lpNorm<1>() - own, row = matrix.row(i).lpNorm<1>() - own;
      if (!(column > 0.0) || !(row > 0.0)) continue;
      const double factor = std::exp2(std::round(std::log2(row / column) / 2.0));
      if (!(column * factor + row / factor < kWorthIt * (column + row))) continue;
      matrix.col(i) *= factor;
      matrix.row(i) /= factor;
      changed = true;
    }
  }
}

std::vector<std::complex<double>> eigenvalues(Eigen::MatrixXd jacobian) {
  balance(jacobian);
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(jacobian, false);
  if (solver.info() != Eigen::Success) return {};
  return {solver.eigenvalues().begin(), solver.eigenvalues().end()};
}

}  // namespace

std::vector<std::complex<double>> eigenvalues(const Program& program, Evaluator& evaluator, double t, const double* x,
                                              const Branch& branch) {
  auto jacobian = dense_jacobian(program, evaluator, t, x, branch);
  return jacobian ? eigenvalues(std::move(*jacobian)) : std::vector<std::complex<double>>();
}

double stable_angle(int order) {
  constexpr std::array<double, 5> kDegrees{90.0, 90.0, 86.03, 73.35, 51.84};
  return kDegrees.at(static_cast<std::size_t>(order - 1));
}

std::optional<SpentMode> spent_mode(const Program& program, Evaluator& evaluator, double t, const double* x,
                                    const Branch& branch, double span, double step) {
  constexpr double kTimesOver = 100.0;  // dies out within a hundredth of the scene
  constexpr double kUnresolved = 0.7;   // rad a step
  constexpr int kMostOrder = 5;
  auto jacobian = dense_jacobian(program, evaluator, t, x, branch);
  // No eigenvalue is larger than the norm.
  if (!jacobian || jacobian->cwiseAbs().colwise().sum().maxCoeff() * step < kUnresolved) return std::nullopt;
  std::optional<SpentMode> worst;
  for (const std::complex<double> mode : eigenvalues(std::move(*jacobian))) {
    const double damping = -mode.real(), frequency = std::abs(mode.imag());
    if (!(damping * span > kTimesOver) || !(std::abs(mode) * step > kUnresolved)) continue;
    const double angle = std::atan2(frequency, damping) * 180.0 / std::numbers::pi;
    int order = kMostOrder;
    while (order > 2 && angle > stable_angle(order)) --order;
    if (order < (worst ? worst->order : kMostOrder)) worst = SpentMode{order, frequency, damping};
  }
  return worst;
}

}  // namespace bgsim
