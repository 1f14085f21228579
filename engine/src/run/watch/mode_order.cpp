#include "run/watch/mode_order.hpp"

#include <algorithm>

#include "run/integrate/integrator.hpp"

namespace bgsim {

ModeOrder::ModeOrder(const Program& program, Evaluator& evaluator, const RunInputs& inputs)
    : program_(program),
      evaluator_(evaluator),
      span_(inputs.stop - inputs.start),
      possible_((inputs.method == Method::automatic || inputs.method == Method::bdf) && program.plan.explicit_form &&
                inputs.max_order == 0 && program.state_names.size() <= kDenseStates) {}

bool ModeOrder::look(double t, const double* x, const Branch& branch, std::uint64_t steps) {
  constexpr std::uint64_t kFirst = 100, kMostBetween = 1000;
  const std::uint64_t since = steps - looked_at_step_;
  if (since < std::clamp(looked_at_step_, kFirst, kMostBetween)) return false;
  const double step = (t - looked_at_time_) / static_cast<double>(since);
  looked_at_step_ = steps;
  looked_at_time_ = t;
  if (!possible_) return false;
  const auto spent = spent_mode(program_, evaluator_, t, x, branch, span_, step);
  if (!spent || (spent_ && spent_->order <= spent->order)) return false;
  spent_ = spent;
  return true;
}

}  // namespace bgsim
