/// Two integrators for reference solutions, with nothing of the engine in them: Radau IIA collocation with five stages
/// (order 9, implicit) in extended precision with step doubling, and Boost.Odeint's Bulirsch-Stoer extrapolation
/// (explicit). What they disagree by is the error estimate that goes with a reference.
#pragma once

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <vector>

namespace reference {

using Real = long double;
template <std::size_t N>
using Vector = std::array<Real, N>;
template <std::size_t N>
using Rates = std::function<void(const Vector<N>& y, Vector<N>& dydt, Real t)>;

/// Solves a dense linear system by elimination with row pivots; factors once, solves often.
template <std::size_t N>
class Elimination {
 public:
  explicit Elimination(std::array<Vector<N>, N> matrix) : lu_(matrix) {
    for (std::size_t k = 0; k < N; ++k) {
      std::size_t best = k;
      for (std::size_t i = k + 1; i < N; ++i)
        if (std::fabs(lu_[i][k]) > std::fabs(lu_[best][k])) best = i;
      std::swap(lu_[k], lu_[best]);
      pivot_[k] = best;
      for (std::size_t i = k + 1; i < N; ++i) {
        lu_[i][k] /= lu_[k][k];
        for (std::size_t j = k + 1; j < N; ++j) lu_[i][j] -= lu_[i][k] * lu_[k][j];
      }
    }
  }
  void solve(Vector<N>& b) const {
    // Whole rows were exchanged, multipliers included, so all exchanges come before the substitution.
    for (std::size_t k = 0; k < N; ++k) std::swap(b[k], b[pivot_[k]]);
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < i; ++j) b[i] -= lu_[i][j] * b[j];
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t j = i + 1; j < N; ++j) b[i] -= lu_[i][j] * b[j];
      b[i] /= lu_[i][i];
    }
  }

 private:
  std::array<Vector<N>, N> lu_;
  std::array<std::size_t, N> pivot_{};
};

inline constexpr std::size_t kStages = 5;

/// Nodes and weights of the Radau IIA method: nodes are the roots of P_s(x) - P_{s-1}(x) on [0, 1].
struct RadauTable {
  Vector<kStages> nodes{};
  std::array<Vector<kStages>, kStages> weights{};

  RadauTable() {
    const auto polynomial = [](Real c) {
      Real before = 1, value = 2 * c - 1;
      for (std::size_t n = 1; n < kStages; ++n) {
        const Real next = ((2 * static_cast<Real>(n) + 1) * (2 * c - 1) * value - static_cast<Real>(n) * before) /
                          static_cast<Real>(n + 1);
        before = value;
        value = next;
      }
      return value - before;
    };
    std::size_t found = 0;
    const int cells = 997;  // finer than the gaps between five roots, and no root falls on a cell's border
    for (int cell = 0; cell < cells - 1; ++cell) {
      Real low = static_cast<Real>(cell) / cells, high = static_cast<Real>(cell + 1) / cells;
      if (polynomial(low) * polynomial(high) > 0) continue;
      for (int i = 0; i < 80; ++i) {
        const Real middle = (low + high) / 2;
        (polynomial(low) * polynomial(middle) <= 0 ? high : low) = middle;
      }
      nodes[found++] = (low + high) / 2;
    }
    nodes[found++] = 1;
    if (found != kStages) throw std::logic_error("Radau nodes");
    std::array<Vector<kStages>, kStages> powers{};
    for (std::size_t k = 0; k < kStages; ++k)
      for (std::size_t j = 0; j < kStages; ++j) powers[k][j] = std::pow(nodes[j], static_cast<Real>(k));
    const Elimination<kStages> moments(powers);
    for (std::size_t i = 0; i < kStages; ++i) {
      for (std::size_t k = 0; k < kStages; ++k)
        weights[i][k] = std::pow(nodes[i], static_cast<Real>(k + 1)) / static_cast<Real>(k + 1);
      moments.solve(weights[i]);
    }
  }
};

/// Radau IIA with step doubling. `scale` gives each component's magnitude, against which errors are measured.
template <std::size_t N>
class Radau {
 public:
  Radau(Rates<N> rates, Vector<N> scale, Real tolerance)
      : rates_(std::move(rates)), scale_(scale), tolerance_(tolerance) {}

  /// Integrates from (t, y) to `until`, in place.
  void advance(Real& t, Vector<N>& y, Real until) {
    while (t < until) {
      Real h = std::min(step_, until - t);
      if (t + h > until - h / 1000) h = until - t;
      Vector<N> whole = y, halves = y;
      const bool solved = collocate(t, h, whole) && collocate(t, h / 2, halves) && collocate(t + h / 2, h / 2, halves);
      const Real error = solved ? distance(whole, halves) : 1000;
      if (error <= 1) {
        t = h == until - t ? until : t + h;
        y = halves;
      }
      const Real factor = solved ? 0.9L * std::pow(std::max(error, Real(1e-6L)), -0.1L) : 0.25L;
      if (error > 1 || h >= 0.999L * step_ || factor < 1) step_ = h * std::clamp(factor, Real(0.2L), Real(3));
      if (step_ < 1e-18L) throw std::runtime_error("Radau: the step vanishes");
    }
  }

