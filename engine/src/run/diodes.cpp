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
#include "run/network_slopes.hpp"
#include "run/seen_resistance.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kOrders = NetworkSlopes::kOrders;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
/// Of the terms that a value is the sum of: what is left of a sum that is zero, after some hundred operations.
constexpr double kOfTerms = 256.0 * kEpsilon;

class Sides {
 public:
  Sides(const DiodeNetwork& network, NetworkSlopes slopes, double t, std::vector<DiodeState> before, DiodeSight& sight,
        double span)
      : network_(network),
        at_(std::move(slopes)),
        t_(t),
        sight_(sight),
        span_(span),
        n_(network.resistances.size()),
        border_(network.borders.size()),
        away_(n_, false),
        separates_(n_, false),
        restitution_(n_, 0.0),
        closing_(n_, 0.0),
        way_rounding_(n_, 0.0) {
    result_.diodes = std::move(before);
    result_.room.assign(n_, 0.0);
  }

  DiodeSides run(ImpactOf impact) {
    if (choose_resistances() && look_at_borders() && look_at_contacts()) {
      at_.bound_flows();
      if (impact == ImpactOf::fastest) leave_the_fastest();
      if (impact == ImpactOf::all) leave_out_what_separates();
      if (impact == ImpactOf::rest) restitution_.assign(n_, 0.0);
      iterate();
    } else if (!result_.final) {
      open_what_is_away();
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] double source_value(std::size_t diode) const {
    return result_.diodes[diode].effort - resistance_[diode] * result_.diodes[diode].flow;
  }
  /// Of a diode's own flow, or a derivative of it, by its source.
  [[nodiscard]] double own_slope(std::size_t diode, std::size_t order) const {
    return at_.flows().slope(diode, order, diode);
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
  bool linearize(bool aside = false) {
    std::vector<double> sources(n_);
    for (std::size_t i = 0; i < n_; ++i) sources[i] = source_value(i);
    for (const Border& border : border_) sources.push_back(border.place);
    if (auto failure = at_.look(resistance_, sources, aside)) return fail(std::move(*failure));
    for (std::size_t i = 0; i < n_; ++i)
      if (!result_.diodes[i].may_begin) result_.diodes[i].may_begin = at_.fires(i);
    return true;
  }

  /// Which borders are unknowns of the problem: those to which both sides push back, so that there is one solution. The
  /// others are on the side of their guard.
  bool look_at_borders() {
    for (std::size_t b = 0; b < border_.size(); ++b) {
      Border& border = border_[b];
      const std::size_t port = n_ + b;
      const auto slope = [&](std::size_t k) { return at_.flows().slope(port, k, port); };
      std::size_t order = 0;
      while (order + 1 < kOrders && slope(order) == 0.0) ++order;
      border.pushes_back = std::isfinite(slope(order)) && slope(order) < 0.0;
      const double guard = at_.guard(b), rounding = at_.flows().off(port, 0) + kOfTerms * at_.flows().size(port, 0);
      if (std::abs(guard) > rounding)
        border.place = guard > 0.0 ? 1.0 : 0.0;
      else if (border.pushes_back)
        result_.at_border.push_back({network_.borders[b].element});
    }
    return border_.empty() || linearize();
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
      const double q = at_.displacement(i);
      longest = std::max({longest, std::abs(q), std::abs(at_.room(i) + q)});
    }
    for (std::size_t i = 0; i < n_; ++i) {
      if (!network_.displacements[i].valid()) continue;
      const double room = at_.room(i), q = at_.displacement(i);
      const double size = std::abs(q) + std::abs(room + q);
      const bool touches = result_.diodes[i].touches;
      // The time of an event is known to its rounding, and the flow to that of its terms.
      const double moves = at_.flows().size(i, 0) * std::abs(t_);
      way_rounding_[i] = 8.0 * kEpsilon * (size + moves + longest);
      const double off = at_.displacement_off(i) + way_rounding_[i];
      // The displacement of a closed one is the integral of der(gap), and a jump of the gap refused with BG402: what
      // is left of the difference is the method's, and put to 0.
      const bool closed = touches && !result_.diodes[i].conducts;
      if (!closed && room < (touches ? -std::max(kTouching * off, kFar * size) : -std::max(off, kBeyond * size)))
        return fail_for_good(beyond_gap_failure(network_, i, t_, q, room + q));
      // Where efforts can change its speed at once, there is no impact.
      bool of_stores = true;
      for (std::size_t j = 0; j < n_; ++j) of_stores = of_stores && at_.flows().slope(i, 0, j) == 0.0;
      // Beside a wall that moves, the speed of what rests there is rounding, and so would be its rebound, again and
      // again.
      const double rounding =
          kOfTerms * at_.flows().size(i, 0) + 8.0 * kEpsilon * std::abs(t_) * at_.flows().size(i, 1);
      separates_[i] = of_stores && at_.speed(i) > rounding;
      // One on its way out has left its gap, however near it still is.
      away_[i] = !touches && (room > off || (room > 0.0 && separates_[i]));
      if (away_[i]) {
        result_.diodes[i].effort = result_.diodes[i].flow = 0.0;
        continue;
      }
      result_.room[i] = room;
      restitution_[i] = at_.restitution(i);
      if (!(restitution_[i] >= 0.0 && restitution_[i] <= 1.0))
        return fail_for_good(restitution_failure(network_, i, t_, restitution_[i]));
      closing_[i] = of_stores && -at_.speed(i) > rounding ? -at_.speed(i) : 0.0;
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
      if (at_.has_rates()) {
        const double room = at_.room(i), q = at_.displacement(i);
        const double off = at_.displacement_off(i) + 8.0 * kEpsilon * (std::abs(q) + std::abs(room + q));
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
      if (!(closing_[i] > kTimes * (at_.flows().off(i, 0) + kOfTerms * at_.flows().size(i, 0)))) continue;
      if (fastest == n_ || closing_[i] > closing_[fastest]) fastest = i;
    }
    if (fastest == n_) return leave_out_what_separates();
    for (std::size_t i = 0; i < n_; ++i)
      if (network_.displacements[i].valid() && i != fastest) leave_out(i);
  }

  /// Where contacts close, those that separate do not push. An impulse on one that comes to rest does work on its way
  /// out, and no restitution says how much.
  void leave_out_what_separates() {
    const auto closes = [](double speed) { return speed > 0.0; };
    if (std::none_of(closing_.begin(), closing_.end(), closes)) return;
    for (std::size_t i = 0; i < n_; ++i)
      if (separates_[i]) leave_out(i);
  }

  void leave_out(std::size_t contact) {
    away_[contact] = true;
    restitution_[contact] = closing_[contact] = 0.0;
    result_.diodes[contact].effort = result_.diodes[contact].flow = 0.0;
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
      std::vector<double> aside;
      for (std::size_t i = 0; has_value && i < n_; ++i) aside.push_back(own_slope(i, 0));
      if (!has_value || !linearize()) {  // a law that has no value there
        result_.failure.reset();
        continue;
      }
      bool known = true;
      for (std::size_t i = 0; i < n_; ++i)
        known = known && std::abs(own_slope(i, 0) - aside[i]) <= kSame * std::abs(own_slope(i, 0));
      if (!known && !scans.front().empty()) break;
      if (!known) continue;
      for (std::size_t i = 0; i < n_; ++i) {
        SlopesThrough at{r, {}};
        for (std::size_t k = 0; k < kOrders; ++k) at.slopes[k] = own_slope(i, k);
        if (std::abs(at.slopes[0]) <= kOfTerms / r) at.slopes[0] = 0.0;
        // What does not move the one before within the scene is what rounding leaves of terms that cancel.
        for (std::size_t k = 1; k < kOrders; ++k)
          if (std::abs(own_slope(i, k)) * span_ <= kOfTerms * std::abs(own_slope(i, k - 1))) at.slopes[k] = 0.0;
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

  /// Of the pairs of a border: a of its place between the two sides, with what the guard is below 0, and behind it what
  /// the guard is above 0, with 1 - a.
  [[nodiscard]] std::size_t pair_of(std::size_t border) const { return n_ + 2 * border; }

  /// The flow of a port as the unknowns make it, to the left side of its row, and what is known of it to the right.
  void add_flow(std::size_t port, std::size_t row, Complementarity& problem, std::array<double, kOrders>& right,
                std::array<double, kOrders>& right_rounding) {
    std::array<double, kOrders> largest{};
    for (std::size_t k = 0; k < kOrders; ++k)
      for (std::size_t j = 0; j < n_; ++j) largest[k] = std::max(largest[k], std::abs(at_.flows().slope(port, k, j)));
    // With a resistance of r in series no slope is larger than 1/r; a row that is nothing but rounding is so beside
    // that: the flow into a part that nothing else connects.
    if (port < n_) largest[0] = std::max(largest[0], 1.0 / resistance_[port]);
    const auto slopes_by = [&](std::size_t source, double known) {
      std::array<double, kOrders> slope{}, rounding{};
      for (std::size_t k = 0; k < kOrders; ++k) {
        slope[k] = at_.flows().slope(port, k, source);
        rounding[k] = slope[k] == 0.0 ? 0.0 : 16.0 * kEpsilon * std::max(largest[k], std::abs(slope[k]));
        right[k] += slope[k] * known;
        right_rounding[k] += kOfTerms * std::abs(slope[k] * known);
      }
      return std::pair(slope, rounding);
    };
    for (std::size_t j = 0; j < n_; ++j) {
      const auto [slope, rounding] = slopes_by(j, threshold(j));
      if (port != j && slope == std::array<double, kOrders>{}) continue;
      const PowerSeries f = series(slope, rounding);
      PowerSeries z = f * PowerSeries::number(resistance_[j]);
      if (port == j) z = z + PowerSeries::number(1.0);
      // A contact that is away has no effort and any flow: the other way round than what is held.
      problem.w[row].push_back({j, away_[j] ? z : f});
      problem.z[row].push_back({j, away_[j] ? f : z});
    }
    for (std::size_t b = 0; b < border_.size(); ++b) {
      const bool unknown = border_[b].pushes_back;
      const auto [slope, rounding] = slopes_by(n_ + b, unknown ? 0.0 : border_[b].place);
      if (unknown && slope != std::array<double, kOrders>{})
        problem.z[row].push_back({pair_of(b), -series(slope, rounding)});
    }
    for (std::size_t k = 0; k < kOrders; ++k) {
      right[k] += at_.flows().at_zero(port, k);
      right_rounding[k] += kOfTerms * at_.flows().size(port, k) + at_.flows().off(port, k);
      // The time of an event is known to its rounding.
      if (k + 1 < kOrders) right_rounding[k] += 8.0 * kEpsilon * std::abs(t_) * at_.flows().size(port, k + 1);
    }
  }

  /// Speeds of separation are counted from those of the rebound.
  void count_from_rebound(std::size_t row, Complementarity& problem) const {
    for (const auto& [j, z] : problem.z[row])
      if (j < n_ && !away_[j] && rebound(j) > 0.0)
        problem.r[row] = problem.r[row] - z * PowerSeries::number(rebound(j));
  }

  void add_border(std::size_t border, Complementarity& problem) {
    const PowerSeries one = PowerSeries::number(1.0);
    const std::size_t row = pair_of(border);
    problem.z[row + 1].push_back({row, one});
    problem.w[row + 1].push_back({row + 1, one});
    problem.r[row + 1] = one;
    if (!border_[border].pushes_back) {  // a pair of its own, that nothing else knows
      problem.w[row].push_back({row, one});
      problem.r[row] = PowerSeries();
      return;
    }
    std::array<double, kOrders> right{}, rounding{};
    add_flow(n_ + border, row, problem, right, rounding);
    problem.z[row].push_back({row + 1, one});
    problem.w[row].push_back({row, -one});
    problem.r[row] = series(right, rounding);
    count_from_rebound(row, problem);
  }

  [[nodiscard]] Complementarity problem() {
    // z - F(s) = 0 with s = e0 - r z - w gives (1 + F' r) z + F' w = F(0) + F' e0.
    Complementarity problem;
    problem.size = pair_of(border_.size());
    problem.z.resize(problem.size);
    problem.w.resize(problem.size);
    problem.r.resize(problem.size);
    effort_size_.assign(n_, 0.0);
    result_.flow_off.assign(n_, 0.0);
    result_.effort_off.assign(n_, 0.0);
    result_.flow_error.assign(n_, 0.0);
    result_.effort_error.assign(n_, 0.0);
    for (std::size_t i = 0; i < n_; ++i) {
      std::array<double, kOrders> right{}, right_rounding{};
      add_flow(i, i, problem, right, right_rounding);
      constexpr double kOfSize = 1e-6, kTimes = 10.0;
      const double flow_size = at_.flows().size(i, 0) + std::abs(right[0]), off = at_.flows().off(i, 0);
      const double r = resistance_[i];
      effort_size_[i] = r * flow_size + std::abs(threshold(i)) + std::abs(source_value(i));
      result_.flow_error[i] = kTimes * (off + kOfTerms * flow_size);
      result_.effort_error[i] = kTimes * (r * off + kOfTerms * effort_size_[i]);
      result_.flow_off[i] = kOfSize * flow_size + result_.flow_error[i];
      result_.effort_off[i] = kOfSize * effort_size_[i] + result_.effort_error[i];
      problem.r[i] = series(right, right_rounding);
      count_from_rebound(i, problem);
    }
    for (std::size_t b = 0; b < border_.size(); ++b) add_border(b, problem);
    return problem;
  }

  /// Flows and efforts as parts of what each diode's own come to, so that neither the units nor the part of the model
  /// that a diode is in decides what is large.
  [[nodiscard]] ComplementarityUnits units() const {
    const auto exponent = [](double size) { return size > 0.0 && std::isfinite(size) ? std::ilogb(size) : 0; };
    const std::vector<int> none(pair_of(border_.size()), 0);
    ComplementarityUnits units{none, none, none};
    for (std::size_t i = 0; i < n_; ++i) {
      const int flow = exponent(effort_size_[i] / resistance_[i]), effort = flow + exponent(resistance_[i]);
      units.row[i] = flow;
      units.z[i] = away_[i] ? effort : flow;
      units.w[i] = away_[i] ? flow : effort;
    }
    for (std::size_t b = 0; b < border_.size(); ++b) {
      double size = 0.0;  // of the guard; one that is at rest begins with its rate
      for (std::size_t k = 0; k < kOrders && !(size > 0.0); ++k) size = at_.flows().size(n_ + b, k);
      units.row[pair_of(b)] = units.w[pair_of(b)] = units.z[pair_of(b) + 1] = exponent(size);
    }
    return units;
  }

  [[nodiscard]] double rebound(std::size_t diode) const { return restitution_[diode] * closing_[diode]; }
  [[nodiscard]] double threshold(std::size_t diode) const { return at_.threshold(diode); }

  void iterate() {
    constexpr int kMostSteps = 50;
    for (int step = 0; step < kMostSteps; ++step) {
      std::vector<bool> first(pair_of(border_.size())), held(first.size());
      for (std::size_t b = 0; b < border_.size(); ++b) {
        first[pair_of(b)] = border_[b].pushes_back && border_[b].place > 0.0;
        first[pair_of(b) + 1] = border_[b].pushes_back && border_[b].place == 1.0;
      }
      for (std::size_t i = 0; i < n_; ++i) {
        first[i] = result_.diodes[i].conducts && !away_[i];
        held[i] =
            away_[i] || (!*result_.diodes[i].may_begin && (!result_.diodes[i].conducts || result_.diodes[i].pinned));
      }
      Complementarity problem = this->problem();
      const ComplementarityUnits units = this->units();
      scale(problem, units);
      // What the series leave open is for the trial modes to see, which do not know the parts of friction.
      ComplementarySides sides = solve_complementarity(problem, first, held, !border_.empty());
      if (!sides.solved) {
        fail(no_sides_failure(network_, ports_of(sides.unbounded), t_));
        return;
      }
      scale_back(sides, units);
      for (std::size_t i = 0; i < n_; ++i) {
        if (!away_[i]) continue;
        sides.takes_z[i] = !sides.takes_z[i];
        if (!sides.takes_z[i]) return static_cast<void>(fail_for_good(free_contact_failure(network_, i, t_)));
      }
      if (take(sides, held)) return;
      if (!linearize()) return;
      at_.bound_flows();
    }
    fail(
        diagnostic_of("BG622", "at t = " + number_text(t_) + " the sides of the diodes could not be found", {},
                      "with the laws linear about the flows and efforts found, the diodes come to other ones each time",
                      "a law that is not monotone is between them"));
  }

  /// Diodes, then borders.
  [[nodiscard]] std::vector<std::size_t> ports_of(std::vector<std::size_t> pairs) const {
    for (std::size_t& pair : pairs)
      if (pair >= n_) pair = n_ + (pair - n_) / 2;
    return pairs;
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
    for (std::size_t b = 0; b < border_.size(); ++b) {
      if (!border_[b].pushes_back) continue;
      const PowerSeries& value = sides.value[pair_of(b)];
      const double place = sides.takes_z[pair_of(b)] ? std::clamp(value.finite_part(), 0.0, 1.0) : 0.0;
      same = same && std::abs(place - border_[b].place) <= kSame;
      border_[b].place = place;
    }
    // Only the sides matter. Where laws are flat at 0, as an orifice's, sources converge slowly.
    constexpr int kMostTimes = 3;
    sides_again_ = sides.takes_z == last_sides_ ? sides_again_ + 1 : 0;
    last_sides_ = sides.takes_z;
    if (!same && !is_linear() && sides_again_ < kMostTimes) return false;
    for (std::size_t i = 0; i < n_; ++i) result_.at_gap.push_back(network_.displacements[i].valid() && !away_[i]);
    take_impulses(sides);
    take_flights(sides);
    take_borders(sides);
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

  /// Those whose guard is 0, as far as it is known here.
  void take_borders(const ComplementarySides& sides) {
    result_.at_border.clear();
    const auto zero = [&sides](std::size_t pair, bool z) {
      return sides.takes_z[pair] != z || sides.value[pair].zero || sides.value[pair].order > 0;
    };
    for (std::size_t b = 0; b < border_.size(); ++b)
      if (border_[b].pushes_back && zero(pair_of(b), false) && zero(pair_of(b) + 1, true))
        result_.at_border.push_back({network_.borders[b].element, 2.0 * border_[b].place - 1.0});
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
    const LinearFlows before = at_.flows();
    if (!linearize()) return true;
    const LinearFlows& now = at_.flows();
    for (std::size_t i = 0; i < now.ports; ++i)
      for (std::size_t k = 0; k < kOrders; ++k) {
        const double size = before.size(i, k) + now.size(i, k);
        if (!(std::abs(now.at_zero(i, k) - before.at_zero(i, k)) <= kSame * size)) return false;
        for (std::size_t j = 0; j < now.ports; ++j) {
          const double slope = before.slope(i, k, j);
          if (!(std::abs(now.slope(i, k, j) - slope) <= kSame * std::abs(slope))) return false;
        }
      }
    return true;
  }

  const DiodeNetwork& network_;
  NetworkSlopes at_;
  double t_;
  DiodeSight& sight_;
  double span_;
  std::size_t n_;
  struct Border {
    double place = 0.5;        ///< of the law, at the present point
    bool pushes_back = false;  ///< from both sides
  };
  std::vector<Border> border_;
  std::vector<double> resistance_;  ///< by diode: r
  std::vector<double> effort_size_;
  std::vector<bool> away_;                     ///< by diode: a contact that does not touch
  std::vector<bool> separates_;                ///< by diode: a contact that opens, beyond rounding
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
                       ImpactOf impact) {
  return Sides(network, {network, parameters, t, stored, resolution, evaluators}, t, std::move(before), sight, span)
      .run(impact);
}

}  // namespace bgsim
