#include "run/sink/energy_audit.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

namespace {

constexpr std::size_t kMostPoints = kMostGaussPoints;
constexpr std::size_t kFine =
    16;  ///< parts of a piece on which a power that changes its sign is taken as a straight line

/// Integral over a unit of |a straight line from a to b|.
double magnitude_of_line(double a, double b) {
  const double mean = (std::abs(a) + std::abs(b)) / 2;
  const bool crosses = (a < 0.0) != (b < 0.0);
  return crosses && mean > 0.0 ? (a * (a / mean) + b * (b / mean)) / 4 : mean;
}

}  // namespace

EnergyAuditor::Rule EnergyAuditor::rule_with(int points) {
  Rule rule{gauss_rule(points), {}};
  const std::vector<double>& at = rule.position;
  // Lagrange's polynomial through the points.
  for (std::size_t k = 0; k <= kFine; ++k) {
    const double fine = static_cast<double>(k) / kFine;
    std::vector<double> row(at.size(), 1.0);
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t j = 0; j < at.size(); ++j)
        if (j != i) row[i] *= (fine - at[j]) / (at[i] - at[j]);
    rule.fine.push_back(std::move(row));
  }
  return rule;
}

const std::vector<EnergyAuditor::Rule>& EnergyAuditor::all_rules() {
  static const std::vector<Rule> rules{rule_with(1), rule_with(2), rule_with(3), rule_with(4),
                                       rule_with(5), rule_with(6), rule_with(7)};
  return rules;
}

void CompensatedSum::add(double value) {
  const double next = sum + value;
  lost += std::abs(sum) >= std::abs(value) ? (sum - next) + value : (value - next) + sum;
  sum = next;
}

EnergyAuditor::EnergyAuditor(const Program& program, Evaluator& evaluator, const RunInputs& inputs, bool wanted)
    : program_(program),
      evaluator_(evaluator),
      measuring_(wanted && !program.energy_roles.empty()),
      longest_((inputs.stop - inputs.start) / kMostPieces),
      together_(evaluator.powers_together()),
      rules_(all_rules()),
      stretch_(program.powers.results.size()),
      activity_(program.energy_roles.size()),
      samples_(program.powers.results.size() * kMostPoints),
      total_(program.powers.results.size()),
      energy_before_(program.energy_roles.size()),
      energy_after_(program.energy_roles.size()) {
  for (std::size_t k = 0; k < (together_ ? Evaluator::Points::kMost : 1); ++k) {
    y_[k].resize(evaluator.states() + evaluator.tears());
    power_[k].resize(program.powers.results.size());
  }
  if (!wanted) why_not_ = "switched off";
  if (wanted && program.energy_roles.empty()) why_not_ = "no element of the run exchanges energy";
  const std::size_t ports = program.first_displacement.empty() ? 0 : program.first_displacement.back();
  displaced_before_.resize(ports);
  displaced_after_.resize(ports);
}

std::size_t EnergyAuditor::rule_for(int order) const {
  const int points = std::clamp(order / 2 + 1, 1, kMostGaussPoints);
  return static_cast<std::size_t>(points - 1);
}

void EnergyAuditor::begin(double t, const double* x, const Branch& branch) {
  const Stopwatch watch(seconds_);
  branch_ = branch;
  audited_ = t;
  if (!measuring_) return;
  if (!evaluator_.stored(t, x, branch_, energy_before_.data()) ||
      (!displaced_before_.empty() && !evaluator_.displacements(t, x, branch_, displaced_before_.data())))
    give_up("the stored energy at the start could not be evaluated: " + evaluator_.fault().what);
  if (record_times_.empty() || !measuring_) return;
  for (auto* const term :
       {&course_.times, &course_.supplied, &course_.stored, &course_.dissipated, &course_.exchanged, &course_.residual})
    term->assign(1, term == &course_.times ? t : 0.0);
}

void EnergyAuditor::start_stretch() { std::fill(stretch_.begin(), stretch_.end(), 0.0); }

/// The powers at the point that is in y_[k].
bool EnergyAuditor::see_powers(double t, std::size_t k) {
  if (evaluator_.powers(t, y_[k].data(), branch_, power_[k].data())) return true;
  const Fault& fault = evaluator_.fault();
  give_up("a power could not be evaluated: " + fault.what + " (" + fault.target + ")");
  return false;
}

