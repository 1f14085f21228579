#include "run/integrate/radau_systems.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "base/lu.hpp"
#include "run/integrate/column_lu.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/row_scales.hpp"
#include "run/integrate/small_lu.hpp"
#include "run/integrate/sparse_places.hpp"

namespace bgsim {

namespace radau {
namespace {

using small::Pair;
using small::SmallLu;

template <std::size_t N>
class SmallSystems final : public RadauSystems {
 public:
  SmallSystems(std::size_t states, const RadauEigenvalues& eigenvalues)
      : states_(states), gamma_(eigenvalues.gamma), pairs_(eigenvalues.pairs), complex_(pairs_.size()) {
    std::fill_n(mass_.begin(), states, 1.0);
  }

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double h, const double* jacobian, const double* weight) override {
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j)
        real_.a[i * N + j] = -h * jacobian[j * N + i] + (i == j ? gamma_ * mass_[i] : 0.0);
    std::array<double, N> scales{};
    row_scales::of_full(N, states_, gamma_, h, jacobian, weight, scales.data());
    if (!real_.factor(scales)) return false;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const double alpha = pairs_[k].real(), beta = pairs_[k].imag();
      for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j)
          complex_[k].a[i * N + j] = {-h * jacobian[j * N + i] + (i == j ? alpha * mass_[i] : 0.0),
                                      i == j ? beta * mass_[i] : 0.0};
      if (!complex_[k].factor(scales)) return false;
    }
    return true;
  }

  void solve_real(double* u) override {
    std::array<double, N> b{};
    for (std::size_t i = 0; i < N; ++i) b[i] = u[i];
    real_.solve(b);
    for (std::size_t i = 0; i < N; ++i) u[i] = b[i];
  }

  void solve_complex(std::size_t pair, double* v, double* w) override {
    std::array<Pair, N> b{};
    for (std::size_t i = 0; i < N; ++i) b[i] = {v[i], w[i]};
    complex_[pair].solve(b);
    for (std::size_t i = 0; i < N; ++i) {
      v[i] = b[i].re;
      w[i] = b[i].im;
    }
  }

 private:
  std::size_t states_;
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  std::array<double, N> mass_{};
  SmallLu<double, N> real_;
  std::vector<SmallLu<Pair, N>> complex_;
};

class DenseSystems final : public RadauSystems {
 public:
  DenseSystems(std::size_t size, std::size_t states, const RadauEigenvalues& eigenvalues)
      : n_(size),
        states_(states),
        gamma_(eigenvalues.gamma),
        pairs_(eigenvalues.pairs),
        scales_(size),
        real_(size),
        complex_(pairs_.size(), ColumnLu<true>(size)) {}

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double h, const double* jacobian, const double* weight) override {
    double* const real = real_.real();
    for (std::size_t i = 0; i < n_ * n_; ++i) {
      real[i] = -h * jacobian[i];
      if (!std::isfinite(real[i])) return false;
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      std::copy(real, real + n_ * n_, complex_[k].real());
      std::fill(complex_[k].imaginary(), complex_[k].imaginary() + n_ * n_, 0.0);
      for (std::size_t i = 0; i < n_ * states_; i += n_ + 1) {
        complex_[k].real()[i] += pairs_[k].real();
        complex_[k].imaginary()[i] = pairs_[k].imag();
      }
    }
    for (std::size_t i = 0; i < n_ * states_; i += n_ + 1) real[i] += gamma_;
    row_scales::of_full(n_, states_, gamma_, h, jacobian, weight, scales_.data());
    const auto factored = [this](auto& lu) { return lu.factor(scales_.data()); };
    return factored(real_) && std::all_of(complex_.begin(), complex_.end(), factored);
  }

  void solve_real(double* u) override { real_.solve(u); }
  void solve_complex(std::size_t pair, double* v, double* w) override { complex_[pair].solve(v, w); }

 private:
  std::size_t n_, states_;
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  std::vector<double> scales_;  ///< of the rows
  ColumnLu<false> real_;
  std::vector<ColumnLu<true>> complex_;
};

