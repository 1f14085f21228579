/// What rounding makes of residuals, for integrators whose unknowns are the states and the loops' variables.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

class ResidualRounding {
 public:
  ResidualRounding(const Program& program, Evaluator& evaluator, Tolerances& tolerances)
      : program_(program), evaluator_(evaluator), tolerances_(tolerances), needed_(program.blocks.size(), false) {
    for (const std::uint32_t block : program.rates.solves) needed_[block] = true;
  }

  /// Shows it to the tolerances, with the loops eliminated where that can be done, so that errors of their variables
  /// that cancel do.
  /// @param y        states and loops' variables at @p t; @param rate  of both
  /// @param entries  of the residuals' Jacobian there, by Program::implicit_pattern; signs do not matter
  void show(double t, const double* y, const Branch& branch, const double* rate, const double* entries) {
    const auto residual = [&](double at, const double* x, double* r) {
      return evaluator_.residual(at, x, branch, rate, r);
    };
    if (program_.plan.explicit_form) {
      inside_ = branch;
      std::copy_n(y + program_.state_names.size(), inside_.tears.size(), inside_.tears.begin());
      inside_.given = false;
      entries_.resize(program_.jacobian_pattern.row.size());
      if (evaluator_.jacobian(t, y, inside_, entries_.data(), rounding_) && !rounding_.empty()) {
        tolerances_.see({t, y, program_.jacobian_pattern, entries_.data(), rounding_, rate}, residual);
        return;
      }
    }
    rounding_.clear();
    tolerances_.see({t, y, program_.implicit_pattern, entries, rounding_, rate}, residual);
  }

  /// Shows what it makes of the loops' variables: by bounds, or by solving the loops for states that are a rounding off
  /// where there are too many. Loops that no rate needs are not watched where outputs solve them.
  void see_loops(double t, const double* y, const Branch& branch) {
    const std::size_t tears = branch.tears.size();
    inside_ = branch;
    inside_.given = false;
    std::copy_n(y + program_.state_names.size(), tears, inside_.tears.begin());
    changes_.assign(tears, 0.0);
    if (tears <= kMostBounded)
      evaluator_.tear_rounding(t, y, inside_, changes_.data());
    else
      shake(t, y);
    for (double& change : changes_) change = std::isfinite(change) ? change : 0.0;
    for (std::size_t b = 0; program_.plan.explicit_form && b < needed_.size(); ++b)
      if (!needed_[b])
        std::fill_n(changes_.begin() + program_.blocks[b].first_tear, program_.blocks[b].size,
                    std::numeric_limits<double>::infinity());
    tolerances_.see_loops(changes_);
  }

 private:
  void shake(double t, const double* y) {
    constexpr int kSamples = 2;
    constexpr double kEps = std::numeric_limits<double>::epsilon();
    const std::size_t states = program_.state_names.size();
    rates_.resize(states);
    if (!evaluator_.rates(t, y, inside_, rates_.data())) return;
    solved_ = inside_.tears;
    shaken_.resize(states);
    for (int sample = 1; sample <= kSamples; ++sample) {
      for (std::size_t i = 0; i < states; ++i) shaken_[i] = y[i] * (1.0 + (i % 2 == 0 ? sample : -sample) * kEps);
      if (!evaluator_.rates(t, shaken_.data(), inside_, rates_.data())) return;
      for (std::size_t j = 0; j < solved_.size(); ++j)
        changes_[j] = std::max(changes_[j], std::abs(inside_.tears[j] - solved_[j]) / sample);
    }
  }

  static constexpr std::size_t kMostBounded = 64;  ///< bounds cost the square of the tears
  const Program& program_;
  Evaluator& evaluator_;
  Tolerances& tolerances_;
  std::vector<bool> needed_;  ///< by loop: rates solve it
  // Scratch
  Branch inside_;
  std::vector<double> entries_, rounding_, rates_, solved_, changes_, shaken_;
};

}  // namespace bgsim
