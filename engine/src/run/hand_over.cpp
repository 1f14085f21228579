// From one program of a model to another one: what stores hold is the same in both.
#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "run/run.hpp"

namespace bgsim {

namespace {

auto key_of(const RunInputs::Initial& value) { return std::tuple(value.element, value.port, value.signal); }
auto key_of(const StateInfo& state) { return std::tuple(state.element, state.port, state.signal); }

void sort_by_key(std::vector<RunInputs::Initial>& values) {
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return key_of(a) < key_of(b); });
}

}  // namespace

Stored Run::stored() {
  Stored stored{t_, {}};
  if (between_ || x_.size() != program_.states.size()) return stored;
  const auto add = [&stored](const StateInfo& state, double value) {
    stored.values.push_back({state.element, state.port, value, state.place, state.signal});
  };
  for (std::size_t i = 0; i < x_.size(); ++i) add(program_.states[i], x_[i]);
  std::vector<double> dependent(program_.dependent.size());
  Branch branch = branch_;
  if (!dependent.empty() && evaluator_.dependents(t_, x_.data(), branch, dependent.data()))
    for (std::size_t i = 0; i < dependent.size(); ++i) add(program_.dependent[i], dependent[i]);
  sort_by_key(stored.values);
  return stored;
}

RunInputs continued(const RunInputs& inputs, const Stored& stored, std::size_t recorded, const Program& to) {
  RunInputs rest = inputs;
  rest.start = stored.t;
  rest.output_times = inputs.output_times.without_first(recorded);
  rest.initial.clear();
  for (std::size_t i = 0; i < to.states.size(); ++i) {
    const auto key = key_of(to.states[i]);
    const auto found =
        std::lower_bound(stored.values.begin(), stored.values.end(), key,
                         [](const RunInputs::Initial& value, const auto& k) { return key_of(value) < k; });
    if (found == stored.values.end() || key_of(*found) != key)
      throw std::invalid_argument("nothing is known of the state " + to.state_names[i]);
    rest.initial.push_back(*found);
  }
  sort_by_key(rest.initial);
  return rest;
}

}  // namespace bgsim
