#include "describe/semidefinite.hpp"

#include <Eigen/Eigenvalues>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>

namespace bgsim {

bool is_positive_semidefinite(const std::vector<std::vector<double>>& matrix) {
  // Whole numbers: each double times 2^1126.
  using Number = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
  const auto whole = [](double x) {
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    const Number mantissa(static_cast<std::int64_t>(std::ldexp(fraction, 53)));
    const int shift = exponent - 53 + 1126;  // of the smallest number, with its 53 bits, it is 0
    return mantissa * (Number(1) << static_cast<unsigned>(shift));
  };
  const std::size_t n = matrix.size();
  std::vector<std::vector<Number>> s(n, std::vector<Number>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) s[i][j] = whole(matrix[i][j]) + whole(matrix[j][i]);
  // Symmetric elimination, rows times their pivots, which are not negative: a pivot below 0 is a power below 0; beside
  // one that is 0 nothing else may stand.
  for (std::size_t p = 0; p < n; ++p) {
    if (s[p][p] < 0) return false;
    for (std::size_t i = p + 1; i < n; ++i)
      if (s[p][p] == 0 && s[p][i] != 0) return false;
    if (s[p][p] == 0) continue;
    for (std::size_t i = p + 1; i < n; ++i)
      for (std::size_t j = p + 1; j < n; ++j)
        if (i <= j) s[i][j] = s[j][i] = s[i][j] * s[p][p] - s[p][i] * s[p][j];
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
