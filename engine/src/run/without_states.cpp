// The run of a model without states.
#include "run/run.hpp"

namespace bgsim {

/// A model without states: its outputs on the grid.
bool Run::follow_grid() {
  result_.report.method = "none (no states)";
  result_.report.method_reason = "nothing is stored";
  double reached = inputs_.start;
  const auto evaluate = [this](double t, Branch& branch) { return evaluator_.initialize_modes(t, x_.data(), branch); };
  const auto reach = [&](double t) {
    while (reached < t) {
      const double to = evaluator_.next_time_event(reached, t).value_or(t);
      if (to < t) ++time_events_;
      constexpr int kSmooth = 12;
      const auto solution = [&](double at, double*, Branch& branch) { evaluate(at, branch); };
      audit_.add(to, kSmooth, branch_, solution);
      measures_.add(to, kSmooth, branch_, solution);
      reached = to;
      if (!log_->wanted()) continue;
      if (!evaluate(to, branch_)) return fail_with_fault();
      log_->look(to, branch_);
      if (auto full = log_->full(to)) return fail(std::move(*full));
    }
    if (auto jump = continuity_.between(t_, t, evaluate)) return fail(std::move(*jump));
    t_ = t;
    return evaluate(t, branch_) || fail_with_fault();
  };
  for (std::size_t i = 0; i < inputs_.output_times.size(); ++i)
    if (!reach(inputs_.output_times[i]) || !emit_here() || !goes_on()) return false;
  return t_ >= inputs_.stop || reach(inputs_.stop);
}

}  // namespace bgsim