void EnergyAuditor::add_point(std::size_t point, std::size_t k, double t, double weight) {
  const std::vector<double>& power = power_[k];
  for (std::size_t i = 0; i < power.size(); ++i) {
    stretch_[i] += weight * power[i];
    samples_[i * kMostPoints + point] = power[i];
    if (i >= program_.energy_roles.size()) continue;
    if (program_.energy_roles[i] == EnergyPart::Role::source) {
      gross_source_ += weight * std::abs(power[i]);
    } else if (program_.energy_roles[i] == EnergyPart::Role::dissipator) {
      gross_dissipation_ += weight * std::abs(power[i]);
      take_least(i, k, t);
    }
  }
}

/// Remembers the smallest power of a dissipator. A negative one counts as far as rounding cannot have made it: a
/// resistor at rest between large efforts is not active.
void EnergyAuditor::take_least(std::size_t part, std::size_t k, double t) {
  double power = power_[k][part];
  if (least_part_ && power >= least_power_) return;
  if (power < 0.0) {
    if (rounding_at_ != t) {
      rounding_.resize(power_[k].size());
      evaluator_.power_rounding(t, y_[k].data(), branch_, rounding_.data());
      rounding_at_ = t;
    }
    if (power >= -rounding_[part]) power = 0.0;
  }
  if (least_part_ && power >= least_power_) return;
  least_part_ = part;
  least_power_ = power;
}

/// Integrals of |power|. Gauss' rule is exact enough while a power keeps its sign; where it changes it, a rule that
/// knows nothing of the kink would be wrong by the square of the step.
void EnergyAuditor::add_activities(const Rule& rule, double length) {
  const std::size_t points = rule.position.size();
  for (std::size_t i = 0; i < activity_.size(); ++i) {
    const double* const sample = samples_.data() + i * kMostPoints;
    const auto value = [&](std::size_t k) {
      double sum = 0.0;
      for (std::size_t p = 0; p < points; ++p) sum += rule.fine[k][p] * sample[p];
      return sum;
    };
    double integral = 0.0;
    double least = std::min(value(0), value(kFine)), most = std::max(value(0), value(kFine));
    for (std::size_t p = 0; p < points; ++p) {
      integral += rule.weight[p] * sample[p];
      least = std::min(least, sample[p]);
      most = std::max(most, sample[p]);
    }
    if (least < 0.0 && most > 0.0) {
      integral = 0.0;
      for (std::size_t k = 0; k < kFine; ++k) integral += magnitude_of_line(value(k), value(k + 1)) / kFine;
    }
    activity_[i] += length * std::abs(integral);
  }
}

void EnergyAuditor::finish_stretch() {
  double gained = 0.0, lost = 0.0;
  const auto count = [&](std::size_t i) {
    const double change = total_[i].value();
    (change > 0.0 ? gained : lost) += std::abs(change);
  };
  for (std::size_t i = 0; i < stretch_.size(); ++i) total_[i].add(stretch_[i]);
  for (std::size_t part = 0; part < program_.energy_roles.size(); ++part) {
    if (program_.energy_roles[part] != EnergyPart::Role::store) continue;
    const std::uint32_t first = program_.first_port_power[part], last = program_.first_port_power[part + 1];
    if (first == last) count(part);
    for (std::uint32_t port = first; port < last; ++port) count(port);
  }
  swing_ = std::max({swing_, gained, lost});
}

void EnergyAuditor::give_up(const std::string& why) {
  measuring_ = false;
  why_not_ = why;
}

void EnergyAuditor::before_jump(double t, const double* x, const Branch& branch) {
  branch_ = branch;
  if (!measuring_ || !look_at_stores(t, x, "before an event")) return;
  energy_at_jump_ = energy_after_;
  displaced_at_jump_ = displaced_after_;
}

double EnergyAuditor::after_jump(double t, const double* x, const Branch& branch) {
  branch_ = branch;
  if (!measuring_ || !look_at_stores(t, x, "after an event")) return 0.0;
  double brought = 0.0;
  for (std::size_t part = 0; part < program_.energy_roles.size(); ++part) {
    if (program_.energy_roles[part] != EnergyPart::Role::store) continue;
    const double change = change_of_store(part, energy_at_jump_, displaced_at_jump_).value_or(0.0);
    brought += change;
    gross_events_ += std::abs(change);
  }
  by_events_.add(brought);
  return brought;
}

