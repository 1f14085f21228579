/// Linear descriptor systems E z' = A z by themselves: consistent states and their exact flow, from the spectral
/// decomposition of the pencil. Nothing of the engine is in it.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace bgsim::test {

/// The flow of a regular pencil. With m = (l E - A)^-1 E, whose nonzero eigenvalues are 1/(l - s) of the finite ones s
/// of the pencil, the space is the direct sum of range and null space of a power of m (Wong sequences): solutions lie
/// in the range, and an inconsistent state jumps there along the null space, which conserves E z up to impulses of what
/// has no derivative (Dai, Singular Control Systems, 1989, 1.4).
class DescriptorFlow {
 public:
  /// None if the pencil is singular, or nearly.
  static std::optional<DescriptorFlow> of(const Eigen::MatrixXd& e, const Eigen::MatrixXd& a);

  /// The consistent state that @p z jumps to.
  [[nodiscard]] Eigen::VectorXd consistent(const Eigen::VectorXd& z) const;
  /// Impulses of the algebraic variables in a jump from @p before to @p after: E Z = 0, A Z = E (after - before).
  [[nodiscard]] Eigen::VectorXd impulses(const Eigen::VectorXd& before, const Eigen::VectorXd& after) const;
  /// The state a time after a consistent one.
  [[nodiscard]] Eigen::VectorXd after(const Eigen::VectorXd& z, double time) const;
  /// The same for a time that comes again and again: z |-> (propagator) z.
  [[nodiscard]] Eigen::MatrixXd propagator(double time) const;

 private:
  Eigen::MatrixXd e_, a_;
  Eigen::MatrixXd range_, left_;  ///< z = range_ (left_ z) for consistent z; left_ null space = 0
  Eigen::MatrixXd rates_;         ///< of the coordinates left_ z
  Eigen::MatrixXd impulse_;       ///< least squares of [E; A]
};

}  // namespace bgsim::test
