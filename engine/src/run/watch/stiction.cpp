#include "run/watch/stiction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/lu.hpp"
#include "expression/apply.hpp"
#include "program/implicit.hpp"

namespace bgsim {
namespace {

std::vector<ExprId> guards_that_can_rest(const Program& program) {
  std::vector<ExprId> roots;
  for (const std::uint32_t relation : program.guarded)
    if (can_rest(program, relation)) roots.push_back(program.relations[relation].guard);
  return roots;
}

}  // namespace

Stiction::Stiction(const Program& program, std::span<const double> parameters, Evaluator& evaluator,
                   const Tolerances& tolerances, double span)
    : program_(program),
      evaluator_(evaluator),
      tolerances_(tolerances),
      span_(span),
      parameters_(parameters),
      rates_(evaluator.states()),
      moved_(evaluator.states()),
      guards_(evaluator.guard_count()),
      moved_guards_(evaluator.guard_count()),
      seen_(evaluator.guard_count()) {
  std::size_t root = 0;
  for (std::size_t guard = 0; guard < guards_.size(); ++guard) root_.push_back(possible(guard) ? root++ : 0);
}

bool Stiction::possible(std::size_t guard) const {
  return can_rest(program_, static_cast<std::uint32_t>(evaluator_.guard_relation(guard)));
}

bool Stiction::held(std::size_t guard) const {
  const auto among = [guard](const std::vector<std::size_t>& guards) {
    return std::find(guards.begin(), guards.end(), guard) != guards.end();
  };
  return among(held_) || among(surplus_);
}

std::vector<AtBorder> Stiction::laws() const {
  std::vector<AtBorder> result;
  for (const std::vector<std::size_t>* const guards : {&held_, &surplus_})
    for (const std::size_t guard : *guards) result.push_back({relation(guard).where.element});
  return result;
}

/// The mode where the guard is on this side of its border.
double Stiction::mode_on(std::size_t guard, int side) const {
  const Relation& at = relation(guard);
  if (at.kind == Relation::Kind::sign) return side;
  return apply(at.kind == Relation::Kind::step ? Op::step : at.comparison, side, 0.0);
}

/// Q of decide(): how the guards' rates fall with the places of the modes between those of their two sides.
Eigen::MatrixXd Stiction::falls(const std::vector<std::size_t>& guards) const {
  Eigen::MatrixXd q = -slopes_;
  for (std::size_t j = 0; j < guards.size(); ++j)
    q.col(static_cast<Eigen::Index>(j)) *= mode_on(guards[j], 1) - mode_on(guards[j], -1);
  return q;
}

/// With s, by guard, the place of its mode between that of the side below (0) and that of the side above (1), and u the
/// guards' rates, which are c - Q s: s = 0 where u < 0, s = 1 where u > 0, and between the two u = 0. As a
/// complementarity problem: s >= 0 beside u- >= 0, u+ >= 0 beside 1 - s >= 0, u = u+ - u-. Q is R M^-1 R^T L for
/// frictions of limits L between masses M, so the relation becomes monotone if its rows are scaled, and Lemke's method,
/// which any positive scaling leaves as it is, ends at a solution.
/// @param q       falls()
/// @param before  so many of the first guards were held before
/// @return by guard, then by guard: the pairs of s and of u+
ComplementarySides Stiction::sides(const std::vector<std::size_t>& guards, const Eigen::MatrixXd& q,
                                   std::size_t before) const {
  constexpr double kRoundings = 64.0 * std::numeric_limits<double>::epsilon();
  const std::size_t n = guards.size();
  const auto series = [](double value, double rounding) { return PowerSeries::of<1>({value}, {rounding}, true); };
  const PowerSeries one = PowerSeries::number(1.0);
  Complementarity problem{2 * n, std::vector<std::vector<Complementarity::Entry>>(2 * n),
                          std::vector<std::vector<Complementarity::Entry>>(2 * n), std::vector<PowerSeries>(2 * n)};
  std::vector<bool> first(2 * n, false);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    double c = base_[row], terms = std::abs(c);
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      const double slope = slopes_(row, column);
      if (slope == 0.0) continue;
      c += slope * mode_on(guards[j], -1);
      terms += std::abs(slope);
      problem.z[i].push_back({j, series(-q(row, column), kRoundings * (std::abs(slope) + std::abs(base_[row])))});
    }
    problem.z[i].push_back({n + i, -one});
    problem.w[i].push_back({i, one});
    problem.r[i] = series(-c, kRoundings * terms);
    problem.z[n + i].push_back({i, one});
    problem.w[n + i].push_back({n + i, one});
    problem.r[n + i] = one;
    first[i] = i < before;
  }
  return solve_complementarity(problem, first, std::vector<bool>(2 * n, false));
}

