// Systems of some tens of unknowns with a real or a complex matrix.
#include "run/integrate/column_lu.hpp"

#include <Eigen/LU>
#include <array>
#include <catch2/catch.hpp>
#include <complex>
#include <limits>
#include <random>

#include "run/integrate/small_lu.hpp"

using namespace bgsim;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// How far a solution is from solving the system, in roundings of its own terms.
template <class Matrix, class Vector>
double left_over(const Matrix& a, const Vector& x, const Vector& b) {
  return (a * x - b).norm() / (kEpsilon * (a.norm() * x.norm() + b.norm()));
}

}  // namespace

TEST_CASE("full matrices are factored with pivots, whatever their zeros") {
  std::mt19937 random(3);
  std::normal_distribution<double> number;
  for (const Eigen::Index n : {1, 2, 3, 9, 20, 33, 50})
    for (const unsigned percent : {100U, 30U, 0U})  // numbers other than 0; none but beside the diagonal and on it
      for (int repeat = 0; repeat < 20; ++repeat) {
        Eigen::MatrixXd re = Eigen::MatrixXd::Zero(n, n), im = re;
        for (Eigen::Index j = 0; j < n; ++j)
          for (Eigen::Index i = 0; i < n; ++i) {
            if (percent > 0 ? i != j && random() % 100 >= percent : std::abs(i - j) > 1) continue;
            re(i, j) = number(random);
            if (repeat % 2 == 0) im(i, j) = number(random);
          }
        // Nothing on the diagonal: without pivots there is no factorization.
        if (n > 1 && percent == 100 && repeat % 3 == 0) re.diagonal().setZero(), im.diagonal().setZero();
        const auto size = static_cast<std::size_t>(n);
        ColumnLu<false> of_real(size);
        ColumnLu<true> of_complex(size);
        std::copy(re.data(), re.data() + n * n, of_real.real());
        std::copy(re.data(), re.data() + n * n, of_complex.real());
        std::copy(im.data(), im.data() + n * n, of_complex.imaginary());
        Eigen::VectorXd p(n), q(n);
        for (Eigen::Index i = 0; i < n; ++i) p[i] = number(random), q[i] = number(random);
        INFO(n << " unknowns, " << percent << " %, " << repeat);
        // Partial pivoting leaves some roundings for each unknown at most; here a few in all.
        if (of_real.factor()) {
          Eigen::VectorXd x = p;
          of_real.solve(x.data());
          CHECK(left_over(re, x, p) < 10.0);
        } else {
          CHECK(re.norm() * re.inverse().norm() > 1e13);
        }
        REQUIRE(of_complex.factor());
        Eigen::VectorXd u = p, v = q;
        of_complex.solve(u.data(), v.data());
        const std::complex<double> i(0.0, 1.0);
        CHECK(left_over((re + i * im).eval(), (u + i * v).eval(), (p + i * q).eval()) < 10.0);
      }
}

TEST_CASE("matrices that are singular or hold no numbers are refused") {
  ColumnLu<false> lu(2);
  const auto set = [&lu](double a, double b, double c, double d) {
    lu.real()[0] = a, lu.real()[1] = c, lu.real()[2] = b, lu.real()[3] = d;
    return lu.factor();
  };
  CHECK(set(1.0, 2.0, 3.0, 4.0));
  CHECK_FALSE(set(1.0, 2.0, 2.0, 4.0));
  CHECK_FALSE(set(0.0, 1.0, 0.0, 1.0));
  CHECK_FALSE(set(std::numeric_limits<double>::quiet_NaN(), 1.0, 1.0, 1.0));
  CHECK_FALSE(set(std::numeric_limits<double>::infinity(), 1.0, 1.0, 1.0));
}

TEST_CASE("pivots are compared by the scales of their rows") {
  // p = 0 beside q, of which 1e6 p is a part. Compared by their numbers, the row of q is the pivot's of p's column, and
  // what is left of p is the rounding of q.
  const std::array<double, 4> entries{3.7, 1e6, 0.0, 3.7};  // by columns: p, q
  const std::array<double, 2> scales{1e38, 1e9};
  ColumnLu<false> lu(2), unscaled(2);
  small::SmallLu<double, 2> rows{{3.7, 0.0, 1e6, 3.7}, {}};
  std::copy(entries.begin(), entries.end(), lu.real());
  std::copy(entries.begin(), entries.end(), unscaled.real());
  REQUIRE(lu.factor(scales.data()));
  REQUIRE(rows.factor(scales));
  REQUIRE(unscaled.factor());
  int taken_on = 0;
  for (const double q : {0.1, 0.3, 0.7, 1.1, 1.3, 1.9}) {
    std::array<double, 2> by_columns{0.0, q}, by_rows{0.0, q}, without{0.0, q};
    lu.solve(by_columns.data());
    rows.solve(by_rows);
    unscaled.solve(without.data());
    for (const auto& x : {by_columns, by_rows}) {
      CHECK(x[0] == 0.0);
      CHECK(x[1] == Approx(q / 3.7).epsilon(1e-15).margin(0.0));
    }
    taken_on += without[0] != 0.0 ? 1 : 0;
  }
  CHECK(taken_on > 0);
}
