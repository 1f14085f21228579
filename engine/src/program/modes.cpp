#include <algorithm>
#include <cmath>
#include <limits>

#include "expression/graph.hpp"
#include "expression/table_cell.hpp"
#include "expression/time_event.hpp"
#include "program/evaluator_impl.hpp"
#include "program/mode_borders.hpp"

namespace bgsim {

double Evaluator::Impl::mode_for(const Relation& relation, double guard) const {
  switch (relation.kind) {
    case Relation::Kind::condition:
      return apply(relation.comparison, guard, 0.0);
    case Relation::Kind::sign:
    case Relation::Kind::denominator:
      return apply(Op::sign, guard);
    case Relation::Kind::step:
      return apply(Op::step, guard);
    case Relation::Kind::floor:
      return std::floor(guard);
    case Relation::Kind::round:
      return std::round(guard);
    case Relation::Kind::cell:
      return static_cast<double>(cell_of(program.pool.table(relation.table), guard));
  }
  return 0.0;
}

std::size_t Evaluator::guard_count() const {
  std::size_t count = 0;
  for (const std::uint32_t relation : impl_->program.guarded)
    count += impl_->program.relations[relation].has_borders() ? 2U : 1U;
  return count;
}

std::size_t Evaluator::guard_relation(std::size_t guard) const {
  for (const std::uint32_t relation : impl_->program.guarded) {
    const std::size_t functions = impl_->program.relations[relation].has_borders() ? 2U : 1U;
    if (guard < functions) return relation;
    guard -= functions;
  }
  return impl_->program.relations.size();
}

bool Evaluator::guards(double t, const double* x, Branch& branch, double* values) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  if (!impl.run_or_given(program.guards, t, x, branch)) return false;
  if (!impl.take(program.guards, impl.guard_values.data(), "a condition", {})) return false;
  for (std::size_t i = 0; i < program.guarded.size(); ++i) {
    const Relation& relation = program.relations[program.guarded[i]];
    const double guard = impl.guard_values[i];
    if (relation.has_borders()) {
      const auto [lower, upper] = mode_borders(program, relation, branch.modes[program.guarded[i]]);
      *values++ = guard - lower;
      *values++ = upper - guard;
    } else {
      *values++ = guard;
    }
  }
  return true;
}

bool Evaluator::initialize_modes(double t, const double* x, Branch& branch) {
  Impl& impl = *impl_;
  set_time_modes(t, branch);
  Branch free = branch;
  if (impl.settle_modes(t, x, branch)) return true;
  const Fault fault = impl.fault;
  if (impl.solve_with_conditions(t, x, free) && impl.settle_modes(t, x, free)) {
    branch = std::move(free);
    return true;
  }
  impl.fault = fault;
  return false;
}

Evaluator::Impl::Conditions Evaluator::Impl::take_conditions(double* modes) const {
  // One condition may depend on a law that ends at another's border (a flow f = if(e > 0, sqrt(e), -sqrt(-e)) and
  // whether it is positive): the other comes first, and this one stays as it is.
  Conditions conditions;
  for (std::size_t i = 0; i < program.guarded.size(); ++i) {
    const double guard = slots[program.guards.results[i]];
    conditions.open = conditions.open || !std::isfinite(guard);
    if (!std::isfinite(guard)) continue;
    const double value = mode_for(program.relations[program.guarded[i]], guard);
    double& mode = modes[program.guarded[i]];
    conditions.changed = conditions.changed || value != mode;
    mode = value;
  }
  return conditions;
}

bool Evaluator::Impl::settle_modes(double t, const double* x, Branch& branch) {
  // Conditions may contain conditions, and loops may depend on modes: repeat until nothing changes. A chain of n nested
  // conditions needs n rounds; more than all of them means that they contradict each other.
  for (std::size_t round = 0; round < program.guarded.size() + 2; ++round) {
    if (!run(program.guards, t, x, branch)) return false;
    const auto [changed, open] = take_conditions(branch.modes.data());
    if (!changed) return !open || take(program.guards, guard_values.data(), "a condition", {});
  }
  const Relation& first = program.relations[program.guarded.front()];
  fault = {
      Fault::Kind::loop_no_convergence, t, "the conditions contradict each other in every state", first.text, {}, {}};
  describe_origin(first.origin);
  return false;
}

void Evaluator::cross(std::span<const int> direction, Branch& branch) const {
  const Program& program = impl_->program;
  std::size_t guard = 0;
  for (const std::uint32_t index : program.guarded) {
    const Relation& relation = program.relations[index];
    double& mode = branch.modes[index];
    if (relation.has_borders()) {
      if (direction[guard] < 0) mode -= 1.0;
      if (direction[guard + 1] < 0) mode += 1.0;
      if (relation.kind == Relation::Kind::cell) {
        const auto last = static_cast<double>(program.pool.table(relation.table).x.size() - 2);
        mode = std::clamp(mode, 0.0, last);
      }
      guard += 2;
    } else {
      if (direction[guard] != 0) mode = impl_->mode_for(relation, direction[guard]);
      guard += 1;
    }
  }
}

