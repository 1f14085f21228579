#include "run/watch/guard_functions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "expression/graph.hpp"
#include "program/mode_borders.hpp"

namespace bgsim {

namespace {

/// Of a step, in which what no equation encloses is sampled.
constexpr double kSampledParts = 8.0;

std::vector<ExprId> guard_expressions(const Program& program) {
  std::vector<ExprId> roots;
  for (const std::uint32_t relation : program.guarded) roots.push_back(program.relations[relation].guard);
  return roots;
}

/// The parabola through the values at the ends and in the middle of a stretch.
Jet parabola(double left, double middle, double right, double length) {
  const double bend = left - 2.0 * middle + right, room = 0.25 * std::fabs(bend);
  const double control = 2.0 * middle - 0.5 * (left + right);
  const double first = 2.0 * (control - left), second = 2.0 * (right - control), slack = std::fabs(bend);
  return {middle,
          {std::min({left, control, right}) - room, std::max({left, control, right}) + room},
          {(std::min(first, second) - slack) / length, (std::max(first, second) + slack) / length}};
}

}  // namespace

GuardFunctions::GuardFunctions(const Program& program, std::span<const double> parameters, Owner owner)
    : program_(program),
      owner_(std::move(owner)),
      enclosure_(program, parameters, guard_expressions(program)),
      equations_(program, parameters) {
  for (std::size_t i = 0; i < program.guarded.size(); ++i) {
    const std::uint32_t relation = program.guarded[i];
    if (program.relations[relation].has_borders()) {
      guards_.push_back({i, relation, -1});
      guards_.push_back({i, relation, 1});
    } else {
      guards_.push_back({i, relation, 0});
    }
  }
  const std::vector<std::uint32_t>& solved = program.rates.solves;
  for (const std::uint32_t tear : enclosure_.tears())
    unsolved_ = unsolved_ || std::find(solved.begin(), solved.end(), program.plan.block_of_tear[tear]) == solved.end();
}

void GuardFunctions::take_modes(const Branch& branch) {
  std::vector<double> modes = branch.modes;
  if (!modes_.empty())  // those that move are taken where they are used
    for (const Enclosure::MovingMode& moving : moving_) modes[moving.relation] = modes_[moving.relation];
  if (modes_ == modes) return;
  modes_ = std::move(modes);
  enclosure_.set_modes(modes_);
  screen_.clear();
  solved_.clear();
}

void GuardFunctions::hold(std::vector<Held> held) {
  if (held == held_) return;
  held_ = std::move(held);
  moving_.clear();
  for (const Held& at : held_) moving_.push_back({guards_[at.guard].relation, {}});
  solved_.clear();
  modes_.clear();  // the enclosure has those that moved where they were last
}

bool GuardFunctions::screened(const StepEnds& step, const Branch& branch, const std::vector<std::size_t>& guards) {
  hold({});
  take_modes(branch);
  if (unsolved_ && !branch.given) return false;
  return screen_.passes(enclosure_, step, [&] {
    constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
    return std::all_of(guards.begin(), guards.end(),
                       [&](std::size_t guard) { return owner_.stays(guard, jet(guard).value, kNoTime); });
  });
}

void GuardFunctions::begin(Integrator& integrator, std::vector<Held> held) {
  const Branch& branch = integrator.branch();
  given_ = branch.given;
  hold(std::move(held));
  take_modes(branch);
  std::erase_if(solved_, [&](const Solved& known) { return known.t != integrator.previous(); });
  unknowns_ = enclosure_.states();
  if (given_)
    for (const std::uint32_t tear : enclosure_.tears())
      unknowns_.push_back(static_cast<std::uint32_t>(program_.state_names.size()) + tear);
  of_equations_.clear();
  if (!is_enclosed_by_polynomials()) {
    std::vector<std::uint32_t> relations;
    for (std::size_t k = 0; k < held_.size(); ++k)
      if (!held_[k].rests) relations.push_back(static_cast<std::uint32_t>(moving_[k].relation));
    known_ = equations_.look_at(given_ ? std::vector<std::uint32_t>{} : enclosure_.tears(), std::move(relations));
    for (std::size_t k = 0; known_ && k < equations_.states().size(); ++k) {
      const auto at = std::find(unknowns_.begin(), unknowns_.end(), equations_.states()[k]);
      of_equations_.push_back(static_cast<std::size_t>(at - unknowns_.begin()));
      if (at == unknowns_.end()) unknowns_.push_back(equations_.states()[k]);
    }
    least_ = (integrator.time() - integrator.previous()) / kSampledParts;
  }
  if (unknowns_.empty()) return;
  polynomial_.take(integrator.previous(), integrator.time(), integrator.order(), unknowns_, integrator.size(),
                   [&integrator](double t, double* y) { integrator.interpolate(t, y); });
}

bool GuardFunctions::evaluate(double t) {
  if (!owner_.evaluate(t)) return false;
  if (is_enclosed_by_polynomials()) return true;
  Solved& here = solved_.emplace_back(Solved{t, owner_.branch().tears, {}});
  for (const Enclosure::MovingMode& mode : moving_) here.modes.push_back(owner_.branch().modes[mode.relation]);
  return true;
}

bool GuardFunctions::is_enclosed_by_polynomials() const {
  return held_.empty() && (given_ || enclosure_.tears().empty());
}

const GuardFunctions::Solved* GuardFunctions::solved_at(double t) {
  auto found = std::find_if(solved_.begin(), solved_.end(), [t](const Solved& known) { return known.t == t; });
  if (found != solved_.end()) return &*found;
  if (!evaluate(t)) return nullptr;
  return &solved_.back();
}

const std::vector<bool>& GuardFunctions::free_of(const std::vector<std::size_t>& relations) {
  if (!free_.empty() && relations == varying_) return free_;
  varying_ = relations;
  const std::vector<ExprId> roots = guard_expressions(program_);
  const std::vector<ExprId> nodes = reachable(program_.pool, roots);
  const auto position = positions(nodes);
  std::vector<char> varies(program_.symbol_names.size(), 0);
  const auto mark = [&](std::size_t slot) {
    varies[program_.pool.symbol_of(program_.slot_expression[slot]).index()] = 1;
  };
  for (std::size_t slot = program_.first_tear; slot < program_.first_mode; ++slot) mark(slot);
  for (const std::size_t relation : relations) mark(program_.first_mode + relation);
  const std::vector<char> depends =
      depends_on(program_.pool, nodes, position, [&](SymbolId symbol) { return varies[symbol.index()] != 0; });
  free_.clear();
  for (const Guard& guard : guards_) free_.push_back(depends[*position.find(roots[guard.root])] == 0);
  return free_;
}

bool GuardFunctions::enclose(double from, double to) {
  const std::size_t states = enclosure_.states().size(), tears = enclosure_.tears().size();
  states_.resize(states);
  tears_.resize(tears);
  middle_ = from + (to - from) / 2;
  for (std::size_t k = 0; k < states; ++k) states_[k] = polynomial_.over(k, from, to);
  for (std::size_t k = 0; given_ && k < tears; ++k) tears_[k] = polynomial_.over(states + k, from, to);
  if (!is_enclosed_by_polynomials()) {
    for (const double t : {from, middle_, to})
      if (solved_at(t) == nullptr) return false;
    const Solved &left = *solved_at(from), &centre = *solved_at(middle_), &right = *solved_at(to);
    const auto follow = [&](const std::vector<double> Solved::*values, std::size_t k) {
      return parabola((left.*values)[k], (centre.*values)[k], (right.*values)[k], to - from);
    };
    for (std::size_t k = 0; !given_ && k < tears; ++k) tears_[k] = follow(&Solved::tears, enclosure_.tears()[k]);
    for (std::size_t k = 0; k < moving_.size(); ++k) moving_[k].over = follow(&Solved::modes, k);
    if (known_ && !enclose_solved(from, to, {&left, &centre, &right}) && to - from > least_) {
      const Jet unknown{0.0, kAllNumbers, kAllNumbers, 0.0, kAllNumbers};
      for (Jet& tear : tears_)
        if (!given_) tear = unknown;
      for (std::size_t k = 0; k < held_.size(); ++k)
        if (!held_[k].rests) moving_[k].over = unknown;
    }
  }
  enclosure_.evaluate(from, to, states_, tears_, moving_);
  return true;
}

/// In tears_ and moving_. False, with these as they are, where nothing is known.
bool GuardFunctions::enclose_solved(double from, double to, const std::array<const Solved*, 3>& at) {
  of_equations_over_.clear();
  for (const std::size_t k : of_equations_) of_equations_over_.push_back(polynomial_.over(k, from, to));
  std::vector<double> middle;
  std::vector<Range> about;
  const auto add = [&](double left, double centre, double right) {
    const Range along = parabola(left, centre, right, to - from).value;
    const double more = 0.5 * (along.upper() - along.lower());
    middle.push_back(centre);
    about.emplace_back(along.lower() - more, along.upper() + more);
  };
  const std::vector<std::uint32_t>& tears = equations_.tears();
  for (const std::uint32_t tear : tears) add(at[0]->tears[tear], at[1]->tears[tear], at[2]->tears[tear]);
  for (std::size_t k = 0; k < held_.size(); ++k)
    if (!held_[k].rests) add(at[0]->modes[k], at[1]->modes[k], at[2]->modes[k]);
  std::vector<double> modes = modes_;
  for (std::size_t k = 0; k < held_.size(); ++k)
    if (held_[k].rests) modes[moving_[k].relation] = at[1]->modes[k];
  if (!equations_.enclose(from, to, of_equations_over_, modes, middle, std::move(about))) return false;
  for (std::size_t k = 0; !given_ && k < enclosure_.tears().size(); ++k) {
    const auto found = std::lower_bound(tears.begin(), tears.end(), enclosure_.tears()[k]);
    tears_[k] = equations_[static_cast<std::size_t>(found - tears.begin())];
  }
  std::size_t next = tears.size();
  for (std::size_t k = 0; k < held_.size(); ++k)
    if (!held_[k].rests) moving_[k].over = equations_[next++];
  return true;
}

/// What a mode has left of its sides.
Jet GuardFunctions::left(std::size_t held) const {
  if (held_[held].rests) return {1.0, {1.0, 1.0}};
  const auto& [relation, mode] = moving_[held];
  const double low = program_.relations[relation].kind == Relation::Kind::sign ? -1.0 : 0.0, high = 1.0;
  const auto at = [&](double value) { return std::min(value - low, high - value); };
  const double middle = low + (high - low) / 2, least = mode.value.lower(), most = mode.value.upper();
  const double largest = least > middle ? at(least) : most < middle ? at(most) : high - middle;
  Jet jet{at(mode.middle), {std::min(at(least), at(most)), largest}};
  if (most < middle)
    jet.slope = mode.slope;
  else if (least > middle)
    jet.slope = -mode.slope;
  else
    jet.slope = {std::min(mode.slope.lower(), -mode.slope.upper()), std::max(mode.slope.upper(), -mode.slope.lower())};
  return jet;
}

Jet GuardFunctions::jet(std::size_t guard) const {
  for (std::size_t k = 0; k < held_.size(); ++k)
    if (held_[k].guard == guard) return left(k);
  const Guard& g = guards_[guard];
  Jet jet = enclosure_[g.root];
  if (g.border == 0) return jet;
  const auto [lower, upper] = mode_borders(program_, program_.relations[g.relation], modes_[g.relation]);
  if (g.border < 0) return {jet.middle - lower, jet.value - lower, jet.slope};
  return {upper - jet.middle, upper - jet.value, -jet.slope};
}

}  // namespace bgsim
