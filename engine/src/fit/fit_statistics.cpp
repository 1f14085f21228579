#include "fit/fit_statistics.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace bgsim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Half the derivative of the loss by the residual, and half the second one.
struct Influence {
  double value = 0.0, slope = 1.0;
};

Influence influence(const FitPlan& plan, double r) {
  const double at = plan.loss_at;
  if (plan.loss == FitLoss::squares || (plan.loss == FitLoss::huber && std::abs(r) <= at)) return {r, 1.0};
  if (plan.loss == FitLoss::huber) return {std::copysign(at, r), 0.0};
  const double part = r * r / (at * at);
  return {r / (1.0 + part), (1.0 - part) / ((1.0 + part) * (1.0 + part))};
}

/// Of one residual. A loss of Ceres takes the squared norm of a whole block, so that each residual would be a block of
/// its own; instead each is replaced by the root of its loss, which has the same sum of squares.
double loss_root(FitLoss loss, double at, double r, double& slope) {
  slope = 1.0;
  const double size = std::abs(r);
  if (loss == FitLoss::squares || (loss == FitLoss::huber && size <= at)) return r;
  if (loss == FitLoss::huber) {
    const double root = std::sqrt(at * (2.0 * size - at));
    slope = at / root;
    return std::copysign(root, r);
  }
  const double part = r / at, root = at * std::sqrt(std::log1p(part * part));
  if (size < 1e-8 * at) return r;
  slope = size / ((1.0 + part * part) * root);
  return std::copysign(root, r);
}

/// Columns of unit length, so that the units of the values do not matter.
struct UnitColumns {
  Eigen::MatrixXd unit;
  std::vector<double> lengths;

  UnitColumns(const FitJacobian& jacobian, const std::vector<std::size_t>& columns)
      : unit(static_cast<Eigen::Index>(jacobian.rows), static_cast<Eigen::Index>(columns.size())) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      for (std::size_t i = 0; i < jacobian.rows; ++i)
        unit(static_cast<Eigen::Index>(i), column) = jacobian.derivatives[i * jacobian.columns + columns[c]];
      const double length = unit.col(column).stableNorm();
      lengths.push_back(length);
      if (length > 0.0) unit.col(column) /= length;
    }
  }
};

/// Below this singular values of unit columns are the errors of the derivatives.
double least_singular(std::size_t columns, double accuracy) {
  return std::sqrt(static_cast<double>(columns)) * accuracy;
}

/// The deviation and the quantile of @p found, and the variance of a residual.
/// @param rank  how many directions of the values the residuals have been fitted in
double take_spread(const FitPlan& plan, const FitJacobian& jacobian, std::size_t rank, bool known_sigma,
                   FitStatistics& found) {
  // An estimate of a loss has the variance of its influence over the square of the mean slope (Huber, Robust
  // Statistics, 1981, section 7.6; from memory), which is the mean square for the sum of squares.
  double square = 0.0, slope = 0.0;
  for (const double r : jacobian.residuals) {
    const Influence each = influence(plan, r);
    square += each.value * each.value;
    slope += each.slope;
  }
  slope /= static_cast<double>(jacobian.rows);
  const double freedom = jacobian.rows > rank ? static_cast<double>(jacobian.rows - rank) : 0.0;
  found.deviation = freedom > 0.0 ? std::sqrt(square / freedom) : kNone;
  double variance = known_sigma && plan.loss == FitLoss::squares ? 1.0 : square / freedom / (slope * slope);
  if (!std::isfinite(variance) || !(slope > 0.0)) variance = kNone;
  if (known_sigma && plan.loss == FitLoss::squares)
    found.quantile = boost::math::quantile(boost::math::normal(), 0.975);
  else if (freedom > 0.0)
    found.quantile = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  return variance;
}

}  // namespace

