#include "run/tolerances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "run/euler_steps.hpp"

namespace bgsim {

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Lengths of the Euler steps as fractions of the scene. Odd numbers on purpose: 1/h should not meet the eigenvalues
/// that models have.
constexpr std::array<double, 7> kStages = {1.07e-9, 3.3e-8, 1.13e-6, 3.1e-5, 1.19e-3, 2.9e-2, 0.93};
/// A state may grow to what the Euler step predicts; errors far below that do no harm while it is on its way.
constexpr double kOfEulerStep = 1e-5;
/// A state that has decayed is forgotten to have been large, down to this part of it: Robertson's intermediate falls to
/// 1e-9 of its peak and errors of the size of 1e-6 of the peak would make it negative, which explodes.
constexpr double kRemembered = 1e-4;
/// Lately is the last quarter of the elapsed time at least, and the last fifteen sixteenths at most.
constexpr double kWindow = 4.0;
/// How far ahead of the elapsed time a prediction counts, and at the start, as part of the scene.
constexpr double kAhead = 10.0, kAheadAtStart = 1e-4;
/// Euler steps longer than so many times what drives them are not asked for.
constexpr double kBrief = 3.0;

std::size_t full_size(const Program& program) { return program.state_names.size() + program.tear_names.size(); }
}  // namespace

Tolerances::Tolerances(const Program& program, const RunInputs& inputs, bool implicit)
    : program_(program),
      implicit_(implicit),
      states_(program.state_names.size()),
      size_(implicit ? full_size(program) : states_),
      relative_(inputs.relative),
      start_(inputs.start),
      span_(inputs.stop - inputs.start),
      given_(full_size(program), -1.0),
      largest_(full_size(program), 0.0),
      recent_(full_size(program), 0.0),
      earlier_(full_size(program), 0.0),
      floor_(full_size(program), 0.0),
      noise_(full_size(program), 0.0),
      time_noise_(full_size(program), 0.0),
      shift_(full_size(program), 0.0),
      damping_(full_size(program), 0.0),
      inherited_noise_(full_size(program), 0.0),
      next_inherited_noise_(full_size(program), 0.0),
      stages_(kStages.size(), std::vector<double>(full_size(program), 0.0)),
      cap_(full_size(program), std::numeric_limits<double>::infinity()),
      watched_(full_size(program), true) {
  for (std::size_t i = 0; i < states_; ++i) {
    if (inputs.absolute) given_[i] = *inputs.absolute;
    const auto own = inputs.absolute_by_state.find(program.state_names[i]);
    if (own != inputs.absolute_by_state.end()) given_[i] = own->second;
  }
}

void Tolerances::know_proportional(Proportional states) {
  proportional_ = std::move(states);
  size_of_group_.assign(proportional_.groups, 0.0);
  capped_.clear();
  for (std::uint32_t i = 0; i < proportional_.group.size(); ++i)
    if (proportional_.alone[i] || proportional_.group[i] != kNoGroup) capped_.push_back(i);
}

/// What is small now decides what is large later where a state is its own factor, or a group of states is: their scale
/// is what they are now.
void Tolerances::cap_proportional(const double* y) {
  std::fill(size_of_group_.begin(), size_of_group_.end(), 0.0);
  for (const std::uint32_t i : capped_)
    if (const std::uint32_t group = proportional_.group[i]; group != kNoGroup && largest_[i] > 0.0)
      size_of_group_[group] = std::max(size_of_group_[group], std::abs(y[i]) / largest_[i]);
  for (const std::uint32_t i : capped_) {
    if (proportional_.alone[i])
      cap_[i] = std::abs(y[i]);
    else if (const std::uint32_t group = proportional_.group[i]; group != kNoGroup)
      cap_[i] = largest_[i] > 0.0 ? largest_[i] * size_of_group_[group] : std::numeric_limits<double>::infinity();
  }
}