/// Holds these guards, by their positions in @p guards: those whose modes the ones before them determine are the
/// surplus.
void Stiction::hold(const std::vector<std::size_t>& guards, const std::vector<std::size_t>& positions,
                    Eigen::MatrixXd q) {
  constexpr double kDependent = 1e-10;
  held_.clear();
  surplus_.clear();
  const Eigen::VectorXd whole = q.diagonal();
  for (const std::size_t k : positions) {
    const auto at = static_cast<Eigen::Index>(k);
    if (!(q(at, at) > kDependent * whole[at])) {
      surplus_.push_back(guards[k]);
      continue;
    }
    held_.push_back(guards[k]);
    const Eigen::RowVectorXd row = q.row(at) / q(at, at);
    for (const std::size_t other : positions)
      if (other != k) q.row(static_cast<Eigen::Index>(other)) -= q(static_cast<Eigen::Index>(other), at) * row;
  }
}

/// Where several solutions have the same rates, takes the one with these modes.
/// @param found  by guard: the places of one solution
void Stiction::prefer(const std::vector<GuardMode>& known, const std::vector<std::size_t>& guards,
                      const Eigen::MatrixXd& q, std::vector<double>& found) const {
  constexpr double kSame = 1e-9;
  std::vector<double> wanted = found;
  for (const GuardMode& at : known) {
    const auto guard = std::find(guards.begin(), guards.end(), at.guard);
    if (guard == guards.end() || !std::isfinite(at.mode)) continue;
    const double below = mode_on(at.guard, -1), above = mode_on(at.guard, 1);
    wanted[static_cast<std::size_t>(guard - guards.begin())] =
        std::clamp((at.mode - below) / (above - below), 0.0, 1.0);
  }
  for (std::size_t i = 0; i < guards.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    double moves = 0.0;
    for (std::size_t j = 0; j < guards.size(); ++j)
      moves += q(row, static_cast<Eigen::Index>(j)) * (wanted[j] - found[j]);
    if (!(std::abs(moves) <= kSame * (std::abs(base_[row]) + slopes_.row(row).cwiseAbs().sum()))) return;
  }
  found = std::move(wanted);
}

