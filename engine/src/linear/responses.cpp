// Frequency and time responses from one input to one output.
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "base/lu.hpp"
#include "linear/analysis.hpp"
#include "linear/dense.hpp"

namespace bgsim {
namespace {

using Complex = std::complex<double>;
using Index = Eigen::Index;
using SparseMatrix = Eigen::SparseMatrix<Complex>;

/// Powers of two by state, such that what acts on a state and what it acts on are of like magnitude.
Eigen::VectorXd state_scales(const LinearMatrix& a, const Eigen::VectorXd& b, const Eigen::VectorXd& c) {
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(b.size());
  for (int sweep = 0; sweep < 30; ++sweep) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(b.size()), column = row;
    for (const auto& e : a.entries) {
      if (e.row == e.column) continue;
      const double value = std::abs(e.value) * scale(e.column) / scale(e.row);
      row(e.row) += value;
      column(e.column) += value;
    }
    bool done = true;
    for (Index i = 0; i < b.size(); ++i) {
      double in = row(i), out = column(i);
      if (in == 0.0 && out == 0.0) in = std::abs(b(i)) / scale(i), out = std::abs(c(i)) * scale(i);
      if (in == 0.0 || out == 0.0) continue;
      const double f = std::exp2(std::round(0.25 * std::log2(in / out)));
      done = done && f == 1.0;
      scale(i) *= f;
    }
    if (done) break;
  }
  return scale;
}

/// By its series, after halving until that converges fast, and squaring as often.
Eigen::MatrixXd exponential(const Eigen::MatrixXd& matrix) {
  const double norm = matrix.cwiseAbs().colwise().sum().maxCoeff();
  const int halvings = norm > 0.25 ? static_cast<int>(std::ceil(std::log2(norm / 0.25))) : 0;
  const Eigen::MatrixXd small = matrix * std::exp2(-halvings);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()), term = sum;
  for (int k = 1; k <= 14; ++k) {  // 0.25^15/15! is below rounding
    term = term * small / static_cast<double>(k);
    sum += term;
  }
  for (int k = 0; k < halvings; ++k) sum = sum * sum;
  return sum;
}

}  // namespace

FrequencyResponse frequency_response(const LinearSystem& system, std::size_t input, std::size_t output,
                                     std::span<const double> omega, double right) {
  const SinglePath path = single_path(system, input, output);
  const auto n = static_cast<Index>(path.states.size());
  FrequencyResponse result;
  result.omega.assign(omega.begin(), omega.end());
  const Eigen::VectorXd scale = state_scales(path.a, path.b, path.c);
  const Eigen::VectorXcd b = path.b.cwiseQuotient(scale).cast<Complex>();
  const Eigen::VectorXcd c = path.c.cwiseProduct(scale).cast<Complex>();
  std::vector<Eigen::Triplet<Complex>> triplets;
  for (Index i = 0; i < n; ++i) triplets.emplace_back(static_cast<int>(i), static_cast<int>(i), Complex(0.0));
  for (const auto& e : path.a.entries)
    triplets.emplace_back(static_cast<int>(e.row), static_cast<int>(e.column),
                          Complex(-e.value * scale(e.column) / scale(e.row)));
  SparseMatrix minus_a(n, n);
  minus_a.setFromTriplets(triplets.begin(), triplets.end());
  minus_a.makeCompressed();
  SparseLu<Complex> lu;
  bool analyzed = false;
  for (const double w : result.omega) {
    const Complex s(right * w, w);
    Complex direct = 0.0, power = 1.0;
    for (const double d : path.d) direct += d * power, power *= s;
    Complex value = direct;
    if (n > 0) {
      SparseMatrix matrix = minus_a;
      Eigen::VectorXd rows = Eigen::VectorXd::Zero(n);
      for (Index i = 0; i < n; ++i) matrix.coeffRef(i, i) += s;
      for (Index k = 0; k < matrix.outerSize(); ++k)
        for (SparseMatrix::InnerIterator it(matrix, k); it; ++it)
          rows(it.row()) = std::max(rows(it.row()), std::abs(it.value()));
      bool singular = rows.minCoeff() == 0.0;
      Eigen::VectorXcd source = b;
      if (!singular) {
        for (Index k = 0; k < matrix.outerSize(); ++k)
          for (SparseMatrix::InnerIterator it(matrix, k); it; ++it) it.valueRef() /= rows(it.row());
        source = b.cwiseQuotient(rows.cast<Complex>());
        if (!analyzed) lu.analyze(matrix);
        analyzed = true;
        singular = !lu.factorize(matrix);
      }
      if (singular) {
        value = std::numeric_limits<double>::infinity();
      } else {
        Eigen::VectorXcd x = lu.solve(source);
        const Eigen::VectorXcd correction = lu.solve(source - matrix * x);
        const Complex moved = (c.transpose() * correction)(0);
        x += correction;
        value += (c.transpose() * x)(0);
        // Both what the refinement moved, and what adding up the terms has lost.
        const double terms = std::abs(direct) + (c.cwiseAbs().transpose() * x.cwiseAbs())(0);
        const double error = std::abs(moved) + 4.0 * std::numeric_limits<double>::epsilon() * terms;
        if (std::isfinite(std::abs(value)) && std::abs(value) > 0.0)
          result.error = std::max(result.error, error / std::abs(value));
        else if (!std::isfinite(std::abs(value)))
          value = std::numeric_limits<double>::infinity();
      }
    }
    result.value.push_back(value);
  }
  return result;
}

TimeResponse time_response(const LinearSystem& system, std::size_t input, std::size_t output, Excitation excitation,
                           double stop, std::size_t points) {
  const SinglePath path = single_path(system, input, output);
  if (path.states.size() > kLargestDense)
    throw ModelError(
        {diagnostic_of("BG409", std::to_string(path.states.size()) + " states: too many for a step response", {},
                       "up to " + std::to_string(kLargestDense) + " states are taken densely",
                       "run the model with a source that steps")},
        nullptr);
  const auto n = static_cast<Index>(path.states.size());
  const Eigen::VectorXd scale = state_scales(path.a, path.b, path.c);
  Eigen::MatrixXd a = scale.cwiseInverse().asDiagonal() * dense(path.a) * scale.asDiagonal();
  const Eigen::VectorXd b = path.b.cwiseQuotient(scale), c = path.c.cwiseProduct(scale);
  // The input is one more state, which rests.
  const bool step = excitation == Excitation::step;
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + 1, n + 1);
  whole.topLeftCorner(n, n) = a;
  whole.col(n).head(n) = b;
  const double h = points > 1 ? stop / static_cast<double>(points - 1) : 0.0;
  const Eigen::MatrixXd advance = exponential(whole * h);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n + 1);
  if (step)
    x(n) = 1.0;
  else
    x.head(n) = b;
  TimeResponse result;
  const double direct = path.d[0];
  result.singular.assign(path.d.begin() + (step ? 1 : 0), path.d.end());
  while (!result.singular.empty() && result.singular.back() == 0.0) result.singular.pop_back();
  for (std::size_t i = 0; i < points; ++i) {
    result.times.push_back(static_cast<double>(i) * h);
    result.value.push_back(c.dot(x.head(n)) + (step ? direct : 0.0));
    x = advance * x;
  }
  return result;
}

}  // namespace bgsim
