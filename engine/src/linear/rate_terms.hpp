/// Of what size the terms are that a rate is the sum of, at one point and by nothing but that point.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// A number is nothing beside the terms that it is what is left of: the residual of a steady state is its rates over
/// theirs. Sums have the sizes of their terms added up, other functions those of their arguments, by their slopes. The
/// variable of a loop has at least the size that the terms in the loop's equations can make it: a flow that vanishes
/// because two pressures are equal is nothing beside what one of them would make flow.
class RateTerms {
 public:
  RateTerms(const Model& model, const BondGraph& graph, const EquationSystem& system, const BlockOrder& order,
            std::span<const double> parameters, double t);

  /// Takes a point.
  /// @param tears  what solves the loops there
  void set(const Eigen::VectorXd& x, std::span<const double> tears);
  /// By state.
  /// @param sizes  of the states: no less than their magnitudes
  [[nodiscard]] Eigen::VectorXd of_rates(const Eigen::VectorXd& sizes);
  /// After of_rates(): the rates of the dependent stores over their terms. They are what the junctions leave for them,
  /// and not how their laws follow the states: where charge runs away, u = (1 + 3 q^2) q', rounding leaves nothing of
  /// q', and 3 q^2 times nothing of the other store's, which takes all; and at a fold it moves where no state does.
  /// Where time alone moves a store, as at a source, which is held, its law is taken.
  /// @return by EquationSystem::dependent; infinite where the loops do not say.
  [[nodiscard]] std::vector<double> dependents(const Eigen::VectorXd& rates, const Eigen::VectorXd& terms);
  /// By EquationSystem::dependent, as dependents() found them.
  [[nodiscard]] const std::vector<double>& dependent_rates() const { return dependent_rates_; }

 private:
  struct Sized {
    double value = 0.0, size = 0.0;
  };
  struct Partial {
    std::size_t row = 0, column = 0;  ///< column: of the block's own tears; or of states, all tears, time
    ExprId slope;
  };
  struct Loop {
    std::size_t first = 0, count = 0;  ///< tears
    bool linear = false;
    std::vector<ExprId> residuals;
    std::vector<Partial> own, others;  ///< others: by states, earlier tears and time, where there are dependent stores
  };
  /// A dependent store: what it holds, and its port's rate as the junctions give it, if any equation needs it.
  struct Dependent {
    ExprId stored, rate;
    double sign = 1.0;
  };
  void set_symbol(SymbolId symbol, double value, double size);
  Sized at(ExprId root);
  [[nodiscard]] Sized computed(const ExprNode& node) const;
  void size_loop(const Loop& loop);
  [[nodiscard]] Eigen::MatrixXd own_slopes(const Loop& loop, bool sizes);
  void follow(std::vector<double>& moves);
  [[nodiscard]] std::vector<double> laws_follow(const std::vector<double>& moves);

  ExprPool pool_;
  std::vector<SymbolId> states_, tears_;
  std::vector<ExprId> rates_;
  std::vector<Loop> loops_;
  std::vector<Dependent> dependent_;
  std::vector<Partial> by_columns_;  ///< of what these hold: by states, then tears, then time
  std::vector<Sized> symbols_;       ///< by SymbolId
  std::vector<Sized> known_;         ///< by ExprId
  std::vector<std::uint64_t> known_since_;
  std::uint64_t now_ = 1;  ///< counts changes of the symbols
  Eigen::VectorXd x_, sizes_;
  std::vector<double> z_;
  std::vector<double> dependent_rates_;
};

}  // namespace bgsim
