// What the outputs of a switched run are wrong by: the estimate goes on from mode to mode. Beside the run the exact
// solution, as the estimate has it, comes to the same change of the mode at its own time, and jumps there.
#include "run/switched_run.hpp"

namespace bgsim {

void SwitchedRun::lose_errors(const std::string& why, bool possible) {
  if (!std::exchange(estimates_, false)) return;
  errors_.reset();
  result_.report.errors = {};
  result_.report.errors.possible = possible;
  result_.report.errors.why_not = why;
}

void SwitchedRun::jump_exactly(Evaluator& evaluator) {
  if (!errors_) return;
  Jump jump = jump_into(evaluator, errors_->exact.t, errors_->exact);
  if (jump.failure)
    return lose_errors("the jump at t = " + number_text(stored_.t, 6) + " could not be evaluated", true);
  exact_ = std::move(jump.x);
}

void SwitchedRun::store_exactly(Evaluator& evaluator) {
  if (!errors_) return;
  const Program& program = evaluator.program();
  const double t = errors_->exact.t;
  Branch branch = first_branch(program);
  std::vector<double> dependent(program.dependent.size());
  if (!evaluator.initialize_modes(t, exact_.data(), branch) ||
      !evaluator.dependents(t, exact_.data(), branch, dependent.data()))
    return lose_errors("the jump at t = " + number_text(stored_.t, 6) + " could not be evaluated", true);
  put_stored(errors_->exact, program, exact_, dependent);
}

void SwitchedRun::hand_errors(const Program& program, Run& run) {
  if (!errors_) return;
  std::vector<double> error(x_.size()), rates(x_.size(), 0.0);
  if (errors_->late != 0.0) {
    Evaluator& evaluator = evaluators_.of(program, parameters_);
    Branch branch = first_branch(program);
    if (!evaluator.initialize_modes(stored_.t, x_.data(), branch) ||
        !evaluator.rates(stored_.t, x_.data(), branch, rates.data()))
      return lose_errors("the rates at t = " + number_text(stored_.t, 6) + " could not be evaluated", true);
  }
  for (std::size_t i = 0; i < x_.size(); ++i) error[i] = x_[i] - exact_[i] + errors_->late * rates[i];
  run.know_errors(std::move(*errors_), std::move(error));
}

void SwitchedRun::take_errors(const Program& program, Run& run, const RunResult& part) {
  if (!estimates_) return;
  const bool contacts = std::any_of(program.model->elements.begin(), program.model->elements.end(),
                                    [](const Element& element) { return element.contact.has_value(); });
  if (contacts) return lose_errors("the model has contacts", false);
  errors_ = run.errors();
  if (!errors_) return lose_errors(part.report.errors.why_not, part.report.errors.possible);
  if (errors_->exact.values.size() != program.states.size() + program.dependent.size())
    return lose_errors("what the stores hold at t = " + number_text(stored_.t, 6) + " could not be evaluated", true);
  if (has_only_clock(program))
    std::erase_if(errors_->exact.values,
                  [&](const auto& value) { return value.signal == program.states.front().signal; });
}

}  // namespace bgsim