bool Evaluator::set_time_modes(double t, Branch& branch) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  impl.symbol_values[program.time.index()] = t;
  bool changed = false;
  for (std::size_t i = 0; i < program.relations.size(); ++i) {
    if (!program.relations[i].time_only) continue;
    const double mode = impl.mode_just_after(i, t);
    changed = changed || mode != branch.modes[i];
    branch.modes[i] = mode;
  }
  return changed;
}

void Evaluator::go_on(double t, const Branch& branch, double until) {
  const Program& program = impl_->program;
  for (std::size_t i = 0; i < program.relations.size(); ++i) {
    if (!program.relations[i].time_only) continue;
    const double mode = impl_->mode_just_after(i, t), held = branch.modes[i];
    if (mode < held || mode > held) static_cast<void>(impl_->look_for_change(i, t, until, held));
  }
}

double Evaluator::Impl::mode_just_after(std::size_t relation, double t) {
  KnownTime& known = *known_times[relation];
  if (known.mode_at == t) return known.mode;
  RelationOfTime* kept = relation_of_time(relation);
  const ExprId origin = program.relations[relation].origin;
  known.mode = kept != nullptr ? kept->value_just_after(t)
                               : value_just_after(program.pool, origin, program.time, symbol_values, t);
  known.mode_at = t;
  return known.mode;
}

RelationOfTime* Evaluator::Impl::relation_of_time(std::size_t relation) {
  std::optional<RelationOfTime>& kept = of_time[relation];
  const ExprId origin = program.relations[relation].origin;
  if (kept) return &*kept;
  const std::vector<ExprId> nodes = reachable(program.pool, {&origin, 1});
  if (std::any_of(nodes.begin(), nodes.end(), [this](ExprId e) { return is_table(program.pool[e].op); }))
    return nullptr;
  return &kept.emplace(program.pool, origin, program.time, symbol_values);
}

/// The next known change of a relation of time alone. One that changes from double to double for long is rounding about
/// a border that it never leaves: it has no known times.
bool Evaluator::Impl::look_for_change(std::size_t relation, double after, double until, std::optional<double> held) {
  constexpr double kNear = 1e-12;  // of what is left of the scene
  constexpr std::uint32_t kMostInARow = 100;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (!goes_on()) return false;
  KnownTime& known = *known_times[relation];
  TimeSearch search{known.guess(after), {}};
  RelationOfTime* kept = relation_of_time(relation);
  const auto change = kept != nullptr ? kept->next_change(after, until, &search, held)
                                      : bgsim::next_change(program.pool, program.relations[relation].origin,
                                                           program.time, symbol_values, after, until, &search, held);
  known.looked_from = after;
  known.looked_until = until;
  known.next_change = change.value_or(kNever);
  if (change) known.take_change(*change);
  if (search.undecided && !known.undecided) known.undecided = search.undecided;
  known.near_changes = change && *change - after < kNear * (until - after) ? known.near_changes + 1 : 0;
  if (known.near_changes <= kMostInARow) return true;
  if (!known.undecided) known.undecided = after;
  known.looked_until = known.next_change = kNever;
  return true;
}

std::vector<std::pair<std::size_t, double>> Evaluator::undecided_relations() const {
  std::vector<std::pair<std::size_t, double>> result;
  for (std::size_t i = 0; i < impl_->known_times.size(); ++i)
    if (const auto since = impl_->known_times[i]->undecided) result.emplace_back(i, *since);
  return result;
}

std::optional<double> Evaluator::next_time_event(double after, double until) {
  // Instants that are products and quotients of the same numbers, k*Ts and 18/fs, differ by a few roundings. Samples
  // that are due at them are taken together, at the last of them; all come earlier than that anyway (kSamplesEarly).
  constexpr double kSame = 0x1p-46;
  Impl& impl = *impl_;
  const Program& program = impl.program;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double first = kNone, sample = kNone;
  for (std::size_t i = 0; i < program.relations.size(); ++i) {
    if (!program.relations[i].time_only) continue;
    // A change found earlier stays the next one until it has passed.
    KnownTime& time = *impl.known_times[i];
    const bool known = time.looked_from <= after && (after < time.next_change || std::isinf(time.next_change)) &&
                       until <= time.looked_until;
    if (!known && !impl.look_for_change(i, after, until)) return std::nullopt;
    if (time.next_change > until) continue;
    double& earliest = program.relations[i].samples ? sample : first;
    earliest = std::min(earliest, time.next_change);
  }
  if (sample < first) {
    double last = sample;
    for (std::size_t i = 0; i < program.relations.size(); ++i) {
      if (!program.relations[i].time_only || !program.relations[i].samples) continue;
      const double at = impl.known_times[i]->next_change;
      if (at <= until && at - sample <= kSame * std::abs(sample)) last = std::max(last, at);
    }
    first = std::min(first, last);
  }
  return first == kNone ? std::nullopt : std::optional(first);
}

}  // namespace bgsim
