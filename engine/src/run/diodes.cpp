#include "run/diodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "run/complementarity.hpp"
#include "run/diode_failures.hpp"
#include "run/failures.hpp"
#include "run/jump.hpp"
#include "run/seen_resistance.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kOrders = 3;  ///< f, f', f''
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
/// Of the terms that a value is the sum of: what is left of a sum that is zero, after some hundred operations.
constexpr double kOfTerms = 256.0 * kEpsilon;
constexpr double kGolden = 0.6180339887498949;  ///< the golden ratio less 1: its multiples are spread evenly

class Sides {
 public:
  Sides(const DiodeNetwork& network, std::vector<double> parameters, double t, const Stored& stored,
        const std::function<double(const StateInfo&)>& resolution, std::vector<DiodeState> before,
        KeptEvaluators& evaluators, DiodeSight& sight, double span)
      : network_(network),
        parameters_(std::move(parameters)),
        t_(t),
        stored_(stored),
        evaluators_(evaluators),
        sight_(sight),
        span_(span),
        n_(network.resistances.size()),
        states_(network.program.states.size()) {
    result_.diodes = std::move(before);
    parameters_.resize(network.program.model->parameters.size(), 0.0);
    position_.resize((1 + kOrders) * n_ + 2 * network.contacts);
    for (const StateInfo& state : network.program.states) resolution_.push_back(resolution(state));
    for (std::size_t i = 0; i < states_; ++i) {
      const SignalId signal = network.program.states[i].signal;
      if (signal.valid() && signal.index() >= network.first_signal)
        position_[signal.index() - network.first_signal] = i;
    }
    std::size_t next = (1 + kOrders) * n_;
    contacts_.resize(n_);
    away_.assign(n_, false);
    restitution_.assign(n_, 0.0);
    closing_.assign(n_, 0.0);
    way_rounding_.assign(n_, 0.0);
    result_.room.assign(n_, 0.0);
    for (std::size_t i = 0; i < n_; ++i) {
      const SignalId displacement = network.displacements[i];
      if (!displacement.valid()) continue;
      const auto is_it = [&](const StateInfo& state) { return state.signal == displacement; };
      const auto at = std::find_if(network.program.states.begin(), network.program.states.end(), is_it);
      contacts_[i] = {next, static_cast<std::size_t>(at - network.program.states.begin())};
      next += 2;
    }
  }