 private:
  [[nodiscard]] Real distance(const Vector<N>& a, const Vector<N>& b) const {
    Real largest = 0;
    for (std::size_t i = 0; i < N; ++i)
      largest = std::max(largest, std::fabs(a[i] - b[i]) / (tolerance_ * (scale_[i] + std::fabs(b[i]))));
    return largest;
  }

  std::array<Vector<N>, N> jacobian(Real t, const Vector<N>& y) const {
    std::array<Vector<N>, N> columns{};
    Vector<N> base{}, moved{};
    rates_(y, base, t);
    for (std::size_t j = 0; j < N; ++j) {
      Vector<N> at = y;
      at[j] += 1e-9L * scale_[j];
      rates_(at, moved, t);
      for (std::size_t i = 0; i < N; ++i) columns[i][j] = (moved[i] - base[i]) / (at[j] - y[j]);
    }
    return columns;
  }

  /// One step: solves the collocation equations by Newton iteration with the Jacobian of the step's start.
  bool collocate(Real t, Real h, Vector<N>& y) const {
    constexpr std::size_t kSize = N * kStages;
    const std::array<Vector<N>, N> j = jacobian(t, y);
    std::array<Vector<kSize>, kSize> matrix{};
    for (std::size_t a = 0; a < kStages; ++a)
      for (std::size_t b = 0; b < kStages; ++b)
        for (std::size_t r = 0; r < N; ++r)
          for (std::size_t c = 0; c < N; ++c)
            matrix[a * N + r][b * N + c] = (a == b && r == c ? 1 : 0) - h * table_.weights[a][b] * j[r][c];
    const Elimination<kSize> newton(matrix);
    Vector<kSize> z{};
    Real before = 1e300L;
    for (int iteration = 0; iteration < 60; ++iteration) {
      Vector<kSize> f{}, residual{};
      for (std::size_t a = 0; a < kStages; ++a) {
        Vector<N> at{}, rate{};
        for (std::size_t r = 0; r < N; ++r) at[r] = y[r] + z[a * N + r];
        rates_(at, rate, t + table_.nodes[a] * h);
        for (std::size_t r = 0; r < N; ++r) f[a * N + r] = rate[r];
      }
      for (std::size_t a = 0; a < kStages; ++a)
        for (std::size_t r = 0; r < N; ++r) {
          Real sum = -z[a * N + r];
          for (std::size_t b = 0; b < kStages; ++b) sum += h * table_.weights[a][b] * f[b * N + r];
          residual[a * N + r] = sum;
        }
      newton.solve(residual);
      Real change = 0;
      for (std::size_t i = 0; i < kSize; ++i) {
        z[i] += residual[i];
        change = std::max(change, std::fabs(residual[i]) / scale_[i % N]);
      }
      if (!std::isfinite(change)) return false;
      if (change < tolerance_ / 100) {
        for (std::size_t r = 0; r < N; ++r) y[r] += z[(kStages - 1) * N + r];
        return true;
      }
      if (iteration > 3 && change > 0.7L * before) return false;
      before = change;
    }
    return false;
  }

  RadauTable table_;
  Rates<N> rates_;
  Vector<N> scale_;
  Real tolerance_;
  Real step_ = 1e-9L;
};

/// States at the given times by Radau IIA.
template <std::size_t N>
std::vector<Vector<N>> by_radau(const Rates<N>& rates, Vector<N> y, Vector<N> scale, const std::vector<Real>& times,
                                Real tolerance) {
  Radau<N> method(rates, scale, tolerance);
  std::vector<Vector<N>> states{y};
  Real t = times.front();
  for (std::size_t i = 1; i < times.size(); ++i) {
    method.advance(t, y, times[i]);
    states.push_back(y);
  }
  return states;
}

/// The same by extrapolation. Components are scaled, since Odeint has one absolute tolerance for all of them. (Fehlberg
/// 7(8) will not do: its error estimate sees the ends of a step only, and steps over the kink of the orifice law.)
template <std::size_t N>
std::vector<Vector<N>> by_extrapolation(const Rates<N>& rates, Vector<N> y, Vector<N> scale,
                                        const std::vector<Real>& times, Real tolerance) {
  namespace odeint = boost::numeric::odeint;
  const auto scaled = [&](const Vector<N>& u, Vector<N>& dudt, Real t) {
    Vector<N> at{};
    for (std::size_t i = 0; i < N; ++i) at[i] = u[i] * scale[i];
    rates(at, dudt, t);
    for (std::size_t i = 0; i < N; ++i) dudt[i] /= scale[i];
  };
  for (std::size_t i = 0; i < N; ++i) y[i] /= scale[i];
  std::vector<Vector<N>> states;
  odeint::integrate_times(odeint::bulirsch_stoer<Vector<N>, Real, Vector<N>, Real>(tolerance, tolerance, 1, 0), scaled,
                          y, times.begin(), times.end(), Real(1e-9L), [&](const Vector<N>& u, Real) {
                            Vector<N> at{};
                            for (std::size_t i = 0; i < N; ++i) at[i] = u[i] * scale[i];
                            states.push_back(at);
                          });
  return states;
}

}  // namespace reference
