#include "run/jump.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/codes.hpp"
#include "base/lu.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"

namespace bgsim {
namespace {

constexpr double kAlone = 1e-9;  ///< a smaller part of a store's content than this has not jumped

/// Solves x = x- + W (phi(x) - d-), where phi are the dependent stores' values that the states x determine.
class Projection {
 public:
  Projection(Evaluator& evaluator, double t, const Stored& before)
      : program_(evaluator.program()), evaluator_(evaluator), t_(t), branch_(first_branch(program_)) {
    for (const StateInfo& state : program_.states) before_.push_back(value_of(before, state));
    for (const StateInfo& store : program_.dependent) dependent_before_.push_back(value_of(before, store));
    x_.assign(before_.begin(), before_.end());
    dependent_.resize(dependent_before_.size());
    const std::size_t ports = program_.jump.routine.results.size() - program_.jump.terms.size();
    factors_.resize(program_.jump.terms.size() + ports);
  }

  bool run(Jump& jump) {
    if (program_.dependent.empty()) return finish(jump);
    if (!evaluate() || !evaluator_.jump(t_, x_.data(), branch_, factors_.data())) return fault(jump);
    const std::size_t n = x_.size(), m = dependent_.size();
    Eigen::MatrixXd w = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(m));
    for (std::size_t k = 0; k < program_.jump.terms.size(); ++k)
      w(program_.jump.terms[k].state, program_.jump.terms[k].dependent) = factors_[k];
    if (!solve(w, jump)) return false;
    for (std::size_t d = 0; d < m; ++d) {
      const double apart = std::abs(dependent_[d] - dependent_before_[d]);
      const double size = std::max(std::abs(dependent_[d]), std::abs(dependent_before_[d]));
      if (!(apart > kAlone * size)) continue;
      if (!(w.col(static_cast<Eigen::Index>(d)).array().abs() > 0.0).any())
        jump.lone.push_back({program_.dependent_names[d], program_.dependent[d], dependent_before_[d], dependent_[d]});
    }
    return finish(jump);
  }

 private:
  bool evaluate() {
    return evaluator_.initialize_modes(t_, x_.data(), branch_) &&
           evaluator_.dependents(t_, x_.data(), branch_, dependent_.data());
  }

  static bool fail(Jump& jump, Diagnostic diagnostic) {
    jump.failure = std::move(diagnostic);
    return false;
  }
  bool fault(Jump& jump) { return fail(jump, fault_failure(evaluator_.fault())); }

  /// Newton's iteration; with linear stores its first step is exact.
  bool solve(const Eigen::MatrixXd& w, Jump& jump) {
    constexpr int kMostSteps = 100, kRoundedAfter = 3;
    constexpr double kConverged = 1e-13, kGood = 1e-9;
    const auto n = static_cast<Eigen::Index>(x_.size()), m = static_cast<Eigen::Index>(dependent_.size());
    if (n == 0) return true;
    const bool coupled = (w.array().abs() > 0.0).any();
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kMostSteps; ++step) {
      Eigen::VectorXd residual(n), size(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        residual[i] = x_[static_cast<std::size_t>(i)] - before_[static_cast<std::size_t>(i)];
        size[i] = std::abs(x_[static_cast<std::size_t>(i)]) + std::abs(before_[static_cast<std::size_t>(i)]);
        for (Eigen::Index d = 0; d < m; ++d) {
          const auto at = static_cast<std::size_t>(d);
          residual[i] -= w(i, d) * (dependent_[at] - dependent_before_[at]);
          size[i] += std::abs(w(i, d)) * (std::abs(dependent_[at]) + std::abs(dependent_before_[at]));
        }
      }
      const std::vector<double> dependent = dependent_;
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(n, n);
      for (Eigen::Index i = 0; i < n && coupled; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const double x = x_[at];
        const double delta = size[i] > 0.0 ? std::max(kShake * size[i], kOfOthers * size.maxCoeff()) : kShake;
        x_[at] = x + delta;
        const double moved = x_[at] - x;
        const bool known = evaluate();
        x_[at] = x;
        if (!known) return fault(jump);
        for (Eigen::Index d = 0; d < m; ++d) {
          const auto k = static_cast<std::size_t>(d);
          jacobian.col(i) -= w.col(d) * ((dependent_[k] - dependent[k]) / moved);
        }
      }
      const Eigen::VectorXd change = coupled ? solve_with_full_pivots(jacobian, residual) : residual;
      double relative = 0.0;
      for (Eigen::Index i = 0; i < n; ++i) {
        x_[static_cast<std::size_t>(i)] -= change[i];
        if (size[i] > 0.0) relative = std::max(relative, std::abs(change[i]) / size[i]);
        if (!std::isfinite(change[i])) relative = std::numeric_limits<double>::infinity();
      }
      if (!evaluate()) return fault(jump);
      if (relative <= kConverged || (relative <= kGood && relative >= last)) return true;
      if (step >= kRoundedAfter && only_rounding(w, change)) return true;
      last = relative;
    }
    return fail(jump, no_jump_failure("the stores' laws have no common solution that was found", t_));
  }