void Tolerances::estimate(Evaluator& evaluator, double t, const double* x, const Branch& branch,
                          const std::vector<double>& times) {
  for (std::size_t i = 0; i < states_; ++i) recent_[i] = std::max(recent_[i], std::abs(x[i]));
  const bool all_given = std::all_of(given_.begin(), given_.end(), [](double g) { return g >= 0.0; });
  if (states_ == 0 || all_given || !(span_ > 0.0)) return;

  // What acts only until the next known event says nothing about later.
  struct Push {
    double at;
    std::vector<double> rates;
    double lasts;
    std::vector<double> jacobian;  ///< there, if it is another one than here
    double steepest = 0.0;         ///< its largest entry
  };
  const double stop = start_ + span_;
  std::vector<Push> pushes;
  std::vector<double> now(states_);
  const auto lasts = [&](double from) {
    const double event = evaluator.next_time_event(from, stop).value_or(stop);
    const auto edge = std::upper_bound(edges_.begin(), edges_.end(), from);
    return std::min(event, edge == edges_.end() ? stop : *edge) - from;
  };
  Branch here = branch;
  if (!evaluator.rates(t, x, here, now.data())) return;
  pushes.push_back({t, now, lasts(t), {}});
  std::vector<double> y(x, x + states_);
  if (implicit_) y.insert(y.end(), here.tears.begin(), here.tears.end());
  for (std::size_t i = states_; i < size_; ++i) recent_[i] = std::max(recent_[i], std::abs(y[i]));
  EulerSystems probe(program_, implicit_);
  std::vector<double> jacobian, other_jacobian;
  // Where slopes have no bound (a root at rest) the states leave the point at once.
  const bool bounded = probe.see(evaluator, t, y.data(), here, jacobian);
  if (!bounded && implicit_ && !program_.plan.explicit_form) return;
  std::optional<EulerFromRest> from_rest;
  if (!bounded) from_rest.emplace(program_, evaluator);
  Branch there;
  for (const double other : times) {
    there = here;
    evaluator.set_time_modes(other, there);
    if (!evaluator.rates(other, x, there, now.data())) continue;
    if (implicit_) std::copy(there.tears.begin(), there.tears.end(), y.begin() + static_cast<std::ptrdiff_t>(states_));
    Push push{other, now, lasts(other), {}};
    if (bounded && !probe.see(evaluator, other, y.data(), there, other_jacobian)) continue;
    if (bounded && other_jacobian != jacobian) {
      push.jacobian = other_jacobian;
      for (const double entry : other_jacobian) push.steepest = std::max(push.steepest, std::abs(entry));
    }
    pushes.push_back(std::move(push));
  }

  // Earlier predictions are forgotten slowly: a state that has been at rest may be called upon again.
  for (std::vector<double>& stage : stages_)
    for (double& magnitude : stage) magnitude /= 30.0;
  std::vector<double> magnitude(size_), least, moved(x, x + states_), second(states_);
  for (std::size_t stage = 0; stage < kStages.size(); ++stage) {
    const double h = kStages[stage] * span_;
    if (bounded && !probe.factor(h, jacobian)) continue;
    std::fill(magnitude.begin(), magnitude.end(), 0.0);
    const auto take = [&](const double* change, bool only_unmoved) {
      for (std::size_t i = 0; change != nullptr && i < size_; ++i) {
        const double size = std::abs(change[i]);
        if (std::isfinite(size) && !(only_unmoved && magnitude[i] > 0.0)) magnitude[i] = std::max(magnitude[i], size);
      }
      return change;
    };
    for (const Push& push : pushes) {
      if (kBrief * push.lasts < h) {
        // Over before the shortest stage: what it moves is its rate times its length, which is more than a prediction.
        constexpr double kCertain = 1e3;
        for (std::size_t i = 0; stage == 0 && i < states_; ++i)
          magnitude[i] = std::max(magnitude[i], kCertain * std::abs(push.rates[i]) * push.lasts);
        continue;
      }
      if (!bounded) {
        if (!from_rest->step(push.at, h, x, here)) continue;
        least = from_rest->change();
        for (std::size_t i = states_; i < size_; ++i)
          least.push_back(from_rest->tears()[i - states_] - here.tears[i - states_]);
        take(least.data(), false);
        continue;
      }
      // Beside slopes so steep the states' own part of the matrix is lost to rounding, and what is solved for is
      // anything: two diodes at the source's peak predicted 1e141 V.
      constexpr double kSteepest = 1e12;
      if (h * push.steepest > kSteepest) continue;
      const double* change = probe.solve(h, push.rates);
      if (!push.jacobian.empty() && change != nullptr) {
        // The smaller of two predictions: by the matrix here, and by that of the push. A diode's current at the
        // source's peak is nothing to go by without its slope there.
        least.assign(change, change + size_);
        change = probe.factor(h, push.jacobian) ? probe.solve(h, push.rates) : nullptr;
        for (std::size_t i = 0; change != nullptr && i < size_; ++i)
          if (!(std::abs(least[i]) < std::abs(change[i]))) least[i] = change[i];
        take(least.data(), false);
        probe.factor(h, jacobian);
        continue;
      }
      if (&push != &pushes.front() || change == nullptr) {
        take(change, false);
        continue;
      }
      for (std::size_t i = 0; i < states_; ++i) moved[i] = x[i] + change[i];
      // What comes out of a delay later is not known yet; the cubic of its last record goes anywhere.
      for (const ProgramDelay& delay : program_.delays) moved[delay.clock] = x[delay.clock];
      // A slope carried far beyond where it holds predicts anything: the flank of a narrow law. What neither the rates
      // here nor those at the far end move by is no prediction.
      least.assign(change, change + size_);
      there = here;
      const bool seen = (program_.guarded.empty() || evaluator.initialize_modes(t, moved.data(), there)) &&
                        evaluator.rates(t, moved.data(), there, second.data());
      constexpr double kFar = 10.0;
      for (std::size_t i = 0; seen && i < states_; ++i) {
        const double most = kFar * h * std::max(std::abs(push.rates[i]), std::abs(second[i]));
        if (std::abs(least[i]) > most) least[i] = most;
      }
      take(least.data(), false);
    }
    // States that only products of others set in motion are seen from the point that these have moved to, where
    // conditions may have changed: a law far beyond its own border predicts nothing.
    bool unmoved = false;
    for (std::size_t i = 0; i < states_; ++i) unmoved = unmoved || (magnitude[i] == 0.0 && recent_[i] == 0.0);
    there = here;
    const bool settled =
        bounded && unmoved && (program_.guarded.empty() || evaluator.initialize_modes(t, moved.data(), there));
    if (settled && evaluator.rates(t, moved.data(), there, second.data())) take(probe.solve(h, second), true);
    add_estimate(stage, magnitude);
  }
  solver_cost_ = probe.cost();
  reach_ = 0.0;
  std::fill(floor_.begin(), floor_.end(), 0.0);
  reach(t - start_);
}

