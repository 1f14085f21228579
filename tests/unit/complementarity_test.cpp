// Lemke's method over numbers with a small parameter, against enumeration.
#include "run/complementarity.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <optional>
#include <random>

#include "support/rounds.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

// In more digits than the method has, since what is found with a small parameter is tried with a small number.
using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

int pick(std::mt19937_64& random, int from, int to) {
  return from + static_cast<int>(random() % static_cast<std::uint64_t>(to - from + 1));
}

/// Skew with entries of -1, 0, 1, what a junction structure is, plus losses at some ports.
Matrix passive(std::mt19937_64& random, int n, int losses_of_10) {
  Matrix m = Matrix::Zero(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      m(i, j) = pick(random, -1, 1);
      m(j, i) = -m(i, j);
    }
  for (int i = 0; i < n; ++i)
    if (pick(random, 1, 10) <= losses_of_10) m(i, i) = pick(random, 1, 3);
  return m;
}

PowerSeries plain(Real value) { return PowerSeries::number(static_cast<double>(value)); }

/// w - M z = q, with the rows mixed so that nothing is left of this form.
Complementarity posed(std::mt19937_64& random, const Matrix& m, const Vector& q) {
  const auto n = static_cast<std::size_t>(q.size());
  Matrix mix = Matrix::Identity(q.size(), q.size());
  for (int i = 0; i < q.size(); ++i)
    for (int j = 0; j < i; ++j) mix(i, j) = pick(random, -1, 1);
  const Matrix z = -mix * m;
  const Vector r = mix * q;
  Complementarity problem;
  problem.size = n;
  for (int i = 0; i < q.size(); ++i) {
    problem.z.emplace_back();
    problem.w.emplace_back();
    for (int j = 0; j < q.size(); ++j) {
      problem.z.back().push_back({static_cast<std::size_t>(j), plain(z(i, j))});
      problem.w.back().push_back({static_cast<std::size_t>(j), plain(mix(i, j))});
    }
    problem.r.push_back(plain(r(i)));
  }
  return problem;
}

/// Values of the chosen variables, w_i or z_i, where the others are 0; none where they are not determined.
std::optional<Vector> values_of(const Matrix& m, const Vector& q, const std::vector<bool>& takes_z) {
  Matrix basis(q.size(), q.size());
  for (int i = 0; i < q.size(); ++i)
    basis.col(i) = takes_z[static_cast<std::size_t>(i)] ? Vector(-m.col(i)) : Vector(Vector::Unit(q.size(), i));
  const Eigen::FullPivLU<Matrix> solver(basis);
  if (!solver.isInvertible()) return std::nullopt;
  return solver.solve(q);
}

bool some_mode_is_possible(const Matrix& m, const Vector& q, const std::vector<bool>& held) {
  const auto n = static_cast<std::size_t>(q.size());
  for (std::size_t number = 0; number < (std::size_t{1} << n); ++number) {
    std::vector<bool> takes_z(n);
    for (std::size_t i = 0; i < n; ++i) takes_z[i] = (number >> i & 1U) != 0;
    const auto values = values_of(m, q, takes_z);
    if (!values) continue;
    bool possible = true;
    for (std::size_t i = 0; i < n; ++i) {
      const Real value = (*values)(static_cast<int>(i));
      // The data are small integers: what is not zero is far from it.
      possible = possible && (held[i] ? !takes_z[i] || std::abs(value) < 1e-9 : value > -1e-12L);
    }
    if (possible) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("Lemke's method finds a mode of random passive networks, or none where enumeration finds none") {
  std::size_t solved = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < share_of(6000); ++seed) {
    INFO(seed);
    std::mt19937_64 random(seed);
    const int n = pick(random, 1, 8);
    const Matrix m = passive(random, n, pick(random, 0, 10));
    Vector q(n);
    for (int i = 0; i < n; ++i) q(i) = pick(random, -3, 3);
    std::vector<bool> first, held;
    const bool some_held = pick(random, 0, 3) == 0;
    for (int i = 0; i < n; ++i) {
      first.push_back(pick(random, 0, 1) == 1);
      held.push_back(some_held && pick(random, 0, 3) == 0);
    }
    const ComplementarySides sides = solve_complementarity(posed(random, m, q), first, held);
    CHECK(sides.solved == some_mode_is_possible(m, q, held));
    if (!sides.solved) {
      ++refused;
      CHECK(!sides.unbounded.empty());
      continue;
    }
    ++solved;
    const auto values = values_of(m, q, sides.takes_z);
    REQUIRE(values);  // a basis
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      // Some tens of roundings of numbers below a thousand.
      if (!held[at]) CHECK((*values)(i) > -1e-9);
      CHECK(static_cast<double>((*values)(i)) == Approx(sides.value[at].finite_part()).epsilon(1e-9).margin(1e-9));
      if (held[at] && sides.takes_z[at]) CHECK(std::abs((*values)(i)) < 1e-9);
    }
  }
  CHECK(solved > refused);
  CHECK(refused > 0);
}

