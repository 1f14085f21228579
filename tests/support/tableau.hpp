/// The oracle: a linear bond graph as one implicit system in all efforts, flows and stored quantities, with neither
/// causality nor sorting. Nothing here uses a stroke, a law's inverse or an order of evaluation.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

/// x' = rate_y y,  0 = law_x x + law_y y + law_u u, with x the q and p of all stores' ports in model order, y the
/// efforts and then the flows of all bonds, and u the values of all sources in model order.
struct Tableau {
  Eigen::MatrixXd rate_y, law_x, law_y, law_u;
  std::vector<PortId> stores;
  std::vector<ElementId> sources;
};

/// @param parameters  by ParameterId. Se, Sf, R, C, I, TF, GY with coefficients, junctions, and fields of stores with
/// an energy that is quadratic may occur.
Tableau form_tableau(const Model& model, const BondGraph& graph, std::span<const double> parameters);

/// What a tableau says of the motion, for constant u.
struct Motion {
  /// False if the pencil is singular: efforts or flows that nothing determines, or laws that contradict each other.
  bool regular = false;
  /// False if regular, but some constraint has to be differentiated more than once.
  bool index_two = false;
  Eigen::MatrixXd constraint_x, constraint_u;  ///< constraint_x x + constraint_u u = 0 (dependent stores)
  Eigen::MatrixXd basis;                       ///< orthonormal, of the x that obey constraint_x x = 0
  Eigen::MatrixXd rate_x, rate_u;              ///< x' = rate_x x + rate_u u
  Eigen::MatrixXd bonds_x, bonds_u;            ///< y = bonds_x x + bonds_u u

  /// The finite generalised eigenvalues.
  [[nodiscard]] Eigen::VectorXcd poles() const;
  /// x at a time, from x at time 0.
  [[nodiscard]] Eigen::VectorXd at(double time, const Eigen::VectorXd& start, const Eigen::VectorXd& u) const;
};

Motion motion_of(const Tableau& tableau);

/// The motion where some efforts and flows take part in nothing (what runs round a ring of junctions and comes out
/// nowhere): with these at zero, and the laws that repeat others left out. Of no use for a pencil that is singular for
/// other reasons.
Motion motion_without_circulation(const Tableau& tableau);

}  // namespace bgsim::test
