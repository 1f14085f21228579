#include "run/integrate/sundials_integrator.hpp"

#include <algorithm>

namespace bgsim {

SundialsObjects::SundialsObjects(const Program& program, Evaluator& evaluator, Tolerances& tolerances, double span,
                                 std::size_t size, const Sparsity& pattern)
    : Integrator(span),
      program_(program),
      evaluator_(evaluator),
      tolerances_(tolerances),
      context_(make_context()),
      y_(make_vector(context_.get(), size)),
      scratch_(make_vector(context_.get(), size)),
      entries_(pattern.row.size()),
      algebra_(size <= kDenseStates ? make_dense(context_.get(), y_.get())
                                    : make_sparse(context_.get(), y_.get(), pattern)),
      border_(size, pattern.row.size()) {
  size_ = size;
}

void SundialsObjects::note_fault(double t) {
  last_fault_ = evaluator_.fault();
  last_fault_.time = t;
}

int SundialsObjects::recoverable(double t) {
  faulted_ = true;
  note_fault(t);
  return 1;
}

bool SundialsObjects::limit_is_at_hand() const {
  const double resolution = 4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(time_), std::abs(limit_));
  return (limit_ - time_ <= resolution || is_nothing(limit_ - time_)) && time_ == previous_;
}

void SundialsObjects::moved_to_limit() {
  previous_ = time_;
  time_ = limit_;
  order_ = 1;
  by_hand_ = true;
}

}  // namespace bgsim