TEST_CASE("a mode that is found with a small parameter holds at small numbers") {
  // w = (M0 + h M1) z + q0 + h q1 with many entries of 0, as diodes between coils and capacitors have it.
  std::size_t solved = 0;
  for (std::uint64_t seed = 0; seed < share_of(3000); ++seed) {
    INFO(seed);
    std::mt19937_64 random(seed);
    const int n = pick(random, 1, 7);
    Matrix m[] = {passive(random, n, 2), Matrix(n, n)};
    for (int i = 0; i < n * n; ++i) m[1](i / n, i % n) = pick(random, 0, 2) == 0 ? pick(random, -1, 1) : 0;
    m[1] = m[1] * m[1].transpose().eval();  // what stores are seen as
    Vector q[] = {Vector(n), Vector(n)};
    for (int i = 0; i < n; ++i)
      for (Vector& part : q) part(i) = pick(random, 0, 1) * pick(random, -2, 2);
    Complementarity problem;
    problem.size = static_cast<std::size_t>(n);
    const std::array<double, 2> none{};
    for (int i = 0; i < n; ++i) {
      problem.z.emplace_back();
      for (int j = 0; j < n; ++j)
        problem.z.back().push_back(
            {static_cast<std::size_t>(j),
             PowerSeries::of<2>({static_cast<double>(-m[0](i, j)), static_cast<double>(-m[1](i, j))}, none, true)});
      problem.w.push_back({{static_cast<std::size_t>(i), plain(1.0)}});
      problem.r.push_back(PowerSeries::of<2>({static_cast<double>(q[0](i)), static_cast<double>(q[1](i))}, none, true));
    }
    const ComplementarySides sides =
        solve_complementarity(problem, std::vector<bool>(problem.size, false), std::vector<bool>(problem.size, false));
    const Real h = 1e-4L;  // far below the ratios of coefficients, which are those of small integers
    const Matrix at_h = m[0] + h * m[1];
    const Vector q_at_h = q[0] + h * q[1];
    CHECK(sides.solved == some_mode_is_possible(at_h, q_at_h, std::vector<bool>(problem.size, false)));
    if (!sides.solved) continue;
    ++solved;
    const auto values = values_of(at_h, q_at_h, sides.takes_z);
    REQUIRE(values);
    CHECK(values->minCoeff() > -1e-12L);
  }
  CHECK(solved > 1000 * share_of(3000) / 3000);
}

TEST_CASE("a number whose leading coefficient is within its rounding begins with the next one") {
  const PowerSeries a = PowerSeries::of<3>({1e-17, -2.0, 3.0}, {1e-15, 0.0, 0.0}, false);
  CHECK(a.sign() == -1);
  CHECK(a.order == 1);
  CHECK(a.finite_part() == 0.0);
  const PowerSeries b = PowerSeries::number(1.0) / a;
  CHECK(b.order == -1);
  CHECK(b.coefficient[0] == -0.5);
  CHECK(b.coefficient[1] == -0.75);
  CHECK(b.known == 1);  // what follows depends on what is not known of a
  CHECK(b.coefficient[2] == 0.0);
  CHECK((a - a).sign() == 0);
  CHECK((a * b - PowerSeries::number(1.0)).sign() == 0);
  CHECK(std::isinf(b.finite_part()));
}

TEST_CASE("what one row is off by leaves the values of the others as they are known") {
  // A suction valve whose flow is known to a third, z = -0.7 +- 0.3, beside a delivery valve that holds 0.48 back.
  const auto series = [](double a, double b, double rounding = 1e-15) {
    return PowerSeries::of<2>({a, b}, {rounding, rounding}, false);
  };
  Complementarity problem;
  problem.size = 2;
  problem.z = {{{0, series(2.3e-7, 0.23)}, {1, series(0.0, -30.0)}},
               {{0, series(0.0, -1.8e-3)}, {1, series(0.0, 0.23)}}};
  problem.w = {{{0, series(-0.84, 0.2)}, {1, series(0.0, -25.0)}},
               {{0, series(0.0, -1.5e-3)}, {1, series(-0.84, 0.2)}}};
  problem.r = {series(-1.6e-7, -12.0, 6e-8), series(-0.4, 0.1, 5e-10)};
  const ComplementarySides sides = solve_complementarity(problem, {true, false}, {false, false});
  REQUIRE(sides.solved);
  CHECK(sides.takes_z == std::vector<bool>{false, false});
  CHECK(sides.value[1].finite_part() == Approx(0.4 / 0.84).epsilon(1e-6));  // w0 is 2e-7, and h times that is added
}