void Tolerances::add_estimate(std::size_t stage, const std::vector<double>& magnitude) {
  for (std::size_t i = 0; i < size_; ++i) stages_[stage][i] = std::max(stages_[stage][i], magnitude[i]);
}

/// Raises the floor to what the stages within reach predict. (Where h meets an unstable eigenvalue the Euler step is
/// singular, and its prediction too large: by 1e5 if they agree to five digits, which kOfEulerStep takes back.)
void Tolerances::reach(double elapsed) {
  const double ahead = std::max(kAhead * elapsed, kAheadAtStart * span_);
  if (reach_ > 0.0 && ahead < 2.0 * reach_ && reach_ < span_) return;
  if (reach_ >= span_) return;
  reach_ = ahead;
  std::size_t last = 0;
  while (last + 1 < kStages.size() && kStages[last] * span_ < ahead) ++last;
  for (std::size_t i = 0; i < size_; ++i) {
    double predicted = 0.0;
    for (std::size_t stage = 0; stage <= last; ++stage) predicted = std::max(predicted, stages_[stage][i]);
    floor_[i] = kOfEulerStep * predicted;
  }
}

double Tolerances::absolute(std::size_t unknown) const { return absolute(unknown, 0.0); }

double Tolerances::resolved(std::size_t unknown) const { return resolved(unknown, 0.0); }

/// @param size  of the unknown where it is.
double Tolerances::resolved(std::size_t unknown, double size) const {
  if (given_[unknown] >= 0.0) return given_[unknown];
  const double scale =
      std::max({size, recent_[unknown], earlier_[unknown], kRemembered * largest_[unknown], floor_[unknown]});
  return relative_ * std::min(scale, cap_[unknown]);
}

double Tolerances::absolute(std::size_t unknown, double size) const {
  const double known = resolved(unknown, size);
  return given_[unknown] >= 0.0 ? known : std::max(known, unknowable(unknown));
}

bool Tolerances::begin_with(std::size_t state, double scale) {
  stages_.front()[state] = std::max(stages_.front()[state], scale / kOfEulerStep);
  floor_[state] = std::max(floor_[state], scale);
  if (!(relative_ * scale > 0.0)) return false;
  watched_[state] = true;  // also where no weights are asked for: a step of a rounding of the time
  return true;
}

/// What rounding leaves open of an unknown over one step.
double Tolerances::unknowable(std::size_t unknown) const {
  if (unknown >= states_) return noise_[unknown];
  // A source that is late by a rounding of time changes a step's result by its rate times that, however steep it is.
  const double late = std::min(step_ * time_noise_[unknown], shift_[unknown]);
  return (step_ * (noise_[unknown] + inherited_noise_[unknown]) + late) / (1.0 + step_ * damping_[unknown]);
}

