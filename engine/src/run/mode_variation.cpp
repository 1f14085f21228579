#include "run/mode_variation.hpp"

#include <algorithm>
#include <cmath>

#include "base/codes.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"
#include "run/jump.hpp"
#include "run/network_slopes.hpp"
#include "run/stored.hpp"

namespace bgsim {
namespace {

Diagnostic refusal(double t, const std::string& what, std::string rule) {
  return diagnostic_of("BG414", "at t = " + number_text(t) + " " + what, {}, std::move(rule),
                       "ask for --method differences");
}

/// What all stores hold where the states are @p x. False where that has no value.
bool put_all(Evaluator& evaluator, double t, const std::vector<double>& x, Branch& branch, Stored& stored) {
  const Program& program = evaluator.program();
  std::vector<double> dependent(program.dependent.size());
  if (!dependent.empty() && !evaluator.dependents(t, x.data(), branch, dependent.data())) return false;
  put_stored(stored, program, x, dependent);
  return true;
}

}  // namespace

void ModeVariation::leave(const Program& program, const std::vector<double>& parameters, double t, Departure departure,
                          const Stored& stored, std::vector<double> scales) {
  // A mode that is left as it begins belongs to the instant before it, whose t' it has.
  if (departure.instant) instant_ = *departure.instant;
  steps_.clear();
  end_.reset();
  closed_.clear();
  left_ = Left{&program, parameters, std::move(departure), stored, std::move(scales)};
  left_->stored.t = t;
}

void ModeVariation::impact(const ImpactProgram& impact, const DiodeNetwork& network,
                           const std::vector<std::optional<double>>& kick) {
  Step step{&impact.program, inputs_.parameters, &impact, &network, {}};
  for (const std::optional<double>& each : kick) step.kicked.push_back(each.has_value());
  for (const std::size_t contact : closed_) step.kicked[contact] = false;  // it does not rebound
  for (std::size_t i = 0; i < kick.size(); ++i) step.lands = step.lands || (step.kicked[i] && *kick[i] == 0.0);
  steps_.push_back(std::move(step));
}

void ModeVariation::arrive(std::size_t contact) {
  const std::vector<double>& x = left_->departure.x;
  const std::size_t n = left_->program->varied_states;
  Arrival arrival{left_->program, left_->stored.t, {}, {}, {}, instant_};
  for (std::size_t i = 0; i < n; ++i) {
    const double by_time = left_->departure.rates[i] * instant_;
    arrival.x.push_back(x[i]);
    arrival.moved.push_back(x[n + i] + by_time);
    arrival.terms.push_back(std::abs(x[n + i]) + std::abs(by_time));
  }
  arrivals_[contact].add(std::move(arrival), of_.size);
}

bool ModeVariation::close(std::size_t contact, const Accumulation& series) {
  const std::optional<Arrival> limit = limit_of(arrivals_[contact], series);
  if (!limit || limit->program != left_->program) return false;
  // Of several contacts that close at one instant all states come to the limit of the first, if that of the others is
  // at its time.
  constexpr double kSameTime = 0.01;
  if (end_ && std::abs(limit->t - *end_) > kSameTime * (*end_ - left_->stored.t)) return false;
  arrivals_.erase(contact);
  closed_.push_back(contact);
  if (end_) return true;
  const std::size_t n = limit->x.size();
  for (std::size_t i = 0; i < n; ++i) {
    left_->departure.x[i] = limit->x[i];
    left_->departure.x[n + i] = limit->moved[i];
    left_->departure.rates[i] = 0.0;
  }
  instant_ = limit->instant;
  end_ = limit->t;
  return true;
}

void ModeVariation::tie(const Program& program, const std::vector<double>& parameters) {
  steps_.push_back({&program, parameters, nullptr, nullptr, {}});
}

std::optional<Stored> ModeVariation::before(double h, double t) const {
  if (!left_) return of_.start(h);
  const Departure& from = left_->departure;
  std::vector<double> x = from.x;
  const std::size_t n = left_->program->varied_states;
  for (std::size_t i = 0; i < n; ++i) x[i] += h * (from.x[n + i] + from.rates[i] * instant_);
  Evaluator evaluator(*left_->program, moved(left_->parameters, h));
  Branch branch = from.branch;
  Stored stored = left_->stored;
  if (!put_all(evaluator, t, x, branch, stored)) return std::nullopt;
  return stored;
}

std::vector<double> ModeVariation::moved(std::vector<double> parameters, double h) const {
  for (std::size_t i = 0; i < of_.parameters.size(); ++i) parameters[i] += h * of_.parameters[i];
  return parameters;
}

/// By diode: the speeds with which contacts separate after an impact, by those with which they close before it; 0 for
/// the others.
std::optional<std::vector<double>> ModeVariation::kicks(const Step& step, double h, double t,
                                                        const Stored& stored) const {
  std::vector<double> own = moved(inputs_.parameters, h);
  own.resize(step.network->program.model->parameters.size(), 0.0);
  const std::size_t n = step.kicked.size();
  KeptEvaluators evaluators;
  NetworkSlopes network(
      *step.network, own, t, stored, [](const StateInfo&) { return 0.0; }, evaluators);
  // The speed of a contact that takes an impulse depends on no effort, so on no resistance or source either.
  static_cast<void>(network.look(std::vector<double>(n, 1.0), std::vector<double>(n, 0.0)));
  if (!network.has_rates()) return std::nullopt;
  std::vector<double> result(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (!step.kicked[i]) continue;
    result[i] = std::max(0.0, -network.speed(i)) * network.restitution(i);
    if (!std::isfinite(result[i])) return std::nullopt;
  }
  return result;
}

bool ModeVariation::set_kicks(const Step& step, double h, double t, const Stored& stored,
                              std::vector<double>& parameters) const {
  const auto kicks = this->kicks(step, h, t, stored);
  if (!kicks) return false;
  for (std::size_t i = 0, contact = 0; i < kicks->size(); ++i)
    if (step.network->displacements[i].valid()) parameters[step.impact->kicks[contact++].index()] = (*kicks)[i];
  return true;
}

std::string ModeVariation::begins_to_rebound(double h, double t) const {
  if (std::none_of(steps_.begin(), steps_.end(), [](const Step& step) { return step.lands; })) return {};
  const double then = t + h * instant_;
  std::optional<Stored> stored = before(h, then), here = before(0.0, t);
  for (const Step& step : steps_) {
    if (!stored || !here) return {};
    if (step.lands) {
      const auto without = kicks(step, 0.0, t, *here), with = kicks(step, h, then, *stored);
      for (std::size_t i = 0; without && with && i < with->size(); ++i)
        if ((*without)[i] == 0.0 && (*with)[i] != 0.0) return step.network->names[i];
    }
    if (!take(step, h, then, *stored) || !take(step, 0.0, t, *here)) return {};
  }
  return {};
}

bool ModeVariation::take(const Step& step, double h, double t, Stored& stored) const {
  std::vector<double> parameters = moved(step.parameters, h);
  parameters.resize(step.program->model->parameters.size(), 0.0);
  if (step.impact != nullptr && !set_kicks(step, h, t, stored, parameters)) return false;
  Evaluator evaluator(*step.program, parameters);
  const Jump jump = jump_into(evaluator, t, stored);
  if (jump.failure) return false;
  Branch branch = first_branch(*step.program);
  return evaluator.initialize_modes(t, jump.x.data(), branch) && put_all(evaluator, t, jump.x, branch, stored);
}

std::vector<double> ModeVariation::at(double h, double t, const Step& last) const {
  const double then = t + h * instant_;
  std::optional<Stored> stored = before(h, then);
  bool known = stored.has_value();
  for (std::size_t i = 0; known && i < steps_.size(); ++i) known = take(steps_[i], h, then, *stored);
  if (!known || !take(last, h, then, *stored)) return {};
  std::vector<double> x;
  for (std::size_t i = 0; i < last.program->varied_states; ++i) x.push_back(value_of(*stored, last.program->states[i]));
  return x;
}

/// A thousandth of what moves most beside its size.
double ModeVariation::step_size() const {
  constexpr double kPart = 1e-3;
  double most = 0.0;
  const auto look = [&](double slope, double size) {
    if (size > 0.0) most = std::max(most, std::abs(slope) / size);
  };
  for (std::size_t i = 0; i < of_.parameters.size(); ++i) look(of_.parameters[i], std::abs(inputs_.parameters[i]));
  look(instant_, inputs_.stop - inputs_.start);
  if (left_) {
    const std::size_t n = left_->program->varied_states;
    for (std::size_t i = 0; i < n; ++i) {
      const double scale = i < left_->scales.size() ? left_->scales[i] : 0.0;
      const double size = std::max(std::abs(left_->departure.x[i]), scale);
      look(left_->departure.x[n + i] + left_->departure.rates[i] * instant_, size);
    }
  } else if (of_.size > 0.0) {
    look(1.0, of_.size);
  }
  return most > 0.0 ? kPart / most : kPart;
}

/// How far diodes are beyond their borders at the start, with what is varied moved by @p h.
double ModeVariation::beyond(double h, double t, const Step& last) const {
  const Program& program = *last.program;
  std::vector<double> x = at(h, t, last), values(4 * program.diode_elements.size());
  if (x.empty()) return 0.0;
  x.resize(program.states.size(), 0.0);
  Evaluator evaluator(program, moved(last.parameters, h));
  Branch branch = first_branch(program);
  if (!evaluator.initialize_modes(t, x.data(), branch) || !evaluator.diodes(t, x.data(), branch, values.data()))
    return 0.0;
  double most = 0.0;
  for (std::size_t i = 0; i < program.diode_elements.size(); ++i) {
    const Element& element = program.model->elements[program.diode_elements[i].index()];
    const double effort = values[4 * i], flow = values[4 * i + 1], threshold = values[4 * i + 2];
    double off = is_closed(element) ? -flow : effort - threshold;
    // A closed contact stays at its gap: the flow of diodes() is the room that is left there.
    if (element.contact && !is_closed(element)) off = std::max(off, std::abs(flow));
    most = std::max(most, off);
  }
  return most;
}

/// Whether a diode is at its border as the run begins, and another value of the parameter takes it across: then it is
/// beyond it by a part of that change. What rounding makes of a diode that carries nothing is no such part.
bool ModeVariation::begins_at_border(double h, double t, const Step& last) const {
  constexpr double kPart = 0.25, kLeast = 0.75, kMost = 1.25;
  for (const double side : {1.0, -1.0}) {
    const double a = beyond(side * h, t, last), b = beyond(side * kPart * h, t, last),
                 c = beyond(side * kPart * kPart * h, t, last);
    const auto of = [&](double less, double more) {
      return less > kLeast * kPart * more && less < kMost * kPart * more;
    };
    if (a > 0.0 && of(b, a) && of(c, b)) return true;
  }
  return false;
}

/// Central differences over h, h/2 and h/4, whose errors go with h^2: of two of them one whose error goes with h^4.
std::optional<Diagnostic> ModeVariation::differentiate(double h, double t, const Step& last,
                                                       const std::vector<double>& sizes, std::vector<double>& x) const {
  constexpr int kLevels = 3;
  constexpr double kAgree = 1e-5, kRounding = 1e-12;  // of jumps, whose iteration ends at 1e-13
  const std::size_t n = sizes.size();
  std::vector<std::vector<double>> slope;
  for (int level = 0; level < kLevels; ++level, h *= 0.5) {
    const std::vector<double> above = at(h, t, last), below = at(-h, t, last);
    if (above.size() != n || below.size() != n)
      return refusal(t, "the jump of the stores has no value beside this value of the parameter",
                     "a derivative exists where the jump does");
    slope.emplace_back();
    for (std::size_t i = 0; i < n; ++i) slope.back().push_back((above[i] - below[i]) / (2.0 * h));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double one = (4.0 * slope[1][i] - slope[0][i]) / 3.0, other = (4.0 * slope[2][i] - slope[1][i]) / 3.0;
    if (!(std::abs(one - other) <= kAgree * std::max(std::abs(one), std::abs(other)) + kRounding * sizes[i] / h))
      return refusal(t, "the jump of the stores has a kink at this value of the parameter",
                     "a derivative exists where both sides have the same one");
    x[n + i] = other;
  }
  return std::nullopt;
}

/// Behind the end T of the impacts s = d - f+(T) T'; the run begins the mode earlier, at t, and subtracts f+(t) T'.
std::optional<Diagnostic> ModeVariation::take_back(const Program& program, const std::vector<double>& parameters,
                                                   double t, const std::vector<double>& limit,
                                                   std::vector<double>& x) const {
  const std::size_t n = program.varied_states;
  Evaluator evaluator(program, parameters);
  std::vector<double> there = x, rates(x.size());
  std::copy(limit.begin(), limit.end(), there.begin());
  const auto look = [&](double at, const std::vector<double>& states) {
    Branch branch = first_branch(program);
    return evaluator.initialize_modes(at, states.data(), branch) &&
           evaluator.rates(at, states.data(), branch, rates.data());
  };
  if (!look(*end_, there)) return fault_failure(evaluator.fault());
  for (std::size_t i = 0; i < n; ++i) there[n + i] -= rates[i] * instant_;
  if (!look(*end_, there)) return fault_failure(evaluator.fault());
  for (std::size_t i = 0; i < n; ++i) there[n + i] -= (*end_ - t) * rates[n + i];
  if (!look(t, x)) return fault_failure(evaluator.fault());
  for (std::size_t i = 0; i < n; ++i) x[n + i] = there[n + i] + rates[i] * instant_;
  return std::nullopt;
}

std::optional<Diagnostic> ModeVariation::enter(const Program& program, const std::vector<double>& parameters, double t,
                                               const std::vector<double>& scales, std::vector<double>& x) {
  const Step last{&program, parameters, nullptr, nullptr, {}};
  const std::size_t n = program.varied_states;
  // Before the end of many impacts the run is some flights short of it, of 2e-6 of the longest one.
  constexpr double kSame = 1e-9, kSameAtEnd = 1e-2;
  const double then = end_.value_or(t);
  double h = step_size();
  std::vector<double> sizes;
  for (std::size_t i = 0; i < n; ++i) sizes.push_back(std::max(std::abs(x[i]), i < scales.size() ? scales[i] : 0.0));
  const std::vector<double> here = at(0.0, then, last);
  bool same = here.size() == n;
  for (std::size_t i = 0; same && i < n; ++i) same = std::abs(here[i] - x[i]) <= (end_ ? kSameAtEnd : kSame) * sizes[i];
  if (!same)
    return refusal(t, "the jump of the stores is not what the mode alone makes of them",
                   "sensitivities cross a change of the mode by the jump of its stores");
  for (const double side : {h, -h})
    if (const std::string contact = begins_to_rebound(side, then); !contact.empty())
      return refusal(t,
                     "the contact \"" + contact + "\" does not rebound, and would with another value of the parameter",
                     "a restitution is not below 0: there is a derivative to one side only");
  // A diode of the start that another value of the parameter turns is no kink where it is far enough away.
  constexpr double kNearer = 1.0 / 32.0;
  constexpr int kTimes = 3;
  std::optional<Diagnostic> refused;
  for (int k = 0; k < kTimes; ++k, h *= kNearer) {
    refused = differentiate(h, then, last, sizes, x);
    if (!refused) break;
  }
  if (refused) return refused;
  if (end_) {
    if (auto fault = take_back(program, parameters, t, here, x)) return fault;
    end_.reset();
  }
  if (!(t > inputs_.start) && !program.diode_elements.empty() && begins_at_border(h, t, last))
    return refusal(t, "a diode or contact is at its border as the scene begins, and this parameter takes it across",
                   "a derivative exists where both sides have the same one");
  steps_.clear();
  return std::nullopt;
}

}  // namespace bgsim
