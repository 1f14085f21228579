// The only source that includes Ceres and NLopt: their headers (with glog's and gflags') take most of its compile time.
#include "fit/solver.hpp"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <stdexcept>

#include "fit/fit_statistics.hpp"

namespace bgsim {
namespace {

class Residuals final : public ceres::CostFunction {
 public:
  Residuals(const LeastSquares& problem, std::exception_ptr& fault) : problem_(problem), fault_(fault) {
    set_num_residuals(static_cast<int>(problem.residuals));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.start.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    if (fault_) return false;
    try {
      return problem_.evaluate(parameters[0], residuals, jacobians == nullptr ? nullptr : jacobians[0]);
    } catch (...) {
      fault_ = std::current_exception();
      return false;
    }
  }

 private:
  const LeastSquares& problem_;
  std::exception_ptr& fault_;
};

/// Ends the search once something has been thrown.
class EndOnFault final : public ceres::IterationCallback {
 public:
  explicit EndOnFault(const std::exception_ptr& fault) : fault_(fault) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return fault_ ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::exception_ptr& fault_;
};

}  // namespace

LeastSquaresSolution solve_least_squares(const LeastSquares& problem) {
  static const bool silent = [] {
    FLAGS_minloglevel = google::GLOG_FATAL;
    return true;
  }();
  static_cast<void>(silent);
  std::exception_ptr fault;
  LeastSquares rooted = problem;
  rooted.evaluate = [&](const double* x, double* residuals, double* derivatives) {
    if (!problem.evaluate(x, residuals, derivatives)) return false;
    root_of_loss(problem.loss, problem.loss_at, problem.residuals, problem.start.size(), residuals, derivatives);
    return true;
  };
  LeastSquaresSolution solution;
  solution.x = problem.start;
  ceres::Problem sum;
  sum.AddResidualBlock(new Residuals(rooted, fault), nullptr, solution.x.data());  // which Ceres deletes
  for (std::size_t j = 0; j < solution.x.size(); ++j) {
    const int at = static_cast<int>(j);
    if (std::isfinite(problem.lower[j])) sum.SetParameterLowerBound(solution.x.data(), at, problem.lower[j]);
    if (std::isfinite(problem.upper[j])) sum.SetParameterUpperBound(solution.x.data(), at, problem.upper[j]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = static_cast<int>(std::min<std::uint64_t>(problem.iterations, 1000000));
  options.num_threads = 1;  // evaluate() has its own
  options.logging_type = ceres::SILENT;
  // Until the digits are used up: a cost that changes by 1e-14 of itself is a change of the variables by 1e-7 standard
  // errors. The gradient says nothing by itself, since its size is the residuals'.
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-13;
  options.gradient_tolerance = 1e-30;
  options.max_num_consecutive_invalid_steps = 20;  // runs that fail: the step is made smaller
  EndOnFault end(fault);
  options.callbacks.push_back(&end);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &sum, &summary);
  if (fault) std::rethrow_exception(fault);
  solution.iterations = static_cast<std::uint64_t>(std::max<std::size_t>(summary.iterations.size(), 1) - 1);
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.stopped = solution.converged                                  ? "converged"
                     : summary.termination_type == ceres::NO_CONVERGENCE ? "the limit of iterations was reached"
                                                                         : "no step from the last point succeeds";
  return solution;
}

namespace {

struct Search {
  const std::function<double(const std::vector<double>&)>& cost;
  std::exception_ptr fault;
  nlopt_opt optimizer = nullptr;
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
};

double cost_of(unsigned n, const double* x, double* /*gradient*/, void* data) {
  auto& search = *static_cast<Search*>(data);
  constexpr double kNone = 1e300;  // DIRECT compares costs
  if (search.fault) return kNone;
  try {
    const std::vector<double> point(x, x + n);
    const double cost = search.cost(point);
    if (cost < search.least) {
      search.least = cost;
      search.best = point;
    }
    return std::isfinite(cost) ? cost : kNone;
  } catch (...) {
    search.fault = std::current_exception();
    nlopt_force_stop(search.optimizer);
    return kNone;
  }
}

}  // namespace

std::vector<double> search_everywhere(const std::vector<double>& lower, const std::vector<double>& upper,
                                      std::uint64_t points,
                                      const std::function<double(const std::vector<double>&)>& cost) {
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimizer(
      nlopt_create(NLOPT_GN_DIRECT, static_cast<unsigned>(lower.size())), nlopt_destroy);
  if (!optimizer) throw std::bad_alloc();
  Search search{cost, {}, optimizer.get(), {}};
  nlopt_set_lower_bounds(optimizer.get(), lower.data());
  nlopt_set_upper_bounds(optimizer.get(), upper.data());
  nlopt_set_maxeval(optimizer.get(), static_cast<int>(std::min<std::uint64_t>(points, 100000000)));
  nlopt_set_min_objective(optimizer.get(), cost_of, &search);
  std::vector<double> x(lower.size());
  for (std::size_t j = 0; j < x.size(); ++j) x[j] = 0.5 * (lower[j] + upper[j]);
  double least = 0.0;
  nlopt_optimize(optimizer.get(), x.data(), &least);
  if (search.fault) std::rethrow_exception(search.fault);
  return search.best;  // empty if no point has a cost
}

}  // namespace bgsim