std::optional<std::vector<Stiction::Left>> Stiction::decide(std::vector<std::size_t> candidates,
                                                            const std::vector<std::size_t>& leaving, double t,
                                                            const double* x, Branch& branch,
                                                            const std::vector<GuardMode>& known) {
  constexpr double kAtSide = 1e-9;
  Branch tried = branch;
  std::vector<std::size_t> guards = held_;
  guards.insert(guards.end(), surplus_.begin(), surplus_.end());
  const std::size_t before = guards.size();
  guards.insert(guards.end(), candidates.begin(), candidates.end());
  if (guards.empty() || !measure(guards, t, x, tried)) return std::nullopt;
  const Eigen::MatrixXd q = falls(guards);
  const auto without = [&](std::size_t guard) -> std::optional<std::vector<Left>> {
    std::erase(candidates, guard);
    if (candidates.empty() && before == 0) return std::nullopt;
    return decide(std::move(candidates), leaving, t, x, branch, known);
  };
  // No border holds from which a side pushes away.
  for (std::size_t k = before; k < guards.size(); ++k)
    if (!(q(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)) > 0.0)) return without(guards[k]);
  const ComplementarySides found = sides(guards, q, before);
  if (!found.solved) return std::nullopt;
  const std::size_t n = guards.size();
  std::vector<Left> left;
  std::vector<std::size_t> stay;  // positions
  std::vector<double> place(n);
  const auto from_side = [&place](std::size_t k) { return std::min(place[k], 1.0 - place[k]); };
  for (std::size_t k = 0; k < n; ++k) place[k] = found.takes_z[k] ? found.value[k].finite_part() : 0.0;
  // What shares a hold already goes on with its part, if it can.
  std::vector<GuardMode> present = known;
  for (std::size_t k = 0; k < before && !surplus_.empty(); ++k) present.push_back({guards[k], mode(guards[k], branch)});
  prefer(present, guards, q, place);
  for (std::size_t k = 0; k < n; ++k) {
    int side = found.takes_z[n + k] && found.value[n + k].sign() > 0 ? 1
               : !found.takes_z[k] && found.value[k].sign() > 0      ? -1
                                                                     : 0;
    if (side == 0 && !(from_side(k) > kAtSide) && std::find(leaving.begin(), leaving.end(), guards[k]) != leaving.end())
      side = place[k] > 0.5 ? 1 : -1;
    const double below = mode_on(guards[k], -1), above = mode_on(guards[k], 1);
    mode(guards[k], tried) = side != 0 ? mode_on(guards[k], side) : below + (above - below) * place[k];
    if (side != 0)
      left.push_back({guards[k], side});
    else
      stay.push_back(k);
  }
  // Farthest from their sides first: the surplus are those that are nearest.
  std::stable_sort(stay.begin(), stay.end(), [&](std::size_t a, std::size_t b) { return from_side(a) > from_side(b); });
  const std::vector<std::size_t> held = held_, surplus = surplus_;
  hold(guards, stay, q);
  // Rates that are no straight line between the two sides are not balanced by modes that were found so.
  const auto bent = std::find_if(held_.begin(), held_.end(), [&](std::size_t guard) {
    return relation(guard).kind != Relation::Kind::sign &&
           std::find(candidates.begin(), candidates.end(), guard) != candidates.end();
  });
  if (bent != held_.end()) {
    const std::size_t guard = *bent;
    Branch there = tried;
    if (!balance(t, x, there) || !stays(t, x, there)) {
      held_ = held;
      surplus_ = surplus;
      return without(guard);
    }
  }
  branch = std::move(tried);
  if (evaluator_.guards(t, x, branch, guards_.data())) seen_ = guards_;
  return left;
}

/// Whether the guards stay where they are with these modes: not if rates are no straight line between the two sides (a
/// condition within others, a law on a nonlinear loop).
bool Stiction::stays(double t, const double* x, Branch& branch) {
  constexpr double kOfSides = 1e-6;
  if (!guard_rates(held_, t, x, branch, other_)) return false;
  for (Eigen::Index k = 0; k < other_.size(); ++k)
    if (!(std::abs(other_[k]) <= kOfSides * (std::abs(base_[k]) + slopes_.row(k).cwiseAbs().sum()))) return false;
  return true;
}

void Stiction::release(std::size_t guard) {
  held_.insert(held_.end(), surplus_.begin(), surplus_.end());
  surplus_.clear();
  std::erase(held_, guard);
}

std::vector<std::size_t> Stiction::indefinite_outputs(double t, const double* x, const Branch& branch) {
  constexpr double kMoved = 0.01, kSame = 1e-9;  // of the way between a mode's sides; of what modes alone do
  std::vector<std::size_t> result;
  const std::size_t count = program_.output_names.size();
  std::vector<double> own(count), other(count), alone(count, 0.0), shared(count, 0.0);
  Branch here = branch;
  if (surplus_.empty() || !balance(t, x, here) || !evaluator_.outputs(t, x, here, own.data())) return result;
  const auto take = [&](Branch& with, std::vector<double>& most) {
    if (!evaluator_.outputs(t, x, with, other.data())) return;
    for (std::size_t i = 0; i < count; ++i) most[i] = std::max(most[i], std::abs(other[i] - own[i]));
  };
  const auto moved = [&](std::size_t guard) {
    Branch with = here;
    const double one = mode_on(guard, -1), two = mode_on(guard, 1);
    double& value = mode(guard, with);
    value += kMoved * (std::abs(value - one) < std::abs(value - two) ? two - one : one - two);
    return with;
  };
  for (const std::size_t guard : held_) {
    Branch with = moved(guard);
    take(with, alone);
  }
  for (const std::size_t guard : surplus_) {
    Branch with = moved(guard);
    take(with, alone);
    if (balance(t, x, with)) take(with, shared);
  }
  for (std::size_t i = 0; i < count; ++i)
    if (shared[i] > kSame * alone[i]) result.push_back(i);
  return result;
}

bool Stiction::rests(std::size_t guard) const {
  return std::find(surplus_.begin(), surplus_.end(), guard) != surplus_.end();
}

