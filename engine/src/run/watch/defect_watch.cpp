#include "run/watch/defect_watch.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

DefectWatch::DefectWatch(const Program& program, const RunInputs& inputs, Evaluator& evaluator,
                         const Tolerances& tolerances)
    : program_(program),
      evaluator_(evaluator),
      fixed_(facts_of(inputs.method).fixed_step()),
      laws_(program, inputs.parameters) {
  step_.states = program.state_names.size();
  step_.relative = inputs.relative;
  step_.fixed = fixed_;
  step_.at = [this](double t, double* y) { integrator_->interpolate(t, y); };
  step_.rates = [this](double t, const double* y, double* rates, double* tears) {
    if (branch_.given) std::copy_n(y + step_.states, branch_.tears.size(), branch_.tears.begin());
    if (!evaluator_.rates(t, y, branch_, rates)) return false;
    std::copy(branch_.tears.begin(), branch_.tears.end(), tears);
    return true;
  };
  step_.tolerance = [this, &tolerances](std::size_t i) {
    const double known = step_.relative * std::fabs(step_.ends.states_at_begin[i]) + tolerances.resolved(i);
    // One that was 0 until this step has no other size than the one it gets there.
    return known > 0.0 ? known : step_.relative * std::fabs(step_.ends.states_at_end[i]);
  };
}

bool DefectWatch::look(Integrator& integrator, const StepEnds& ends, double until, bool event) {
  constexpr int kMostTimes = 20;
  const double t = integrator.previous();
  if (cut_ && *cut_ <= t) cut_.reset();
  if (!event && !laws_.any()) return true;
  if (t > refused_at_) refused_ = 0;
  refused_at_ = t;
  integrator_ = &integrator;
  step_.ends = ends;
  branch_ = integrator.branch();
  if (modes_ != branch_.modes) {
    modes_ = branch_.modes;
    laws_.set_modes(modes_);
  }
  step_.begin = t;
  step_.end = integrator.time();
  step_.degree = integrator.order();
  step_.unknowns = integrator.size();
  const SharpLaws::Verdict verdict = laws_.look(step_, until);
  std::optional<double> shorter = verdict.shorter;
  const bool beyond = !shorter && event && !laws_.holds_until(step_, until);
  if (beyond) shorter = until - t;
  if (!shorter) {
    if (verdict.undecided) leave(verdict.state, t);
    return true;
  }
  if (++refused_ > kMostTimes) {
    leave(verdict.state, t);
    return true;
  }
  if (beyond || fixed_)
    cut_ = t + *shorter;
  else
    integrator.begin_with(*shorter);
  return false;
}

void DefectWatch::leave(std::size_t state, double t) {
  if (!unseen_state_.empty()) return;
  unseen_state_.push_back(state);
  unseen_time_ = t;
}

}  // namespace bgsim
