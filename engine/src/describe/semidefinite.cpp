#include "describe/semidefinite.hpp"

#include <Eigen/Eigenvalues>
#include <boost/multiprecision/cpp_int.hpp>

namespace bgsim {

bool is_positive_semidefinite(const std::vector<std::vector<double>>& matrix) {
  using Number = boost::multiprecision::cpp_rational;
  const std::size_t n = matrix.size();
  std::vector<std::vector<Number>> s(n, std::vector<Number>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) s[i][j] = Number(matrix[i][j]) + Number(matrix[j][i]);
  // Symmetric elimination: a pivot below 0 is a power below 0; beside one that is 0 nothing else may stand.
  for (std::size_t p = 0; p < n; ++p) {
    if (s[p][p] < 0) return false;
    for (std::size_t i = p + 1; i < n; ++i) {
      if (s[p][p] == 0 && s[p][i] != 0) return false;
      if (s[p][i] == 0) continue;
      const Number factor = s[i][p] / s[p][p];
      for (std::size_t j = p + 1; j < n; ++j) s[i][j] -= factor * s[p][j];
    }
  }
  return true;
}

std::vector<double> direction_of_negative_power(const std::vector<std::vector<double>>& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size());
  Eigen::MatrixXd s(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      s(i, j) = 0.5 * (matrix[a][b] + matrix[b][a]);
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(s);
  const Eigen::VectorXd u = solver.eigenvectors().col(0);
  if (!(u.dot(s * u) < 0.0)) return {};
  return {u.data(), u.data() + n};
}

}  // namespace bgsim
