// The run of a model without states.
#include "run/run.hpp"

namespace bgsim {

/// A model without states: its outputs on the grid.
bool Run::follow_grid() {
  result_.report.method = "none (no states)";
  result_.report.method_reason = "nothing is stored";
  const auto evaluate = [this](double t, Branch& branch) { return evaluator_.initialize_modes(t, x_.data(), branch); };
  const auto reach = [&](double t) {
    const double from = t_;
    while (t_ < t) {
      const double to = evaluator_.next_time_event(t_, t).value_or(t);
      // Between two rows there may be any number of known times. (An ended search knows none: nothing of it is taken.)
      if (!goes_on()) {
        static_cast<void>(evaluate(t_, branch_));  // for what is asked of the end
        return false;
      }
      if (to < t) ++time_events_;
      constexpr int kSmooth = 12;
      const auto solution = [&](double at, double*, Branch& branch) { evaluate(at, branch); };
      audit_.add(to, kSmooth, branch_, solution);
      measures_.add(to, kSmooth, branch_, solution);
      t_ = to;
      if (!log_->wanted()) continue;
      if (!evaluate(to, branch_)) return fail_with_fault();
      log_->look(to, branch_);
      if (auto full = log_->full(to)) return fail(std::move(*full));
    }
    if (auto jump = continuity_.between(from, t, evaluate)) return fail(std::move(*jump));
    return evaluate(t, branch_) || fail_with_fault();
  };
  for (std::size_t i = 0; i < inputs_.output_times.size(); ++i)
    if (!reach(inputs_.output_times[i]) || !emit_here() || !goes_on()) return false;
  return t_ >= inputs_.stop || reach(inputs_.stop);
}

}  // namespace bgsim