  DiodeSides run(bool one) {
    if (choose_resistances() && look_at_contacts()) {
      bound_flows();
      if (one) leave_the_fastest();
      iterate();
    } else if (!result_.final) {
      open_what_is_away();
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] double sign(std::size_t diode) const { return network_.out[diode] ? -1.0 : 1.0; }
  [[nodiscard]] double source_value(std::size_t diode) const {
    return result_.diodes[diode].effort - resistance_[diode] * result_.diodes[diode].flow;
  }
  /// Of a diode's own flow, or a derivative of it, by its source.
  [[nodiscard]] double own_slope(std::size_t diode, std::size_t order) const {
    return slope_[(diode * kOrders + order) * n_ + diode];
  }
  [[nodiscard]] std::size_t source(std::size_t diode) const { return position_[diode]; }
  [[nodiscard]] std::size_t flow(std::size_t diode, std::size_t order) const {
    return position_[n_ + kOrders * diode + order];
  }

  bool fail_for_good(Diagnostic diagnostic) {
    result_.final = true;
    return fail(std::move(diagnostic));
  }
  bool fail(Diagnostic diagnostic) {
    result_.failure = std::move(diagnostic);
    return false;
  }

  /// Flows and their derivatives as they depend on the sources, at the present ones.
  /// @param aside  with each store off by what it may be off, and by a part more than the one before it: two stores
  ///               off by the same would leave what is between them as it was
  bool linearize(bool aside = false) {
    for (std::size_t i = 0; i < n_; ++i) parameters_[network_.resistances[i].index()] = resistance_[i];
    Evaluator& evaluator = evaluators_.of(network_.program, parameters_);
    const Jump jump = jump_into(evaluator, t_, stored_);
    if (jump.failure) return fail(*jump.failure);
    x_ = jump.x;
    for (std::size_t c = 0; aside && c < states_; ++c) {
      const double part = 1.0 + std::fmod(kGolden * static_cast<double>(c), 1.0);
      x_[c] += part * (resolution_[c] + 16.0 * kEpsilon * std::abs(x_[c]));
    }
    for (std::size_t i = 0; i < n_; ++i) x_[source(i)] = sign(i) * source_value(i);
    Branch branch = first_branch(network_.program);
    rates_.assign(states_, 0.0);
    has_rates_ = false;
    const Sparsity& pattern = network_.program.jacobian_pattern;
    std::vector<double> values(pattern.row.size());
    std::vector<std::string> found;
    const bool started =
        evaluator.initialize_modes(t_, x_.data(), branch) ||
        (evaluator.explore_loops(t_, x_.data(), branch, found) && evaluator.initialize_modes(t_, x_.data(), branch));
    std::vector<double> rounding;
    has_rates_ = started && evaluator.rates(t_, x_.data(), branch, rates_.data());
    const bool done = has_rates_ && evaluator.slopes(t_, x_.data(), branch, values.data(), rounding);
    diodes_.resize(4 * n_);
    if (!done || !evaluator.diodes(t_, x_.data(), branch, diodes_.data()))
      return fail(fault_failure(evaluator.fault()));
    for (std::size_t i = 0; i < n_; ++i)
      if (!result_.diodes[i].may_begin) result_.diodes[i].may_begin = diodes_[4 * i + 3] != 0.0;
    slope_.assign(kOrders * n_ * n_, 0.0);
    at_zero_.assign(kOrders * n_, 0.0);
    size_.assign(kOrders * n_, 0.0);
    off_.assign(kOrders * n_, 0.0);
    shifts_.clear();
    std::vector<std::size_t> row_of(states_, kOrders * n_), source_of(states_, n_);
    for (std::size_t i = 0; i < n_; ++i) {
      source_of[source(i)] = i;
      for (std::size_t k = 0; k < kOrders; ++k) row_of[flow(i, k)] = i * kOrders + k;
    }
    std::vector<double> linear(kOrders * n_, 0.0);
    for (std::size_t column = 0; column < states_; ++column)
      for (auto at = pattern.column_start[column]; at < pattern.column_start[column + 1]; ++at) {
        const std::size_t row = row_of[static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(at)])];
        if (row == kOrders * n_) continue;
        // A law may begin with a slope without bound, where what it is the slope of is 0.
        const double term = x_[column] == 0.0 ? 0.0 : values[static_cast<std::size_t>(at)] * x_[column];
        linear[row] += term;
        size_[row] += std::abs(term);
        if (resolution_[column] > 0.0)
          shifts_.push_back({row, column, std::abs(values[static_cast<std::size_t>(at)]) * resolution_[column]});
        if (source_of[column] < n_) {
          const std::size_t j = source_of[column];
          slope_[row * n_ + j] = sign(row / kOrders) * sign(j) * values[static_cast<std::size_t>(at)];
        }
      }
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t k = 0; k < kOrders; ++k) {
        const std::size_t row = i * kOrders + k;
        const double value = rates_[flow(i, k)];
        // Terms that cancel need not stand in the slopes: the flow into a part that a diode alone connects is 0.
        if (!rounding.empty()) off_[row] += rounding[flow(i, k)];
        size_[row] += std::abs(value - linear[row]);
        at_zero_[row] = sign(i) * value;
        for (std::size_t j = 0; j < n_; ++j) at_zero_[row] -= slope_[row * n_ + j] * source_value(j);
      }
    evaluator_ = &evaluator;
    branch_ = std::move(branch);
    return true;
  }

  /// What states that are off make of the flows: by the slopes, but no more than they change by. Where a law begins
  /// with a slope without bound, a flow moves by the root of what a store is off, and its slope there says any number.
  void bound_flows() {
    constexpr double kMatters = 1e-3;  // of the sizes of flows; below that slopes are good enough
    std::vector<double> moved = x_, moved_rates(states_);
    for (auto first = shifts_.begin(), last = first; first != shifts_.end(); first = last) {
      const std::size_t column = first->column;
      last = std::find_if(first, shifts_.end(), [column](const Shift& at) { return at.column != column; });
      const bool matters =
          std::any_of(first, last, [this](const Shift& at) { return at.by_slope > kMatters * size_[at.row]; });
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
        off_[at->row] += known ? std::min(at->by_slope, most[static_cast<std::size_t>(at - first)]) : at->by_slope;
    }
  }

  /// Which contacts touch, and at what speed they close. False if one is beyond its gap.
  bool look_at_contacts() {
    // One that has come to its gap is there as far as the tolerance says; the rest is rounding.
    constexpr double kBeyond = 1e-9, kFar = 1e-6, kTouching = 1e3;
    // What all ways are resolved to: balls of a cradle that only touch have no way of their own, and a room of
    // roundings.
    double longest = 0.0;
    for (std::size_t i = 0; i < n_; ++i) {
      if (!network_.displacements[i].valid()) continue;
      const double q = x_[contacts_[i].state];
      longest = std::max({longest, std::abs(q), std::abs(rates_[position_[contacts_[i].signal]] + q)});
    }
    for (std::size_t i = 0; i < n_; ++i) {
      if (!network_.displacements[i].valid()) continue;
      const double room = rates_[position_[contacts_[i].signal]], q = x_[contacts_[i].state];
      const double size = std::abs(q) + std::abs(room + q);
      const bool touches = result_.diodes[i].touches;
      // The time of an event is known to its rounding, and the flow to that of its terms.
      const double moves = size_[i * kOrders] * std::abs(t_);
      const double off = resolution_[contacts_[i].state] + 8.0 * kEpsilon * (size + moves + longest);
      way_rounding_[i] = 8.0 * kEpsilon * (size + moves + longest);
      // The displacement of a closed one is the integral of der(gap), and a jump of the gap refused with BG402: what
      // is left of the difference is the method's, and put to 0.
      const bool closed = touches && !result_.diodes[i].conducts;
      if (!closed && room < (touches ? -std::max(kTouching * off, kFar * size) : -std::max(off, kBeyond * size)))
        return fail_for_good(beyond_gap_failure(network_, i, t_, q, room + q));
      away_[i] = !touches && room > off;
      if (away_[i]) {
        result_.diodes[i].effort = result_.diodes[i].flow = 0.0;
        continue;
      }
      result_.room[i] = room;
      restitution_[i] = rates_[position_[contacts_[i].signal + 1]];
      if (!(restitution_[i] >= 0.0 && restitution_[i] <= 1.0))
        return fail_for_good(restitution_failure(network_, i, t_, restitution_[i]));
      // Where efforts can change its speed at once, there is no impact.
      const auto row = slope_.begin() + static_cast<std::ptrdiff_t>(i * kOrders * n_);
      const bool of_stores = std::all_of(row, row + static_cast<std::ptrdiff_t>(n_), [](double s) { return s == 0.0; });
      closing_[i] = of_stores ? std::max(0.0, -sign(i) * rates_[flow(i, 0)]) : 0.0;
      if (result_.diodes[i].sticks) restitution_[i] = 0.0;
    }
    return true;
  }

  /// Where the slopes are not known, those contacts that are away from their gaps have no part in what is to be tried;
  /// where not even the gaps are, those that have not come to theirs.
  void open_what_is_away() {
    for (std::size_t i = 0; i < n_; ++i) {
      if (!network_.displacements[i].valid()) continue;
      DiodeState& contact = result_.diodes[i];
      if (has_rates_) {
        const double room = rates_[position_[contacts_[i].signal]], q = x_[contacts_[i].state];
        const double off = resolution_[contacts_[i].state] + 8.0 * kEpsilon * (std::abs(q) + std::abs(room + q));
        contact.touches = contact.touches || !(room > off);
      }
      if (!contact.touches) contact.conducts = true;
    }
  }

  /// Of the contacts that close beyond rounding, the one that does so fastest; all others do not push here.
  void leave_the_fastest() {
    constexpr double kTimes = 10.0;
    std::size_t fastest = n_;
    for (std::size_t i = 0; i < n_; ++i) {
      const std::size_t row = i * kOrders;
      if (!(closing_[i] > kTimes * (off_[row] + kOfTerms * size_[row]))) continue;
      if (fastest == n_ || closing_[i] > closing_[fastest]) fastest = i;
    }
    for (std::size_t i = 0; i < n_ && fastest < n_; ++i) {
      if (!network_.displacements[i].valid() || away_[i] || i == fastest) continue;
      away_[i] = true;
      restitution_[i] = closing_[i] = result_.diodes[i].effort = result_.diodes[i].flow = 0.0;
    }
  }

  /// Resistances at which something is seen of the circuits, whatever an effort and a flow of 1 are beside their own.
  /// From the largest down to where the slope of a flow is not known: that of an orifice at rest, e = k f |f|, is the
  /// root of what the stores are off by, and through less than that the scan sees an error and takes it for a circuit.
  void scan_resistances() {
    constexpr int kFarthest = 36, kStep = 3;  // powers of ten; what is beyond is beyond the units of any model
    constexpr double kSame = 1e-2;
    std::vector<std::vector<SlopesThrough>> scans(n_);
    for (int power = kFarthest; power >= -kFarthest; power -= kStep) {
      const double r = std::pow(10.0, power);
      resistance_.assign(n_, r);
      const bool has_value = linearize(true);
      const std::vector<double> aside = slope_;
      if (!has_value || !linearize()) {  // a law that has no value there
        result_.failure.reset();
        continue;
      }
      bool known = true;
      for (std::size_t i = 0; i < n_; ++i)
        known = known && std::abs(own_slope(i, 0) - aside[i * kOrders * n_ + i]) <= kSame * std::abs(own_slope(i, 0));
      if (!known && !scans.front().empty()) break;
      if (!known) continue;
      for (std::size_t i = 0; i < n_; ++i) {
        SlopesThrough at{r, {}};
        for (std::size_t k = 0; k < kOrders; ++k) at.slopes[k] = own_slope(i, k);
        if (std::abs(at.slopes[0]) <= kOfTerms / r) at.slopes[0] = 0.0;
        scans[i].push_back(at);
      }
    }
    for (std::vector<SlopesThrough>& scan : scans) std::reverse(scan.begin(), scan.end());
    for (std::size_t i = 0; i < n_; ++i) resistance_[i] = seen_resistance(scans[i], span_);
  }

  /// Whether the slopes at the resistances chosen last are other ones now, as those of laws that are not linear are:
  /// the circuit may have another size.
  [[nodiscard]] bool has_moved() const {
    constexpr double kSame = 1e-9;
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t k = 0; k < kOrders; ++k) {
        const double before = sight_.slopes[i * kOrders + k], now = std::abs(own_slope(i, k));
        if (!(std::abs(now - before) <= kSame * (now + before))) return true;
      }
    return false;
  }

  /// Resistances of about what the diodes see, so that neither of both is lost in rounding; those of before where the
  /// laws are what they were.
  bool choose_resistances() {
    if (!sight_.resistances.empty()) {
      resistance_ = sight_.resistances;
      if (!linearize()) return false;
      if (!has_moved()) return true;
    }
    scan_resistances();
    if (!raise_resistances()) return false;
    sight_.resistances = resistance_;
    sight_.slopes.clear();
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t k = 0; k < kOrders; ++k) sight_.slopes.push_back(std::abs(own_slope(i, k)));
    return true;
  }

  /// To what the flow itself sees, where that is larger than what was chosen.
  bool raise_resistances() {
    // In a row or side by side diodes see each other, and a share of 1/n says nothing of the circuit.
    const double small = std::min(1e-2, 0.5 / static_cast<double>(n_));
    constexpr int kMost = 6;
    for (int step = 0;; ++step) {
      if (!linearize()) return false;
      bool raised = false;
      for (std::size_t i = 0; i < n_ && step < kMost; ++i) {
        const double share = -own_slope(i, 0) * resistance_[i];  // of r in what the source sees
        if (!(share < small && share > kOfTerms)) continue;
        resistance_[i] /= share;
        raised = true;
      }
      if (!raised) return true;
    }
  }

  /// Known below the first order without a number: a law of |f|^1.75 has no second slope at 0.
  static PowerSeries series(std::array<double, kOrders> values, std::array<double, kOrders> rounding) {
    std::size_t known = 0;
    while (known < kOrders && std::isfinite(values[known]) && std::isfinite(rounding[known])) ++known;
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(known), values.end(), 0.0);
    std::fill(rounding.begin() + static_cast<std::ptrdiff_t>(known), rounding.end(), 0.0);
    return PowerSeries::of<kOrders>(values, rounding, false).known_below(static_cast<int>(known));
  }

  [[nodiscard]] Complementarity problem() {
    // z - F(s) = 0 with s = e0 - r z - w gives (1 + F' r) z + F' w = F(0) + F' e0.
    Complementarity problem;
    problem.size = n_;
    problem.z.resize(n_);
    problem.w.resize(n_);
    problem.r.resize(n_);
    effort_size_.assign(n_, 0.0);
    result_.flow_off.assign(n_, 0.0);
    result_.effort_off.assign(n_, 0.0);
    result_.flow_error.assign(n_, 0.0);
    result_.effort_error.assign(n_, 0.0);
    for (std::size_t i = 0; i < n_; ++i) {
      std::array<double, kOrders> largest{};
      for (std::size_t k = 0; k < kOrders; ++k)
        for (std::size_t j = 0; j < n_; ++j)
          largest[k] = std::max(largest[k], std::abs(slope_[(i * kOrders + k) * n_ + j]));
      // With a resistance of r in series no slope is larger than 1/r; a row that is nothing but rounding is so beside
      // that: the flow into a part that nothing else connects.
      largest[0] = std::max(largest[0], 1.0 / resistance_[i]);
      std::array<double, kOrders> right{}, right_rounding{};
      for (std::size_t j = 0; j < n_; ++j) {
        std::array<double, kOrders> slope{}, rounding{};
        for (std::size_t k = 0; k < kOrders; ++k) {
          slope[k] = slope_[(i * kOrders + k) * n_ + j];
          rounding[k] = slope[k] == 0.0 ? 0.0 : 16.0 * kEpsilon * largest[k];
          right[k] += slope[k] * threshold(j);
          right_rounding[k] += kOfTerms * std::abs(slope[k] * threshold(j));
        }
        if (i != j && slope == std::array<double, kOrders>{}) continue;
        const PowerSeries f = series(slope, rounding);
        PowerSeries z = f * PowerSeries::number(resistance_[j]);
        if (i == j) z = z + PowerSeries::number(1.0);
        // A contact that is away has no effort and any flow: the other way round than what is held.
        problem.w[i].push_back({j, away_[j] ? z : f});
        problem.z[i].push_back({j, away_[j] ? f : z});
      }
      for (std::size_t k = 0; k < kOrders; ++k) {
        const std::size_t row = i * kOrders + k;
        right[k] += at_zero_[row];
        right_rounding[k] += kOfTerms * size_[row] + off_[row];
        // The time of an event is known to its rounding.
        if (k + 1 < kOrders) right_rounding[k] += 8.0 * kEpsilon * std::abs(t_) * size_[row + 1];
      }
      constexpr double kOfSize = 1e-6, kTimes = 10.0;
      const double flow_size = size_[i * kOrders] + std::abs(right[0]);
      const double r = resistance_[i];
      effort_size_[i] = r * flow_size + std::abs(threshold(i)) + std::abs(source_value(i));
      result_.flow_error[i] = kTimes * (off_[i * kOrders] + kOfTerms * flow_size);
      result_.effort_error[i] = kTimes * (r * off_[i * kOrders] + kOfTerms * effort_size_[i]);
      result_.flow_off[i] = kOfSize * flow_size + result_.flow_error[i];
      result_.effort_off[i] = kOfSize * effort_size_[i] + result_.effort_error[i];
      problem.r[i] = series(right, right_rounding);
      // Speeds of separation are counted from those of the rebound.
      for (const auto& [j, z] : problem.z[i])
        if (!away_[j] && rebound(j) > 0.0) problem.r[i] = problem.r[i] - z * PowerSeries::number(rebound(j));
    }
    scale(problem);
    return problem;
  }

  /// Flows and efforts as parts of what each diode's own come to, so that neither the units nor the part of the model
  /// that a diode is in decides what is large: by powers of two, since these do not round.
  void scale(Complementarity& problem) {
    const auto exponent = [](double size) { return size > 0.0 ? std::ilogb(size) : 0; };
    flow_exponent_.assign(n_, 0);
    effort_exponent_.assign(n_, 0);
    for (std::size_t i = 0; i < n_; ++i) {
      const double r = resistance_[i];
      flow_exponent_[i] = exponent(effort_size_[i] / r);
      effort_exponent_[i] = flow_exponent_[i] + exponent(r);
    }
    for (std::size_t i = 0; i < n_; ++i) {
      const int row = -flow_exponent_[i];
      for (auto& [j, value] : problem.z[i])
        value = value.times_two_to(row + (away_[j] ? effort_exponent_ : flow_exponent_)[j]);
      for (auto& [j, value] : problem.w[i])
        value = value.times_two_to(row + (away_[j] ? flow_exponent_ : effort_exponent_)[j]);
      problem.r[i] = problem.r[i].times_two_to(row);
    }
  }
  void scale_back(ComplementarySides& sides) {
    for (std::size_t i = 0; i < n_; ++i)
      sides.value[i] =
          sides.value[i].times_two_to((sides.takes_z[i] != away_[i] ? flow_exponent_ : effort_exponent_)[i]);
  }

  [[nodiscard]] double rebound(std::size_t diode) const { return restitution_[diode] * closing_[diode]; }
  [[nodiscard]] double threshold(std::size_t diode) const { return diodes_[4 * diode + 2]; }

  void iterate() {
    constexpr int kMostSteps = 50;
    for (int step = 0; step < kMostSteps; ++step) {
      std::vector<bool> first(n_), held(n_);
      for (std::size_t i = 0; i < n_; ++i) {
        first[i] = result_.diodes[i].conducts && !away_[i];
        held[i] =
            away_[i] || (!*result_.diodes[i].may_begin && (!result_.diodes[i].conducts || result_.diodes[i].pinned));
      }
      ComplementarySides sides = solve_complementarity(problem(), first, held);
      if (!sides.solved) {
        fail(no_sides_failure(network_, sides.unbounded, t_));
        return;
      }
      scale_back(sides);
      for (std::size_t i = 0; i < n_; ++i)
        if (away_[i]) sides.takes_z[i] = !sides.takes_z[i];
      for (std::size_t i = 0; i < n_; ++i)
        if (away_[i] && !sides.takes_z[i]) {
          fail_for_good(free_contact_failure(network_, i, t_));
          return;
        }
      if (take(sides, held)) return;
      if (!linearize()) return;
      bound_flows();
    }
    fail(
        diagnostic_of("BG622", "at t = " + number_text(t_) + " the sides of the diodes could not be found", {},
                      "with the laws linear about the flows and efforts found, the diodes come to other ones each time",
                      "a law that is not monotone is between them"));
  }

  /// Goes on to the solution. True if nothing has changed: the laws are linear, or this was the point.
  bool take(const ComplementarySides& sides, const std::vector<bool>& held) {
    constexpr double kSame = 1e-9;
    bool same = true;
    for (std::size_t i = 0; i < n_; ++i) {
      DiodeState& diode = result_.diodes[i];
      const double value = sides.value[i].finite_part();
      const double flow = (sides.takes_z[i] ? value : 0.0) + rebound(i), short_of = sides.takes_z[i] ? 0.0 : value;
      const double before = source_value(i), source = threshold(i) - resistance_[i] * flow - short_of;
      next_conducts_.resize(n_);
      next_conducts_[i] = sides.takes_z[i];
      if (!std::isfinite(source)) continue;
      same = same && std::abs(source - before) <= kSame * (std::abs(source) + std::abs(before) + effort_size_[i]);
      diode.effort = threshold(i) - short_of;
      diode.flow = flow;
    }
    // Only the sides matter. Where laws are flat at 0, as an orifice's, sources converge slowly.
    constexpr int kMostTimes = 3;
    sides_again_ = sides.takes_z == last_sides_ ? sides_again_ + 1 : 0;
    last_sides_ = sides.takes_z;
    if (!same && !is_linear() && sides_again_ < kMostTimes) return false;
    take_impulses(sides);
    take_flights(sides);
    result_.undecided.assign(n_, false);
    for (std::size_t i = 0; i < n_; ++i) {
      result_.undecided[i] = !away_[i] && sides.value[i].zero && sides.value[i].known != PowerSeries::kExact;
      result_.diodes[i].conducts = next_conducts_[i];
      // A thyristor whose flow has ended is off, even where the basis has it conduct, without a flow, since another one
      // in series with it blocks.
      const bool ended = held[i] || (!*result_.diodes[i].may_begin && sides.value[i].zero);
      result_.diodes[i].pinned = ended && !away_[i] && next_conducts_[i];
    }
    return true;
  }

  /// Efforts of order 1/h of contacts that close.
  void take_impulses(const ComplementarySides& sides) {
    std::vector<std::optional<double>> kick(n_);
    bool any = false;
    for (std::size_t i = 0; i < n_; ++i) {
      const bool impulse = !sides.takes_z[i] && !sides.value[i].zero && sides.value[i].order < 0;
      if (!network_.displacements[i].valid() || away_[i] || !impulse) continue;
      kick[i] = rebound(i);
      any = true;
    }
    if (any) result_.kick = std::move(kick);
    if (any) result_.closing = closing_;
  }

  void take_flights(const ComplementarySides& sides) {
    result_.flight.assign(n_, 0.0);
    result_.returns.assign(n_, 0.0);
    result_.least_flight = way_rounding_;
    for (std::size_t i = 0; i < n_; ++i) {
      const PowerSeries& speed = sides.value[i];
      if (!network_.displacements[i].valid() || away_[i] || !sides.takes_z[i] || speed.zero || speed.order != 0)
        continue;
      const double v = speed.coefficient[0], a = speed.coefficient[1];
      if (!(a < 0.0)) continue;
      result_.flight[i] = v * v / (-2.0 * a);
      result_.returns[i] = 2.0 * v / -a;
      result_.least_flight[i] += 8.0 * kEpsilon * v * std::abs(t_);
    }
  }

  /// Whether the flows at the new sources are what the slopes say.
  bool is_linear() {
    constexpr double kSame = 1e-9;
    const std::vector<double> slope = slope_, at_zero = at_zero_, size = size_;
    if (!linearize()) return true;
    for (std::size_t row = 0; row < slope.size() / n_; ++row) {
      if (std::abs(at_zero_[row] - at_zero[row]) > kSame * (size[row] + size_[row])) return false;
      for (std::size_t j = 0; j < n_; ++j)
        if (std::abs(slope_[row * n_ + j] - slope[row * n_ + j]) > kSame * std::abs(slope[row * n_ + j])) return false;
    }
    return true;
  }

  const DiodeNetwork& network_;
  std::vector<double> parameters_;
  double t_;
  const Stored& stored_;
  KeptEvaluators& evaluators_;
  Evaluator* evaluator_ = nullptr;  ///< at the point of the last linearization
  Branch branch_;                   ///< there
  DiodeSight& sight_;
  double span_;
  std::size_t n_, states_;
  bool has_rates_ = false;             ///< the last linearization came as far as the flows
  std::vector<std::size_t> position_;  ///< by added integral: which state
  std::vector<double> x_, rates_, diodes_;
  std::vector<double> resistance_;              ///< by diode: r
  std::vector<double> resolution_;              ///< by state
  std::vector<double> slope_, at_zero_, size_;  ///< rows: by diode, then order; in the direction that diodes pass
  struct Shift {
    std::size_t row = 0, column = 0;
    double by_slope = 0.0;  ///< how much the row moves as the state of the column is off
  };
  std::vector<Shift> shifts_;  ///< by column
  std::vector<double> off_, effort_size_;
  std::vector<int> flow_exponent_, effort_exponent_;  ///< by diode: powers of two of the problem's units
  struct Contact {
    std::size_t signal = 0, state = 0;  ///< its integrals in position_; its displacement among the states
  };
  std::vector<Contact> contacts_;              ///< by diode
  std::vector<bool> away_;                     ///< by diode: a contact that does not touch
  std::vector<double> restitution_, closing_;  ///< by diode: of a contact that touches; else 0
  std::vector<double> way_rounding_;           ///< by diode: what rounding leaves of a contact's way
  std::vector<bool> next_conducts_, last_sides_;
  int sides_again_ = 0;  ///< how often in a row the same ones were found
  DiodeSides result_;
};

}  // namespace

DiodeSides diode_sides(const DiodeNetwork& network, const std::vector<double>& parameters, double t,
                       const Stored& stored, const std::function<double(const StateInfo&)>& resolution,
                       std::vector<DiodeState> before, KeptEvaluators& evaluators, DiodeSight& sight, double span,
                       bool one) {
  return Sides(network, parameters, t, stored, resolution, std::move(before), evaluators, sight, span).run(one);
}

}  // namespace bgsim
