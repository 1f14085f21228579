// From one program of a model to another one: what stores hold is the same in both.
#include <algorithm>
#include <stdexcept>

#include "bgsim/text.hpp"
#include "run/run.hpp"
#include "run/stored.hpp"

namespace bgsim {

Stored Run::stored() {
  if (between_ || x_.size() != program_.states.size()) return {t_, {}};
  return stored_at(t_, x_);
}

Stored Run::stored_at(double t, const std::vector<double>& x) {
  Stored stored{t, {}};
  const auto add = [&stored](const StateInfo& state, double value) {
    stored.values.push_back({state.element, state.port, value, state.place, state.signal});
  };
  for (std::size_t i = 0; i < x.size(); ++i) add(program_.states[i], x[i]);
  std::vector<double> dependent(program_.dependent.size());
  Branch branch = branch_;
  if (!dependent.empty() && evaluator_.dependents(t, x.data(), branch, dependent.data()))
    for (std::size_t i = 0; i < dependent.size(); ++i) add(program_.dependent[i], dependent[i]);
  sort_stored(stored.values);
  return stored;
}

void Run::know_errors(ErrorMemory memory, std::vector<double> error) {
  errors_.go_on(std::move(memory.sums), std::move(error));
}

std::optional<ErrorMemory> Run::errors() {
  if (!errors_.measuring()) return std::nullopt;
  const GlobalError::Instant& instant = errors_.leave(t_, x_);
  return ErrorMemory{errors_.sums(), instant.late, stored_at(t_ + instant.late, instant.exact)};
}

RunInputs continued(const RunInputs& inputs, const Stored& stored, std::size_t recorded, const Program& to) {
  RunInputs rest = inputs;
  rest.start = stored.t;
  rest.output_times = inputs.output_times.without_first(recorded);
  if (!rest.output_times.empty() && rest.output_times.front() < stored.t)
    throw std::invalid_argument(
        "the next output time, " + number_text(rest.output_times.front()) + ", is before the time " +
        number_text(stored.t) +
        " from which the run is continued: the rows that are recorded are those of other times");
  rest.initial.clear();
  for (std::size_t i = 0; i < to.states.size(); ++i) {
    const auto key = stored_key(to.states[i]);
    const auto found =
        std::lower_bound(stored.values.begin(), stored.values.end(), key,
                         [](const RunInputs::Initial& value, const auto& k) { return stored_key(value) < k; });
    if (found == stored.values.end() || stored_key(*found) != key)
      throw std::invalid_argument("nothing is known of the state " + to.state_names[i]);
    rest.initial.push_back(*found);
  }
  sort_stored(rest.initial);
  return rest;
}

}  // namespace bgsim