/// What the store says it took in since it had @p energy and held @p displaced; none if its energy is no function of
/// its state alone.
std::optional<double> EnergyAuditor::change_of_store(std::size_t part, const std::vector<double>& energy,
                                                     const std::vector<double>& displaced) const {
  if (program_.energy_modulated[part]) return std::nullopt;
  if (!std::isnan(energy[part])) return energy_after_[part] - energy[part];
  const std::size_t first = program_.first_displacement[part];
  const std::size_t count = program_.first_displacement[part + 1] - first;
  const double change = evaluator_.energy_by_laws(part, std::span(displaced).subspan(first, count),
                                                  std::span(displaced_after_).subspan(first, count));
  return std::isnan(change) ? std::nullopt : std::optional(change);
}

/// What the stores say they hold now. False, and the audit is given up, if that has no value.
bool EnergyAuditor::look_at_stores(double t, const double* x, const char* when) {
  if (evaluator_.stored(t, x, branch_, energy_after_.data()) &&
      (displaced_after_.empty() || evaluator_.displacements(t, x, branch_, displaced_after_.data())))
    return true;
  give_up(std::string("the stored energy ") + when + " could not be evaluated: " + evaluator_.fault().what);
  return false;
}

/// The balance from the start to where look_at_stores() last looked.
EnergyAuditor::Terms EnergyAuditor::terms() const {
  Terms terms;
  terms.residual.add(by_events_.value());
  for (std::size_t i = 0; i < program_.energy_roles.size(); ++i) {
    const double taken = total_[i].value();
    if (program_.energy_roles[i] == EnergyPart::Role::source) {
      terms.supplied.add(taken);
      terms.residual.add(taken);
      continue;
    }
    const bool store = program_.energy_roles[i] == EnergyPart::Role::store;
    const std::optional<double> change = store ? change_of_store(i) : std::nullopt;
    (change ? terms.stored : store ? terms.exchanged : terms.dissipated).add(change.value_or(taken));
    terms.residual.add(-change.value_or(taken));
  }
  return terms;
}

void EnergyAuditor::record_course(const OutputTimes& output_times, std::size_t points) {
  if (!measuring_ || points == 0 || output_times.empty()) return;
  const std::size_t stride = (output_times.size() + points - 1) / points;
  for (std::size_t i = stride; i < output_times.size(); i += stride) record_times_.push_back(output_times[i]);
  if (output_times.size() > 1 && (record_times_.empty() || record_times_.back() != output_times.back()))
    record_times_.push_back(output_times.back());
}

/// The terms at @p t, with the solution there in y_[0].
void EnergyAuditor::record(double t) {
  if (look_at_stores(t, y_[0].data(), "during the run")) append(t, terms());
}

void EnergyAuditor::append(double t, const Terms& now) {
  course_.times.push_back(t);
  course_.supplied.push_back(now.supplied.value() + by_events_.value());
  course_.stored.push_back(now.stored.value());
  course_.dissipated.push_back(now.dissipated.value());
  course_.exchanged.push_back(now.exchanged.value());
  course_.residual.push_back(now.residual.value());
}

EnergyAudit EnergyAuditor::finish(double t, const double* x, const Branch& branch) {
  const Stopwatch watch(seconds_);
  EnergyAudit audit;
  branch_ = branch;
  if (measuring_) look_at_stores(t, x, "at the end");
  audit.why_not = why_not_;
  if (!measuring_) return audit;

  const Terms end = terms();
  audit.done = true;
  audit.activity = activity_;
  audit.supplied = end.supplied.value();
  audit.stored = end.stored.value();
  audit.dissipated = end.dissipated.value();
  audit.exchanged = end.exchanged.value();
  audit.residual = end.residual.value();
  audit.events = by_events_.value();
  const double largest = std::max({gross_source_, gross_dissipation_, swing_, gross_events_, std::abs(audit.stored)});
  const bool finite = std::isfinite(largest) && std::isfinite(audit.residual) &&
                      std::all_of(activity_.begin(), activity_.end(), [](double a) { return std::isfinite(a); });
  if (!finite) {
    EnergyAudit none;
    none.why_not = "energies are beyond the range of double precision";
    return none;
  }
  if (!course_.times.empty() && course_.times.back() < t) append(t, end);
  audit.course = std::move(course_);
  audit.turnover = largest;
  audit.relative = largest > 0.0 ? std::abs(audit.residual) / largest : 0.0;
  if (least_part_) {
    audit.least_dissipation = least_power_;
    audit.least_dissipation_element = program_.energy_names[*least_part_];
  }
  return audit;
}

}  // namespace bgsim