double Stiction::margin(std::size_t guard, const Branch& branch) const {
  if (rests(guard)) return 1.0;
  const double mode = branch.modes[evaluator_.guard_relation(guard)];
  return relation(guard).kind == Relation::Kind::sign ? 1.0 - std::abs(mode) : std::min(mode, 1.0 - mode);
}

int Stiction::side_of(std::size_t guard, double mode) const {
  const Relation& at = relation(guard);
  if (at.kind == Relation::Kind::sign) return (mode > 0.0) - (mode < 0.0);
  const bool above = apply(at.kind == Relation::Kind::step ? Op::step : at.comparison, 1.0, 0.0) != 0.0;
  return (mode > 0.5) == above ? 1 : -1;
}

/// How fast the held guards move with the modes as they are.
bool Stiction::guard_rates(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch,
                           Eigen::VectorXd& out) {
  if (!evaluator_.rates(t, x, branch, rates_.data())) return false;
  return along_flow(guards, t, x, branch, out) || differences(guards, t, x, branch, out);
}

/// By the slopes of the guards' expressions, enclosed over a short time. False where they have none (at a kink, or the
/// beginning of a root), or where they depend on loops.
bool Stiction::along_flow(const std::vector<std::size_t>& guards, double t, const double* x, const Branch& branch,
                          Eigen::VectorXd& out) {
  constexpr double kMoment = 1e-12;  // of the scene
  constexpr double kSharp = 1e-6, kOfTerms = 1e-9;
  if (!enclosure_) enclosure_.emplace(program_, parameters_, guards_that_can_rest(program_));
  if (!enclosure_->tears().empty()) return false;
  enclosure_->set_modes(branch.modes);
  const double end = std::max(t + kMoment * span_, std::nextafter(t, std::numeric_limits<double>::infinity()));
  const double half = (end - t) / 2;
  const auto slopes_for = [&](double least_part) {
    jets_.clear();
    for (const std::uint32_t i : enclosure_->states()) {
      const double ends[] = {least_part * rates_[i], rates_[i]}, moves = half * std::abs(rates_[i]);
      jets_.push_back({x[i], Range(x[i] - moves, x[i] + moves),
                       Range(std::min(ends[0], ends[1]), std::max(ends[0], ends[1])), rates_[i], Range(0.0, 0.0)});
    }
    enclosure_->evaluate(t, end, jets_, {});
  };
  slopes_for(1.0);
  widths_.resize(guards.size());
  bool sharp = true;
  for (std::size_t k = 0; k < guards.size(); ++k) {
    const Jet& guard = (*enclosure_)[root_[guards[k]]];
    const Range slope = guard.slope;
    widths_[k] = slope.upper() - slope.lower();
    if (!std::isfinite(widths_[k])) return false;
    // Without a bend the slope itself is known: what balances it to 0 is to be 0.
    const bool known = std::isfinite(guard.curve.lower()) && std::isfinite(guard.curve.upper());
    out[static_cast<Eigen::Index>(k)] = known ? guard.middle_slope : slope.lower() + widths_[k] / 2;
    if (known) widths_[k] = 0.0;
    sharp = sharp && widths_[k] <= kSharp * std::max(std::abs(slope.lower()), std::abs(slope.upper()));
  }
  if (sharp) return true;
  slopes_for(-1.0);  // as large as the terms whose sum may be 0
  for (std::size_t k = 0; k < guards.size(); ++k) {
    const Range terms = (*enclosure_)[root_[guards[k]]].slope;
    if (!(widths_[k] <= kOfTerms * std::max(std::abs(terms.lower()), std::abs(terms.upper())))) return false;
  }
  return true;
}

/// By a small step along the flow to either side, or to one where they have no value on the other: of digits only where
/// the states that the guard depends on have tolerances of one kind.
bool Stiction::differences(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch,
                           Eigen::VectorXd& out) {
  constexpr double kTolerances = 1e3;
  double step = 1e-3 * span_;
  for (std::size_t i = 0; i < rates_.size(); ++i) {
    const double tolerance = tolerances_.absolute(i);
    if (rates_[i] != 0.0 && tolerance > 0.0) step = std::min(step, kTolerances * tolerance / std::abs(rates_[i]));
  }
  const auto guards_at = [&](double by, std::vector<double>& values) {
    for (std::size_t i = 0; i < rates_.size(); ++i) moved_[i] = x[i] + by * rates_[i];
    return evaluator_.guards(t + by, moved_.data(), branch, values.data());
  };
  if (!guards_at(step, moved_guards_)) return false;
  double over = 2.0 * step;
  if (!guards_at(-step, guards_)) {
    over = step;
    if (!guards_at(0.0, guards_)) return false;
  }
  for (std::size_t k = 0; k < guards.size(); ++k)
    out[static_cast<Eigen::Index>(k)] = (moved_guards_[guards[k]] - guards_[guards[k]]) / over;
  return true;
}

