#include "base/lu.hpp"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <complex>

namespace bgsim {

struct DenseLu::Factors {
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
};

DenseLu::DenseLu(const Eigen::MatrixXd& matrix)
    : factors_(std::make_unique<Factors>(Factors{Eigen::PartialPivLU<Eigen::MatrixXd>(matrix)})) {}
DenseLu::~DenseLu() = default;

double DenseLu::rcond() const { return factors_->lu.rcond(); }
Eigen::MatrixXd DenseLu::solve(const Eigen::MatrixXd& right) const { return factors_->lu.solve(right); }

Eigen::VectorXd solve_with_full_pivots(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.fullPivLu().solve(right);
}

template <class Scalar>
struct SparseLu<Scalar>::Factors {
  Eigen::SparseLU<Matrix> lu;
};

template <class Scalar>
SparseLu<Scalar>::SparseLu() : factors_(std::make_unique<Factors>()) {}
template <class Scalar>
SparseLu<Scalar>::~SparseLu() = default;

template <class Scalar>
void SparseLu<Scalar>::analyze(const Matrix& matrix) {
  factors_->lu.analyzePattern(matrix);
}

template <class Scalar>
bool SparseLu<Scalar>::factorize(const Matrix& matrix) {
  factors_->lu.factorize(matrix);
  return factors_->lu.info() == Eigen::Success;
}

template <class Scalar>
typename SparseLu<Scalar>::Vector SparseLu<Scalar>::solve(const Vector& right) const {
  return factors_->lu.solve(right);
}

template <class Scalar>
typename SparseLu<Scalar>::Vector SparseLu<Scalar>::solve_transposed(const Vector& right) const {
  return factors_->lu.transpose().solve(right);
}

template class SparseLu<double>;
template class SparseLu<std::complex<double>>;

}  // namespace bgsim