class SparseSystems final : public RadauSystems {
 public:
  SparseSystems(const Sparsity& pattern, std::size_t states, const RadauEigenvalues& eigenvalues)
      : places_(pattern, states),
        n_(static_cast<Eigen::Index>(pattern.size)),
        gamma_(eigenvalues.gamma),
        pairs_(eigenvalues.pairs),
        complex_matrix_(pairs_.size(), places_.matrix.cast<std::complex<double>>()),
        complex_(pairs_.size()) {
    real_.analyze(places_.matrix);
    for (std::size_t k = 0; k < pairs_.size(); ++k) complex_[k].analyze(complex_matrix_[k]);
  }

  [[nodiscard]] bool dense() const override { return false; }

  bool factor(double h, const double* jacobian, const double* weight) override {
    if (!places_.fill(gamma_, h, jacobian, weight)) return false;
    const double* const real = places_.matrix.valuePtr();
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      std::complex<double>* const complex = complex_matrix_[k].valuePtr();
      std::copy(real, real + places_.matrix.nonZeros(), complex);
      for (std::size_t i = 0; i < places_.of_states.size(); ++i)
        complex[places_.of_states[i]] += pairs_[k] * places_.scales[i];
    }
    places_.shift(gamma_);
    if (!real_.factorize(places_.matrix)) return false;
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      if (!complex_[k].factorize(complex_matrix_[k])) return false;
    return true;
  }

  void solve_real(double* u) override {
    Eigen::Map<Eigen::VectorXd> right(u, n_);
    right.array() *= places_.scale_of_rows();
    solution_ = real_.solve(right);
    right = solution_;
  }

  void solve_complex(std::size_t pair, double* v, double* w) override {
    complex_right_.resize(n_);
    for (Eigen::Index i = 0; i < n_; ++i)
      complex_right_[i] = std::complex<double>(v[i], w[i]) * places_.scales[static_cast<std::size_t>(i)];
    complex_solution_ = complex_[pair].solve(complex_right_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      v[i] = complex_solution_[i].real();
      w[i] = complex_solution_[i].imag();
    }
  }

 private:
  SparsePlaces places_;
  Eigen::Index n_;
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  std::vector<Eigen::SparseMatrix<std::complex<double>>> complex_matrix_;
  SparseLu<double> real_;
  std::vector<SparseLu<std::complex<double>>> complex_;
  Eigen::VectorXd solution_;
  Eigen::VectorXcd complex_right_, complex_solution_;
};

}  // namespace
}  // namespace radau

std::unique_ptr<RadauSystems> make_radau_systems(const Sparsity& pattern, std::size_t states,
                                                 const RadauEigenvalues& eigenvalues) {
  // Ladders of 70 and 100 states take half as long as by sparse matrices, those of 200 as long (bench methods
  // --random).
  constexpr std::size_t kFullStates = 100;
  switch (pattern.size) {
    case 1:
      return std::make_unique<radau::SmallSystems<1>>(states, eigenvalues);
    case 2:
      return std::make_unique<radau::SmallSystems<2>>(states, eigenvalues);
    case 3:
      return std::make_unique<radau::SmallSystems<3>>(states, eigenvalues);
    case 4:
      return std::make_unique<radau::SmallSystems<4>>(states, eigenvalues);
    case 5:
      return std::make_unique<radau::SmallSystems<5>>(states, eigenvalues);
    case 6:
      return std::make_unique<radau::SmallSystems<6>>(states, eigenvalues);
    case 7:
      return std::make_unique<radau::SmallSystems<7>>(states, eigenvalues);
    case 8:
      return std::make_unique<radau::SmallSystems<8>>(states, eigenvalues);
    default:
      if (pattern.size <= kFullStates) return std::make_unique<radau::DenseSystems>(pattern.size, states, eigenvalues);
      return std::make_unique<radau::SparseSystems>(pattern, states, eigenvalues);
  }
}

}  // namespace bgsim