void Tolerances::accept(double t, std::span<const double> y) {
  if (t - start_ > kWindow * window_start_) {
    window_start_ = t - start_;
    std::swap(earlier_, recent_);
    std::fill(recent_.begin(), recent_.end(), 0.0);
  }
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double size = std::abs(y[i]);
    recent_[i] = std::max(recent_[i], size);
    largest_[i] = std::max(largest_[i], size);
  }
  cap_proportional(y.data());
}

namespace {

/// What the tolerances of all unknowns follow from, by unknown.
struct Scales {
  const double *given, *recent, *earlier, *largest, *floor, *cap, *noise, *inherited, *damping, *time_noise, *shift;
};

double weight_of(const Scales& scales, double relative, std::size_t i, double y, double unknowable) {
  constexpr double kLargest = 1e300;
  const auto larger = [](double a, double b) { return a < b ? b : a; };
  const auto smaller = [](double a, double b) { return b < a ? b : a; };
  const double size = std::fabs(y);
  const double lately = larger(larger(size, scales.recent[i]), scales.earlier[i]);
  const double scale = larger(larger(lately, kRemembered * scales.largest[i]), scales.floor[i]);
  const double known = relative * smaller(scale, scales.cap[i]);
  const double found = larger(known, unknowable), wanted = scales.given[i];
  const double tolerance = relative * size + (wanted >= 0.0 ? wanted : found);
  const double inverse = smaller(1.0 / tolerance, kLargest);
  // A state that is 0 and that nothing is known to move is not watched until it moves (take_first_scales).
  return tolerance > 0.0 ? inverse : 0.0;
}

/// As Tolerances::absolute() says for each unknown, without branches: this is done in every step.
void weigh(const Scales& scales, double relative, double step, std::size_t states, std::size_t n,
           const double* __restrict y, double* __restrict weight) {
  const Scales at = scales;
  for (std::size_t i = 0; i < states; ++i) {
    const double shift = at.shift[i], moved = step * at.time_noise[i], late = shift < moved ? shift : moved;
    const double unknowable = (step * (at.noise[i] + at.inherited[i]) + late) / (1.0 + step * at.damping[i]);
    weight[i] = weight_of(at, relative, i, y[i], unknowable);
  }
  for (std::size_t i = states; i < n; ++i) weight[i] = weight_of(at, relative, i, y[i], at.noise[i]);
}

}  // namespace

void Tolerances::weights(double t, double step, const double* y, double* weight) {
  step_ = std::abs(step);
  reach(t - start_);
  weigh({given_.data(), recent_.data(), earlier_.data(), largest_.data(), floor_.data(), cap_.data(), noise_.data(),
         inherited_noise_.data(), damping_.data(), time_noise_.data(), shift_.data()},
        relative_, step_, states_, size_, y, weight);
  std::size_t weighed = 0;
  for (std::size_t i = 0; i < size_; ++i) weighed += weight[i] > 0.0 ? 1 : 0;
  watches_all_ = weighed == size_;
  if (watches_all_) return;
  for (std::size_t i = 0; i < size_; ++i) {
    const double size = std::abs(y[i]);
    watched_[i] = relative_ * size + absolute(i, size) > 0.0;
  }
}

namespace {

template <class Visit>
void each_entry(const Sparsity& pattern, const double* entries, Visit&& visit) {
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
         k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
      visit(static_cast<std::size_t>(pattern.row[k]), column, std::abs(entries[k]));
}

/// A tolerance has to be so many times the rounding in what an iteration ends on, since that is stopped at a
/// thirtieth of the tolerance.
constexpr double kRoundings = 20.0;

}  // namespace

void Tolerances::see(const Point& at, const Evaluate& evaluate) {
  each_entry(at.pattern, at.entries, [&](std::size_t row, std::size_t column, double size) {
    if (row == column && row < states_) damping_[row] = size;
  });
  if (at.rounding.empty())
    shake(at, evaluate);
  else
    bound_noise(at);
  see_time(at, evaluate);
  pass_on(at);
}

/// By bounds: of the rates' own rounding, and of what the rounding of each state makes of them. A state that forgets
/// within the step takes what its rounding did back.
void Tolerances::bound_noise(const Point& at) {
  for (std::size_t i = 0; i < states_; ++i) noise_[i] = kRoundings * at.rounding[i];
  each_entry(at.pattern, at.entries, [&](std::size_t row, std::size_t column, double size) {
    noise_[row] += kRoundings * kEps / 2.0 * size * std::abs(at.y[column]) / (1.0 + step_ * damping_[column]);
  });
}