double relative_offset(const FitJacobian& jacobian, const std::vector<char>& held, double accuracy, double noise) {
  std::vector<std::size_t> columns;
  for (std::size_t j = 0; j < jacobian.columns; ++j)
    if (held[j] == 0) columns.push_back(j);
  if (columns.empty()) return 0.0;
  const UnitColumns scaled(jacobian, columns);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled.unit, Eigen::ComputeThinU);
  const Eigen::Map<const Eigen::VectorXd> residuals(jacobian.residuals.data(),
                                                    static_cast<Eigen::Index>(jacobian.rows));
  double taken = 0.0, rank = 0.0;
  for (Eigen::Index d = 0; d < svd.singularValues().size(); ++d) {
    if (!(svd.singularValues()(d) > least_singular(columns.size(), accuracy) * svd.singularValues()(0))) break;
    taken += std::pow(svd.matrixU().col(d).dot(residuals), 2);
    rank += 1.0;
  }
  const double rest = std::max(residuals.squaredNorm() - taken, noise * noise);
  const double freedom = std::max(static_cast<double>(jacobian.rows) - rank, 1.0);
  return rank == 0.0 || taken == 0.0 ? 0.0 : std::sqrt((taken / rank) / (rest / freedom));
}

void root_of_loss(FitLoss loss, double at, std::size_t rows, std::size_t columns, double* residuals,
                  double* derivatives) {
  for (std::size_t i = 0; i < rows; ++i) {
    double slope = 1.0;
    residuals[i] = loss_root(loss, at, residuals[i], slope);
    for (std::size_t j = 0; derivatives != nullptr && j < columns; ++j) derivatives[i * columns + j] *= slope;
  }
}

FitStatistics fit_statistics(const FitPlan& plan, const FitJacobian& jacobian, const std::vector<char>& free,
                             const std::vector<double>& scales, double accuracy, bool known_sigma) {
  const std::size_t n = jacobian.columns;
  FitStatistics found;
  found.covariance.assign(n, std::vector<double>(n, kNone));
  found.correlation = found.covariance;
  found.errors.assign(n, kNone);
  found.determined.assign(n, 1);
  std::vector<std::size_t> columns;
  for (std::size_t j = 0; j < n; ++j)
    if (free[j]) columns.push_back(j);
  const std::size_t k = columns.size();
  if (k == 0) {
    take_spread(plan, jacobian, 0, known_sigma, found);
    return found;
  }
  const UnitColumns scaled(jacobian, columns);
  const Eigen::MatrixXd& unit = scaled.unit;
  const std::vector<double>& lengths = scaled.lengths;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(unit, Eigen::ComputeThinV);
  const Eigen::VectorXd& singular = svd.singularValues();
  const Eigen::MatrixXd& directions = svd.matrixV();
  const double least = least_singular(k, accuracy) * singular(0);
  // Values that nothing distinguishes take away no more of the residuals than what is known of them together: degrees
  // of freedom are counted by the rank.
  const auto rank = static_cast<std::size_t>((singular.array() > least).count());
  const double variance = take_spread(plan, jacobian, rank, known_sigma, found);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(directions.rows(), directions.rows());
  for (Eigen::Index d = 0; d < directions.cols(); ++d) {
    const bool known = d < singular.size() && singular(d) > least;
    if (known) {
      inverse += directions.col(d) * directions.col(d).transpose() / (singular(d) * singular(d));
      continue;
    }
    FitDirection direction;
    double most = 0.0;
    std::vector<double> shares(k);
    constexpr double kPart = 1e-3;  // below this a value takes no part in what is undetermined
    for (std::size_t c = 0; c < k; ++c) {
      const double part = directions(static_cast<Eigen::Index>(c), d);
      if (std::abs(part) > kPart) found.determined[columns[c]] = 0;
      shares[c] = lengths[c] > 0.0 ? part / lengths[c] / scales[columns[c]] : part;
      if (std::abs(part) > kPart && std::abs(shares[c]) > std::abs(most)) most = shares[c];
    }
    for (std::size_t c = 0; c < k; ++c) {
      if (found.determined[columns[c]] || std::abs(shares[c] / most) < kPart) continue;
      direction.names.push_back(plan.vary[columns[c]].name);
      direction.shares.push_back(shares[c] / most);
    }
    found.undetermined.push_back(std::move(direction));
  }
  for (std::size_t a = 0; a < k; ++a)
    for (std::size_t b = 0; b < k; ++b) {
      const std::size_t i = columns[a], j = columns[b];
      if (!found.determined[i] || !found.determined[j]) continue;
      const auto at = [&](std::size_t x, std::size_t y) {
        return inverse(static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(y));
      };
      found.covariance[i][j] = variance * at(a, b) / (lengths[a] * lengths[b]);
      found.correlation[i][j] = a == b ? 1.0 : at(a, b) / std::sqrt(at(a, a) * at(b, b));
      if (a == b) found.errors[i] = std::sqrt(found.covariance[i][i]);
    }
  return found;
}

}  // namespace bgsim
