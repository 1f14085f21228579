#include "run/event_log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "model/add_symbols.hpp"

namespace bgsim {
namespace {

/// Which side a condition is on, as a text.
std::string condition_side(const Relation& relation, double mode) {
  switch (relation.kind) {
    case Relation::Kind::condition:
      return relation.is_between(mode) ? "held" : mode != 0.0 ? "true" : "false";
    case Relation::Kind::step:
      return relation.is_between(mode) ? "held" : number_text(mode);
    case Relation::Kind::sign:
      // Between its two sides a sign is held at its border, wherever that is.
      return std::abs(mode) == 1.0 || mode == 0.0 ? number_text(mode + 0.0) : "held";  // -0 is 0
    default:
      return number_text(relation.negated ? 0.0 - mode : mode);
  }
}

/// Whether a condition is not the model's, but stands behind a diode, a sampling time or a latch, whose rows say it.
bool stands_behind(const Program& program, const Relation& relation) {
  for (const char* const own : {kBandParameter, kHoldingParameter, kRestParameter})
    if (relation.text.find(own) != std::string::npos) return true;
  if (relation.samples) return true;
  return std::any_of(program.model->events.begin(), program.model->events.end(), [&](const ModelEvent& event) {
    return event.at_start && !event.sampled.valid() &&
           relation.text == program.model->signals[event.sets.front().signal.index()].name + " > 0.5";
  });
}

}  // namespace

void EventLog::add(const RunEvent& event) {
  reach(event.t);
  put(event);
}

void EventLog::add_later(const RunEvent& event) {
  const auto after =
      std::upper_bound(later_.begin(), later_.end(), event.t, [](double t, const Later& at) { return t < at.event.t; });
  later_.insert(after, {event});
}

bool EventLog::take_back(const std::string& name) {
  return std::erase_if(later_, [&name](const Later& at) { return at.event.name == name; }) > 0;
}

void EventLog::reach(double t) {
  while (!later_.empty() && later_.front().event.t <= t) {
    const RunEvent event = std::move(later_.front().event);
    later_.erase(later_.begin());
    put(event);
  }
}

void EventLog::put(const RunEvent& event) {
  if (most_ > 0 && event.kind != RunEvent::Kind::start) {
    ++count_;
    std::string name = std::string(event_kind_text(event.kind)) + " " + in_quotes(event.name);
    const auto [found, added] = position_.try_emplace(std::move(name), names_.size());
    if (added) {
      names_.push_back(found->first);
      counts_.push_back(0);
    }
    ++counts_[found->second];
  }
  ++given_;
  if (skip_ > 0)
    --skip_;
  else if (sink_)
    sink_(event);
}

void EventLog::add_set(double t, const Program& program, std::size_t event, std::span<const double> before,
                       std::span<const double> after, std::optional<double> energy) {
  const ProgramEvent& at = program.events[event];
  const ModelEvent& written = program.model->events[event];
  const bool memory = written.at_start;
  if (memory && written.sampled.valid() && written.sets.front().signal != written.sampled) return;  // previous(u)
  for (const ProgramEvent::Set& set : at.sets) {
    const double from = before[*set.state], to = after[*set.state];
    RunEvent row;
    row.t = t;
    if (!memory) {
      row.kind = RunEvent::Kind::event;
      row.name = at.name;
      row.quantity = set.name;
      row.energy = std::exchange(energy, std::nullopt);
    } else {
      row.name = program.model->signals[written.sets.front().signal.index()].name;
      row.kind = written.sampled.valid() ? RunEvent::Kind::sample : RunEvent::Kind::latch;
    }
    if (row.kind == RunEvent::Kind::latch) {
      if (from == to) return;
      row.from = from != 0.0 ? "true" : "false";
      row.to = to != 0.0 ? "true" : "false";
    } else {
      row.from = shortest_number(from);
      row.to = shortest_number(to);
    }
    add(row);
  }
}

void EventLog::watch(const Program& program) {
  program_ = &program;
  watched_.clear();
  if (!wanted()) return;
  for (std::size_t i = 0; i < program.relations.size(); ++i) {
    const Relation& relation = program.relations[i];
    if (relation.kind == Relation::Kind::denominator || stands_behind(program, relation)) continue;
    std::string* side = &sides_[relation.text];
    const bool twice =
        std::any_of(watched_.begin(), watched_.end(), [&](const Watched& other) { return other.side == side; });
    if (!twice) watched_.push_back({i, std::numeric_limits<double>::quiet_NaN(), side});
  }
}

void EventLog::look(double t, const Branch& branch) {
  for (Watched& at : watched_) {
    const double mode = branch.modes[at.relation];
    if (mode == at.mode) continue;
    at.mode = mode;
    const Relation& relation = program_->relations[at.relation];
    std::string side = condition_side(relation, mode);
    if (side == *at.side) continue;
    RunEvent row;
    row.t = t;
    row.kind = relation.time_only ? RunEvent::Kind::time : RunEvent::Kind::condition;
    row.name = relation.text;
    row.from = std::exchange(*at.side, side);
    row.to = std::move(side);
    if (!row.from.empty()) add(row);
  }
}

void EventLog::take_over(const Branch& branch) {
  for (Watched& at : watched_) {
    at.mode = branch.modes[at.relation];
    *at.side = condition_side(program_->relations[at.relation], at.mode);
  }
}

std::optional<Diagnostic> EventLog::full(double t) const {
  if (most_ == 0 || count_ <= most_) return std::nullopt;
  constexpr std::size_t kNamed = 3;
  std::vector<std::size_t> order(names_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [this](std::size_t a, std::size_t b) { return counts_[a] > counts_[b]; });
  std::string most;
  for (std::size_t i = 0; i < order.size() && i < kNamed; ++i)
    most += (i == 0 ? "" : ", ") + names_[order[i]] + " " + std::to_string(counts_[order[i]]) +
            (counts_[order[i]] == 1 ? " time" : " times");
  if (order.size() > kNamed) most += " and " + std::to_string(order.size() - kNamed) + " others";
  return diagnostic_of(
      "BG628", "at t = " + number_text(t) + " the run has had more than " + std::to_string(most_) + " events: " + most,
      place_, "a run has as many events as the scene's \"max_events\" at most",
      "raise \"max_events\", or leave it out; --events FILE writes all events of a run");
}

}  // namespace bgsim