/// By samples, where loops are too large for bounds: what a few roundings of the unknowns do to a rate.
void Tolerances::shake(const Point& at, const Evaluate& evaluate) {
  constexpr int kSamples = 3;
  shaken_.resize(size_);
  rates_.resize(size_);
  shaken_rates_.resize(size_);
  if (!evaluate(at.t, at.y, rates_.data())) return;
  for (std::size_t i = 0; i < states_; ++i) noise_[i] /= 2.0;  // a sample may meet no rounding by chance
  for (int sample = 1; sample <= kSamples; ++sample) {
    const double shake = sample * kEps;
    for (std::size_t i = 0; i < size_; ++i) shaken_[i] = at.y[i] * (i % 2 == 0 ? 1.0 + shake : 1.0 - shake);
    if (evaluate(at.t, shaken_.data(), shaken_rates_.data()))
      for (std::size_t i = 0; i < states_; ++i)
        noise_[i] = std::max(noise_[i], kRoundings / sample * std::abs(shaken_rates_[i] - rates_[i]));
  }
}

/// What a few roundings of the time do to a rate.
void Tolerances::see_time(const Point& at, const Evaluate& evaluate) {
  constexpr int kSamples = 3;
  rates_.resize(size_);
  shaken_rates_.resize(size_);
  std::fill(time_noise_.begin(), time_noise_.end(), 0.0);
  if (!evaluate(at.t, at.y, rates_.data())) return;
  for (int sample = 1; sample <= kSamples; ++sample)
    if (evaluate(at.t * (1.0 + sample * kEps), at.y, shaken_rates_.data()))
      for (std::size_t i = 0; i < states_; ++i)
        time_noise_[i] = std::max(time_noise_[i], kRoundings / sample * std::abs(shaken_rates_[i] - rates_[i]));
  // A change that grows with the shake is no rounding but the slope of a source, a pulse's flank perhaps. Late by a
  // rounding, it changes a step's result by its rate times that. Where the rate comes from 0 (a source that starts at
  // 1e8 s) it is that of a step as short as time allows.
  constexpr double kFarther = 64.0, kGrows = 8.0;
  for (std::size_t i = 0; i < states_; ++i) shift_[i] = std::numeric_limits<double>::infinity();
  for (const double side : {-1.0, 1.0}) {
    if (!evaluate(at.t * (1.0 + side * kFarther * kEps), at.y, shaken_rates_.data())) continue;
    for (std::size_t i = 0; i < states_; ++i) {
      const double change = std::abs(shaken_rates_[i] - rates_[i]);
      if (!(kRoundings * change > kGrows * time_noise_[i])) continue;
      const double rate = std::abs(at.slopes != nullptr ? at.slopes[i] : rates_[i]);
      const double late = kRoundings * kEps * std::abs(at.t) * (rate + change);
      shift_[i] = std::isinf(shift_[i]) ? late : std::max(shift_[i], late);
    }
  }
}

/// Always from the noise itself, over a few links: what went round a loop and came back larger (where stiff parts face
/// each other) would grow from Jacobian to Jacobian, and in the end the run would be free to go anywhere.
void Tolerances::pass_on(const Point& at) {
  constexpr double kPassedOn = 0.1;
  constexpr int kLinks = 2;
  std::fill(inherited_noise_.begin(), inherited_noise_.end(), 0.0);
  for (int link = 0; link < kLinks; ++link) {
    std::fill(next_inherited_noise_.begin(), next_inherited_noise_.end(), 0.0);
    each_entry(at.pattern, at.entries, [&](std::size_t row, std::size_t column, double size) {
      if (row != column && row < states_) next_inherited_noise_[row] += kPassedOn * size * unknowable(column);
    });
    std::swap(inherited_noise_, next_inherited_noise_);
  }
}

void Tolerances::see_loops(std::span<const double> changes) {
  for (std::size_t i = 0; i < changes.size(); ++i)
    noise_[states_ + i] = std::max(noise_[states_ + i] / 2.0, kRoundings * changes[i]);
}

void Tolerances::forget_noise() {
  std::fill(noise_.begin(), noise_.end(), 0.0);
  std::fill(time_noise_.begin(), time_noise_.end(), 0.0);
  std::fill(inherited_noise_.begin(), inherited_noise_.end(), 0.0);
}

}  // namespace bgsim
