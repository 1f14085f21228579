#include "run/network_slopes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/unequal.hpp"
#include "run/failures.hpp"
#include "run/jump.hpp"

namespace bgsim {
NetworkSlopes::NetworkSlopes(const DiodeNetwork& network, std::vector<double> parameters, double t,
                             const Stored& stored, const std::function<double(const StateInfo&)>& resolution,
                             KeptEvaluators& evaluators)
    : network_(network),
      parameters_(std::move(parameters)),
      t_(t),
      stored_(stored),
      evaluators_(evaluators),
      n_(network.resistances.size()),
      ports_(n_ + network.borders.size()),
      states_(network.program.states.size()),
      contacts_(n_) {
  parameters_.resize(network.program.model->parameters.size(), 0.0);
  position_.resize((1 + kOrders) * ports_ + 2 * network.contacts);
  for (std::size_t i = 0; i < states_; ++i) {
    const StateInfo& state = network.program.states[i];
    resolution_.push_back(resolution(state));
    if (state.signal.valid() && state.signal.index() >= network.first_signal)
      position_[state.signal.index() - network.first_signal] = i;
  }
  std::size_t next = (1 + kOrders) * ports_;
  for (std::size_t i = 0; i < n_; ++i) {
    const SignalId displacement = network.displacements[i];
    if (!displacement.valid()) continue;
    const auto is_it = [&](const StateInfo& state) { return state.signal == displacement; };
    const auto at = std::find_if(network.program.states.begin(), network.program.states.end(), is_it);
    contacts_[i] = {next, static_cast<std::size_t>(at - network.program.states.begin())};
    next += 2;
  }
}

std::optional<Diagnostic> NetworkSlopes::look(const std::vector<double>& resistances,
                                              const std::vector<double>& sources, bool aside) {
  rates_.clear();
  for (std::size_t i = 0; i < n_; ++i) parameters_[network_.resistances[i].index()] = resistances[i];
  Evaluator& evaluator = evaluators_.of(network_.program, parameters_);
  Jump jump = jump_into(evaluator, t_, stored_);
  if (jump.failure) return jump.failure;
  x_ = std::move(jump.x);
  constexpr double kNothing = 1e-100;  // beside any effort; its square is a number still
  constexpr double kRoundings = 16.0 * std::numeric_limits<double>::epsilon();
  for (std::size_t c = 0; aside && c < states_; ++c) {
    const double part = 1.0 + unequal_part(c);
    x_[c] += part * (resolution_[c] + kRoundings * std::abs(x_[c]));
  }
  evaluator_ = &evaluator;
  std::vector<double> values(network_.program.jacobian_pattern.row.size()), rounding;
  std::optional<Fault> fault;
  for (const double side : {0.0, -1.0, 1.0}) {
    for (std::size_t i = 0; i < n_; ++i)
      x_[source(i)] = sign(i) * (sources[i] + side * (kRoundings * std::abs(sources[i]) + kNothing));
    for (std::size_t i = n_; i < ports_; ++i) x_[source(i)] = sources[i];
    if (evaluate(evaluator, values, rounding)) {
      sum_up(values, rounding);
      return std::nullopt;
    }
    if (!fault) fault = evaluator.fault();
  }
  return fault_failure(*fault);
}

bool NetworkSlopes::evaluate(Evaluator& evaluator, std::vector<double>& values, std::vector<double>& rounding) {
  branch_ = first_branch(network_.program);
  if (!evaluator.initialize_modes(t_, x_.data(), branch_)) return false;
  rates_.resize(states_);
  if (!evaluator.rates(t_, x_.data(), branch_, rates_.data())) {
    rates_.clear();
    return false;
  }
  diodes_.resize(4 * n_);
  return evaluator.slopes(t_, x_.data(), branch_, values.data(), rounding) &&
         evaluator.diodes(t_, x_.data(), branch_, diodes_.data());
}

void NetworkSlopes::sum_up(const std::vector<double>& values, const std::vector<double>& rounding) {
  const std::size_t rows = kOrders * ports_;
  // In the memory that they have: of a thousand diodes these are 24 MB.
  flows_.ports = ports_;
  flows_.slopes.assign(rows * ports_, 0.0);
  for (std::vector<double>* const list : {&flows_.at_zeros, &flows_.sizes, &flows_.offs}) list->assign(rows, 0.0);
  shifts_.clear();
  std::vector<std::size_t> row_of(states_, rows), source_of(states_, ports_);
  for (std::size_t i = 0; i < ports_; ++i) {
    source_of[source(i)] = i;
    for (std::size_t k = 0; k < kOrders; ++k) row_of[flow(i, k)] = flows_.row(i, k);
  }
  std::vector<double> linear(rows, 0.0);
  const Sparsity& pattern = network_.program.jacobian_pattern;
  for (std::size_t column = 0; column < states_; ++column)
    for (auto at = pattern.column_start[column]; at < pattern.column_start[column + 1]; ++at) {
      const std::size_t row = row_of[static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(at)])];
      if (row == rows) continue;
      const double value = values[static_cast<std::size_t>(at)];
      // A law may begin with a slope without bound, where what it is the slope of is 0.
      const double term = x_[column] == 0.0 ? 0.0 : value * x_[column];
      linear[row] += term;
      flows_.sizes[row] += std::abs(term);
      if (resolution_[column] > 0.0) shifts_.push_back({row, column, std::abs(value) * resolution_[column]});
      if (source_of[column] < ports_) {
        const std::size_t j = source_of[column];
        flows_.slopes[row * ports_ + j] = sign(row / kOrders) * sign(j) * value;
      }
    }
  for (std::size_t i = 0; i < ports_; ++i)
    for (std::size_t k = 0; k < kOrders; ++k) {
      const std::size_t row = flows_.row(i, k);
      const double value = rates_[flow(i, k)];
      // Terms that cancel need not stand in the slopes: the flow into a part that a diode alone connects is 0.
      if (!rounding.empty()) flows_.offs[row] += rounding[flow(i, k)];
      flows_.sizes[row] += std::abs(value - linear[row]);
      flows_.at_zeros[row] = sign(i) * value;
      for (std::size_t j = 0; j < ports_; ++j)
        if (x_[source(j)] != 0.0) flows_.at_zeros[row] -= flows_.slopes[row * ports_ + j] * sign(j) * x_[source(j)];
    }
}