/// The guards' rates are linear in the modes (a sign is a factor of a force or a flow): measured at 0 and at each
/// mode's 1.
bool Stiction::measure(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch) {
  const auto count = static_cast<Eigen::Index>(guards.size());
  slopes_.resize(count, count);
  base_.resize(count);
  other_.resize(count);
  rate_slopes_.resize(static_cast<Eigen::Index>(rates_.size()), count);
  for (const std::size_t guard : guards) mode(guard, branch) = 0.0;
  if (!guard_rates(guards, t, x, branch, base_)) return false;
  base_rates_ = rates_;
  for (Eigen::Index k = 0; k < count; ++k) {
    double& moved = mode(guards[static_cast<std::size_t>(k)], branch);
    moved = 1.0;
    if (!guard_rates(guards, t, x, branch, other_)) return false;
    slopes_.col(k) = other_ - base_;
    for (std::size_t i = 0; i < rates_.size(); ++i)
      rate_slopes_(static_cast<Eigen::Index>(i), k) = rates_[i] - base_rates_[i];
    moved = 0.0;
  }
  return true;
}

bool Stiction::balance(double t, const double* x, Branch& branch) {
  constexpr double kRoundings = 16.0 * std::numeric_limits<double>::epsilon();
  if (!measure(held_, t, x, branch)) return false;
  const DenseLu factors(slopes_);
  Eigen::VectorXd modes = factors.solve(-base_);
  const bool regular = modes.allFinite();  // not where a limit that varies is 0
  if (!regular) modes = solve_with_full_pivots(slopes_, -base_);
  if (!modes.allFinite()) return false;
  for (std::size_t k = 0; k < held_.size(); ++k) mode(held_[k], branch) = modes[static_cast<Eigen::Index>(k)];
  Eigen::VectorXd off = Eigen::VectorXd::Zero(modes.size());
  if (regular)
    off = factors.solve(Eigen::MatrixXd::Identity(slopes_.rows(), slopes_.cols())).cwiseAbs() *
          (slopes_.cwiseAbs() * modes.cwiseAbs() + base_.cwiseAbs());
  const Eigen::VectorXd rounding = rate_slopes_.cwiseAbs() * (modes.cwiseAbs() + off);
  rounding_.resize(rates_.size());
  for (std::size_t i = 0; i < rounding_.size(); ++i)
    rounding_[i] = kRoundings * (std::abs(base_rates_[i]) + rounding[static_cast<Eigen::Index>(i)]);
  return true;
}

/// Where the guards are brought to their borders by impulses of what holds them. False where there is no such point.
/// @note   slopes_ and rate_slopes_ are those of @p guards at @p x.
bool Stiction::border(const std::vector<std::size_t>& guards, const std::vector<double>& values, const double* x,
                      std::vector<double>& at) const {
  Eigen::VectorXd off(slopes_.rows());
  for (std::size_t k = 0; k < guards.size(); ++k) off[static_cast<Eigen::Index>(k)] = values[guards[k]];
  const Eigen::VectorXd moves = rate_slopes_ * DenseLu(slopes_).solve(-off);
  at.assign(x, x + rates_.size());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] += moves[static_cast<Eigen::Index>(i)];
  return moves.allFinite();
}

/// By how many tolerances a state moves at most from one point to another.
double Stiction::tolerances_between(const double* x, const std::vector<double>& other) const {
  double most = 0.0;
  for (std::size_t i = 0; i < other.size(); ++i)
    if (other[i] != x[i]) most = std::max(most, std::abs(other[i] - x[i]) / tolerances_.absolute(i));
  return most;
}

