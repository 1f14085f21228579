#include "support/descriptor.hpp"

#include "support/algebra.hpp"

namespace bgsim::test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<DescriptorFlow> DescriptorFlow::of(const MatrixXd& e, const MatrixXd& a) {
  constexpr double kShift = 1.37, kSingular = 1e-9, kZero = 1e-11;
  constexpr int kIndex = 3;  // above that of any network of R, L, C and sources, which is 2
  const Eigen::Index n = e.rows();
  const MatrixXd shifted = kShift * e - a;
  if (!is_invertible(shifted, kSingular)) return std::nullopt;
  const MatrixXd m = solved(shifted, e);
  MatrixXd power = m;
  for (int i = 1; i < kIndex; ++i) power = (power * m).eval();
  const SingularValues parts = singular_values(power);
  const Eigen::Index rank = parts.values(0) > 0.0 ? parts.rank(kZero) : 0;
  DescriptorFlow flow;
  flow.e_ = e;
  flow.a_ = a;
  flow.range_ = parts.u.leftCols(rank);
  // Coordinates along both spaces: the inverse of their bases side by side.
  MatrixXd bases(n, n);
  bases << flow.range_, parts.v.rightCols(n - rank);
  if (!is_invertible(bases, kSingular)) return std::nullopt;
  flow.left_ = solved(bases, MatrixXd::Identity(n, n)).topRows(rank);
  const MatrixXd within = flow.left_ * m * flow.range_;
  if (rank > 0 && !is_invertible(within, kSingular)) return std::nullopt;
  flow.rates_ = kShift * MatrixXd::Identity(rank, rank) -
                (rank > 0 ? solved(within, MatrixXd::Identity(rank, rank)) : MatrixXd(0, 0));
  MatrixXd both(2 * n, n);
  both << e, a;
  const SingularValues s = singular_values(both);
  const Eigen::Index known = s.rank(kSingular);
  flow.impulse_ =
      s.v.leftCols(known) * s.values.head(known).cwiseInverse().asDiagonal() * s.u.leftCols(known).transpose();
  return flow;
}

VectorXd DescriptorFlow::consistent(const VectorXd& z) const { return range_ * (left_ * z); }

VectorXd DescriptorFlow::impulses(const VectorXd& before, const VectorXd& after) const {
  VectorXd right(2 * e_.rows());
  right << VectorXd::Zero(e_.rows()), e_ * (after - before);
  return impulse_ * right;
}

MatrixXd DescriptorFlow::propagator(double time) const { return range_ * exponential(rates_ * time) * left_; }

VectorXd DescriptorFlow::after(const VectorXd& z, double time) const { return propagator(time) * z; }

}  // namespace bgsim::test