void NetworkSlopes::bound_flows() {
  constexpr double kMatters = 1e-3;  // of the sizes of flows; below that slopes are good enough
  std::vector<double> moved = x_, moved_rates(states_);
  for (auto first = shifts_.begin(), last = first; first != shifts_.end(); first = last) {
    const std::size_t column = first->column;
    last = std::find_if(first, shifts_.end(), [column](const Shift& at) { return at.column != column; });
    const bool matters =
        std::any_of(first, last, [this](const Shift& at) { return at.by_slope > kMatters * flows_.sizes[at.row]; });
    std::vector<double> most(static_cast<std::size_t>(last - first), 0.0);
    bool known = false;
    for (const double side : {1.0, -1.0}) {
      if (!matters) break;
      moved[column] = x_[column] + side * resolution_[column];
      Branch there = branch_;
      if (!evaluator_->rates(t_, moved.data(), there, moved_rates.data())) continue;
      known = true;
      for (auto at = first; at != last; ++at) {
        const std::size_t k = flow(at->row / kOrders, at->row % kOrders);
        double& change = most[static_cast<std::size_t>(at - first)];
        change = std::max(change, std::abs(moved_rates[k] - rates_[k]));
      }
    }
    moved[column] = x_[column];
    for (auto at = first; at != last; ++at)
      flows_.offs[at->row] += known ? std::min(at->by_slope, most[static_cast<std::size_t>(at - first)]) : at->by_slope;
  }
}

}  // namespace bgsim
