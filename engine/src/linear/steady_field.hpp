/// The rates of a model as functions of its states, sources held at their values at one time.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <optional>
#include <vector>

#include "bgsim/linear.hpp"
#include "linear/rate_terms.hpp"

namespace bgsim {

/// x' = f(x) at a fixed time.
class SteadyField {
 public:
  using Vector = Eigen::VectorXd;
  using Rates = Eigen::SparseMatrix<double>;

  SteadyField(const std::shared_ptr<const Model>& model, const RunInputs& scene);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(program_.states.size()); }
  [[nodiscard]] const Program& program() const { return program_; }
  Evaluator& evaluator() { return *evaluator_; }

  /// False where a law has no value.
  bool rates(const Vector& x, Vector& f);
  /// Partials, and by state the magnitude of the terms of its rate.
  bool slopes(const Vector& x, const Vector& f, Rates& jacobian, Vector& terms);
  /// Takes a point at which rates() have just been found; null where what dependent stores hold has no value.
  RateTerms* terms_at(const Vector& x);

  [[nodiscard]] Fault fault() const { return evaluator_->fault(); }
  void restart() { branch_ = first_branch(program_); }

  std::vector<RunInputs::Initial> stored(const Vector& x, const Vector& errors);

 private:
  std::vector<double> parameters_;
  double t_;
  EquationSystem system_;
  Program program_;
  std::optional<RateTerms> terms_;
  std::optional<Evaluator> evaluator_;
  Branch branch_;
};

/// (shift - J) dx = f, rows and columns of like magnitude; false if that is singular.
/// @param size  by state: a magnitude
bool solve_shifted(const Eigen::SparseMatrix<double>& jacobian, double shift, const Eigen::VectorXd& f,
                   const Eigen::VectorXd& size, Eigen::VectorXd& dx);

}  // namespace bgsim