  /// Whether a change is what rounding makes of the dependent stores: a store that is nearly empty, beside one that is
  /// the difference of large efforts, comes no nearer.
  bool only_rounding(const Eigen::MatrixXd& w, const Eigen::VectorXd& change) {
    constexpr double kUnit = std::numeric_limits<double>::epsilon(), kTimes = 64.0;
    std::vector<double> off(x_.size()), bounds(dependent_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) off[i] = kUnit * std::abs(x_[i]);
    evaluator_.dependent_rounding(t_, x_.data(), branch_, off, {}, bounds.data());
    for (Eigen::Index i = 0; i < change.size(); ++i) {
      double noise = off[static_cast<std::size_t>(i)];
      for (Eigen::Index d = 0; d < w.cols(); ++d) noise += std::abs(w(i, d)) * bounds[static_cast<std::size_t>(d)];
      if (!(std::abs(change[i]) <= kTimes * noise) || !std::isfinite(noise)) return false;
    }
    return true;
  }

  /// Energies of the instant.
  bool finish(Jump& jump) {
    jump.x = x_;
    jump.moved = x_ != before_ || dependent_ != dependent_before_;
    if (!jump.moved || program_.energy_roles.empty()) return true;
    const std::size_t terms = program_.jump.terms.size();
    if (!evaluator_.initialize_modes(t_, x_.data(), branch_) ||
        !evaluator_.jump(t_, x_.data(), branch_, factors_.data()))
      return fault(jump);
    std::size_t port = terms;
    for (std::size_t part = 0; part < program_.energy_roles.size(); ++part) {
      if (program_.energy_roles[part] != EnergyPart::Role::store) continue;
      const std::size_t count = program_.first_displacement[part + 1] - program_.first_displacement[part];
      std::vector<double> from(count), to(count);
      double work = 0.0;
      bool still = true;
      for (std::size_t k = 0; k < count; ++k, ++port) {
        contents(program_.energy_elements[part], static_cast<std::uint32_t>(k), from[k], to[k]);
        const double at_port = factors_[port] * (to[k] - from[k]);
        work += at_port;
        jump.scale += std::abs(at_port);  // of windings that are closely coupled much more than all of them
        still = still && from[k] == to[k];
      }
      if (still) continue;
      jump.supplied += work;
      const double energy = program_.energy_modulated[part] ? std::numeric_limits<double>::quiet_NaN()
                                                            : evaluator_.energy_by_laws(part, from, to);
      (std::isnan(energy) ? jump.exchanged : jump.stored) += std::isnan(energy) ? work : energy;
      if (!std::isnan(energy)) jump.scale += std::abs(energy);
    }
    jump.loss = jump.supplied - jump.stored - jump.exchanged;
    return true;
  }

  /// What a port of a store held, and holds.
  void contents(ElementId element, std::uint32_t port, double& from, double& to) const {
    for (std::size_t i = 0; i < x_.size(); ++i)
      if (program_.states[i].element == element && program_.states[i].port == port) {
        from = before_[i];
        to = x_[i];
      }
    for (std::size_t i = 0; i < dependent_.size(); ++i)
      if (program_.dependent[i].element == element && program_.dependent[i].port == port) {
        from = dependent_before_[i];
        to = dependent_[i];
      }
  }

  /// Of a store's content: far enough for differences, near enough for nonlinear laws.
  static constexpr double kShake = 1e-4;
  /// Of the largest content: a store that is nearly empty beside others is moved so far that these show it.
  static constexpr double kOfOthers = 1e-12;

  const Program& program_;
  Evaluator& evaluator_;
  double t_;
  Branch branch_;
  std::vector<double> before_, dependent_before_, x_, dependent_, factors_;
};

}  // namespace

Diagnostic no_jump_failure(const std::string& why, double t) {
  return diagnostic_of(
      "BG620",
      "what the stores hold after the switches change at t = " + number_text(t) + " could not be found: " + why, {},
      "stores that a switch ties to each other conserve charge and momentum",
      "see which stores depend on others in this mode: bgsim check --mode");
}

double value_of(const Stored& stored, const StateInfo& state) {
  const auto key = std::tuple(state.element, state.port, state.signal);
  const auto found = std::lower_bound(stored.values.begin(), stored.values.end(), key,
                                      [](const RunInputs::Initial& value, const auto& k) {
                                        return std::tuple(value.element, value.port, value.signal) < k;
                                      });
  const bool known = found != stored.values.end() && std::tuple(found->element, found->port, found->signal) == key;
  return known ? found->value : 0.0;
}

Jump jump_into(Evaluator& evaluator, double t, const Stored& before) {
  Jump jump;
  Projection(evaluator, t, before).run(jump);
  return jump;
}

}  // namespace bgsim