/// Whether these modes have about the same force at another point. A root has none at its border that could hold
/// anything there: sign(e)*sqrt(abs(e)).
bool Stiction::same_force(const std::vector<std::size_t>& guards, double t, const std::vector<double>& at,
                          const Branch& branch) {
  constexpr double kLeft = 0.5;
  const Eigen::VectorXd before = slopes_.diagonal();
  Branch there = branch;
  if (!measure(guards, t, at.data(), there)) return false;
  for (Eigen::Index k = 0; k < before.size(); ++k)
    if (!(std::abs(slopes_(k, k)) > kLeft * std::abs(before[k]))) return false;
  return true;
}

std::vector<Stiction::Left> Stiction::moved_by_jump(double t, const double* x, const Branch& branch, double least) {
  std::vector<std::size_t> guards = held_;
  guards.insert(guards.end(), surplus_.begin(), surplus_.end());
  std::vector<Left> result;
  std::vector<double> at;
  Branch there = branch;
  if (!balance(t, x, there) || !evaluator_.guards(t, x, there, guards_.data())) return result;
  const std::vector<double> values = guards_;
  std::vector<double> jumps = values;
  for (std::size_t k = 0; k < jumps.size(); ++k) jumps[k] -= seen_[k];
  for (const std::size_t guard : guards) {
    there = branch;
    if (jumps[guard] == 0.0 || !measure({guard}, t, x, there) || !border({guard}, jumps, x, at)) continue;
    if (tolerances_between(x, at) > least) result.push_back({guard, values[guard] > 0.0 ? 1 : -1});
  }
  return result;
}

bool Stiction::bring_back(double t, std::vector<double>& x, Branch& branch, double least) {
  if (held_.empty() || !balance(t, x.data(), branch) || !evaluator_.guards(t, x.data(), branch, guards_.data()))
    return false;
  const std::vector<double> values = seen_ = guards_;
  std::vector<double> at;
  if (!border(held_, values, x.data(), at) || !(tolerances_between(x.data(), at) > least)) return false;
  if (!same_force(held_, t, at, branch)) return false;
  // Where a law ends at the border (a root on one side), what is held has to stay beside it.
  std::vector<double> beyond = at;
  for (std::size_t i = 0; i < at.size(); ++i) beyond[i] += at[i] - x[i];
  if (!evaluator_.rates(t, beyond.data(), branch, rates_.data())) return false;
  x = std::move(at);
  if (evaluator_.guards(t, x.data(), branch, guards_.data())) seen_ = guards_;
  return true;
}

std::vector<GuardMode> guards_of(const Evaluator& evaluator, const std::vector<AtBorder>& laws) {
  std::vector<GuardMode> guards;
  const Program& program = evaluator.program();
  const auto law_of = [&](std::size_t guard) {
    const auto relation = static_cast<std::uint32_t>(evaluator.guard_relation(guard));
    if (!can_rest(program, relation)) return laws.end();
    return std::find_if(laws.begin(), laws.end(),
                        [&](const AtBorder& law) { return law.resistor == program.relations[relation].where.element; });
  };
  for (std::size_t guard = 0; !laws.empty() && guard < evaluator.guard_count(); ++guard)
    if (const auto law = law_of(guard); law != laws.end()) {
      // A condition has other modes on its sides, either of which may be that above the guard.
      const bool sign = program.relations[evaluator.guard_relation(guard)].kind == Relation::Kind::sign;
      guards.push_back({guard, sign ? law->mode : std::numeric_limits<double>::quiet_NaN()});
    }
  return guards;
}

void hold_at_border(Evaluator& evaluator, std::span<const double> parameters, const RunInputs& inputs,
                    const std::vector<AtBorder>& laws, double t, const double* x, Branch& branch) {
  const std::vector<GuardMode> known = guards_of(evaluator, laws);
  if (known.empty()) return;
  std::vector<std::size_t> guards;
  for (const GuardMode& at : known) guards.push_back(at.guard);
  const Tolerances tolerances(evaluator.program(), inputs, false);
  Stiction stiction(evaluator.program(), parameters, evaluator, tolerances, inputs.stop - inputs.start);
  // As the run has them, to the last digit: an effort that is 0 but for rounding is to be the same in both.
  if (stiction.decide(std::move(guards), {}, t, x, branch, known) && stiction.any())
    static_cast<void>(stiction.balance(t, x, branch));
}

void Stiction::still(double* rates) const {
  for (std::size_t i = 0; i < rounding_.size(); ++i)
    if (std::abs(rates[i]) <= rounding_[i]) rates[i] = 0.0;
}

}  // namespace bgsim
