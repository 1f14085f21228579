#include "run/integrate/real_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/lu.hpp"
#include "run/integrate/column_lu.hpp"
#include "run/integrate/row_scales.hpp"
#include "run/integrate/small_lu.hpp"
#include "run/integrate/sparse_places.hpp"

namespace bgsim {

namespace {

template <std::size_t N>
class SmallReal final : public RealSystem {
 public:
  explicit SmallReal(std::size_t states) : states_(states) { std::fill_n(mass_.begin(), states, 1.0); }

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double shift, double h, const double* jacobian, const double* weight) override {
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j)
        lu_.a[i * N + j] = -h * jacobian[j * N + i] + (i == j ? shift * mass_[i] : 0.0);
    std::array<double, N> scales{};
    row_scales::of_full(N, states_, shift, h, jacobian, weight, scales.data());
    return lu_.factor(scales);
  }

  void solve(double* u) override {
    std::array<double, N> b{};
    for (std::size_t i = 0; i < N; ++i) b[i] = u[i];
    lu_.solve(b);
    for (std::size_t i = 0; i < N; ++i) u[i] = b[i];
  }

 private:
  std::size_t states_;
  std::array<double, N> mass_{};
  small::SmallLu<double, N> lu_;
};

class DenseReal final : public RealSystem {
 public:
  DenseReal(std::size_t size, std::size_t states) : n_(size), states_(states), scales_(size), lu_(size) {}

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double shift, double h, const double* jacobian, const double* weight) override {
    double* const a = lu_.real();
    for (std::size_t i = 0; i < n_ * n_; ++i) {
      a[i] = -h * jacobian[i];
      if (!std::isfinite(a[i])) return false;
    }
    for (std::size_t i = 0; i < n_ * states_; i += n_ + 1) a[i] += shift;
    row_scales::of_full(n_, states_, shift, h, jacobian, weight, scales_.data());
    return lu_.factor(scales_.data());
  }

  void solve(double* u) override { lu_.solve(u); }

 private:
  std::size_t n_, states_;
  std::vector<double> scales_;  ///< of the rows
  ColumnLu<false> lu_;
};

class SparseReal final : public RealSystem {
 public:
  SparseReal(const Sparsity& pattern, std::size_t states) : places_(pattern, states) { lu_.analyze(places_.matrix); }

  [[nodiscard]] bool dense() const override { return false; }

  bool factor(double shift, double h, const double* jacobian, const double* weight) override {
    if (!places_.fill(shift, h, jacobian, weight)) return false;
    places_.shift(shift);
    return lu_.factorize(places_.matrix);
  }

  void solve(double* u) override {
    Eigen::Map<Eigen::VectorXd> right(u, places_.matrix.rows());
    right.array() *= places_.scale_of_rows();
    solution_ = lu_.solve(right);
    right = solution_;
  }

 private:
  SparsePlaces places_;
  SparseLu<double> lu_;
  Eigen::VectorXd solution_;
};

}  // namespace

std::unique_ptr<RealSystem> make_real_system(const Sparsity& pattern, std::size_t states) {
  constexpr std::size_t kFullStates = 100;  // make_radau_systems() says why
  switch (pattern.size) {
    case 1:
      return std::make_unique<SmallReal<1>>(states);
    case 2:
      return std::make_unique<SmallReal<2>>(states);
    case 3:
      return std::make_unique<SmallReal<3>>(states);
    case 4:
      return std::make_unique<SmallReal<4>>(states);
    case 5:
      return std::make_unique<SmallReal<5>>(states);
    case 6:
      return std::make_unique<SmallReal<6>>(states);
    case 7:
      return std::make_unique<SmallReal<7>>(states);
    case 8:
      return std::make_unique<SmallReal<8>>(states);
    default:
      if (pattern.size <= kFullStates) return std::make_unique<DenseReal>(pattern.size, states);
      return std::make_unique<SparseReal>(pattern, states);
  }
}

}  // namespace bgsim
