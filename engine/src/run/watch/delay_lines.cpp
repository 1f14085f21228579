#include "run/watch/delay_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "run/failures.hpp"
#include "run/watch/sharp_laws.hpp"

namespace bgsim {

DelayTables own_tables(const Program& program) {
  DelayTables tables;
  for (const ProgramDelay& delay : program.delays)
    tables.push_back(std::make_shared<Table>(program.pool.table(delay.table)));
  return tables;
}

Program with_tables(const Program& shared, const DelayTables& tables) {
  Program program = shared;
  for (std::size_t i = 0; i < tables.size(); ++i) program.pool.replace_table(program.delays[i].table, tables[i]);
  return program;
}

DelayLines::DelayLines(const Program& program, Evaluator& evaluator, const RunInputs& inputs, const DelayTables& tables)
    : program_(program),
      evaluator_(evaluator),
      stop_(inputs.stop),
      relative_(inputs.relative),
      tables_(tables),
      values_(kPerDelay * tables.size()),
      y_(program.state_names.size() + program.tear_names.size()) {
  memory_.lines.resize(tables.size());
  memory_.start = memory_.recorded = inputs.start;
  memory_.passed_at = -std::numeric_limits<double>::infinity();
  know_bounds(inputs);
}

void DelayLines::know_bounds(const RunInputs& inputs) {
  const auto bounds = [&](const Routine& routine, std::size_t results) {
    std::vector<ExprId> roots;
    for (std::size_t i = 0; i < tables_.size(); ++i)
      roots.push_back(program_.slot_expression[routine.results[results * i]]);
    const std::vector<ExprId> nodes = reachable(program_.pool, roots);
    const bool sharp = std::any_of(nodes.begin(), nodes.end(),
                                   [&](ExprId e) { return may_be_sharp(program_.pool, program_.pool[e]); });
    std::optional<Enclosure> enclosure;
    if (sharp) enclosure.emplace(program_, inputs.parameters, roots);
    if (enclosure && !enclosure->tears().empty()) enclosure.reset();
    return enclosure;
  };
  bounds_ = bounds(program_.delayed, 2);
  bounds_before_ = bounds(program_.delayed_before, 1);
  if (bounds_before_ && !bounds_before_->states().empty()) bounds_before_.reset();
}

void DelayLines::clear() {
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    tables_[i]->x = {-1.0, 0.0};
    tables_[i]->y = tables_[i]->slope2 = {0.0, 0.0};
    frame(i);
  }
}

bool DelayLines::evaluate(double t, const double* x, Branch& branch, std::vector<double>& values) {
  std::vector<double>& now = now_;
  now.resize(2 * memory_.lines.size());
  if (evaluator_.delayed(t, x, branch, now.data())) {
    for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
      values[kPerDelay * i] = now[2 * i];
      values[kPerDelay * i + 1] = now[2 * i + 1];
    }
    return true;
  }
  failure_ = fault_failure(evaluator_.fault());
  return false;
}

bool DelayLines::begin(double t, const double* x, Branch& branch) {
  constexpr int kMostTimes = 1000;
  constexpr double kSame = 1e-14;
  if (!any()) return true;
  if (!evaluate(t, x, branch, values_)) return false;
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    memory_.lines[i].by = values_[kPerDelay * i + 1];
    memory_.lines[i].knots.clear();
    memory_.lines[i].dropped = memory_.lines[i].window = 0;
  }
  // Where the model says what was before the start, that is sampled; where not, it is what u is at the start.
  std::vector<bool> constant(memory_.lines.size());
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    constant[i] = !program_.delays[i].initial;
    tables_[i]->x.clear();
    tables_[i]->y.clear();
    tables_[i]->slope2.clear();
    if (constant[i]) {
      const double u = values_[kPerDelay * i];
      append(i, t - memory_.lines[i].by, t, {u, u, u, u});
    } else if (!sample_before(i, t, x, branch)) {
      return false;
    }
    frame(i);
  }
  for (int step = 0;; ++step) {
    if (!evaluate(t, x, branch, values_)) return false;
    bool same = true;
    for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
      if (!constant[i]) continue;
      std::vector<double>& y = tables_[i]->y;
      const double u = values_[kPerDelay * i];
      same = same && std::abs(u - y.front()) <= kSame * std::max(std::abs(u), std::abs(y.front()));
      std::fill(y.begin(), y.end(), u);
    }
    if (same) break;
    if (step < kMostTimes) continue;
    const ProgramDelay& delay = program_.delays.front();
    failure_ = diagnostic_of("BG629",
                             "what the delayed signal " + in_quotes(delay.name) +
                                 " was before the start follows from itself, and has not been found",
                             delay.place, "without \"initial\" it was always what it is at the start",
                             "add \"initial\": what it was before the start, over t and parameters");
    return false;
  }
  memory_.recorded = t;
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    Line& line = memory_.lines[i];
    const double before = tables_[i]->y.back(), u = values_[kPerDelay * i];
    line.scale = std::max({line.scale, std::abs(before), std::abs(u)});
    line.knots.push_back({t, cells(i), std::abs(u - before) > 1e-12 * line.scale ? 0 : 1});
    frame(i);
  }
  return true;
}

/// What the model says of the time before the start, with its jumps.
bool DelayLines::sample_before(std::size_t line, double t, const double* x, const Branch& branch) {
  branch_ = branch;
  splits_ = splits_of_a_step();
  const auto before = [&](double at, double* y, Branch&) {
    std::copy_n(x, program_.state_names.size(), y);
    y[program_.delays[line].clock] = at - memory_.start;
  };
  for (double from = t - memory_.lines[line].by; from < t;) {
    evaluator_.set_time_modes(from, branch_);
    const double to = evaluator_.next_time_event(from, t).value_or(t);
    if (bounds_before_) bounds_before_->set_modes(branch_.modes);
    if (!sample(from, to, kPerDelay * line + 2, before)) return false;
    if (to < t) memory_.lines[line].knots.push_back({to, cells(line), 0});
    from = to;
  }
  return true;
}

/// Results at a time before the start, where only those of `initial` have a meaning.
bool DelayLines::evaluate_before(double t, const double* x, std::vector<double>& values) {
  std::vector<double> initial(program_.delays.size());
  if (!evaluator_.delayed_before(t, x, branch_, initial.data())) {
    failure_ = fault_failure(evaluator_.fault());
    return false;
  }
  for (std::size_t i = 0; i < initial.size(); ++i) values[kPerDelay * i + 2] = initial[i];
  return true;
}

/// Two times that are nearer than this are one.
double DelayLines::resolved(double t) const {
  constexpr double kRoundings = 32.0 * std::numeric_limits<double>::epsilon();
  return kRoundings * std::max({std::abs(t), std::abs(memory_.start), stop_ - memory_.start});
}

double DelayLines::longest() const {
  double least = 0.0;
  for (const Line& line : memory_.lines) least = least == 0.0 ? line.by : std::min(least, line.by);
  return least;
}

bool DelayLines::due(double t) const {
  return std::any_of(memory_.lines.begin(), memory_.lines.end(), [&](const Line& line) {
    return !line.knots.empty() && line.knots.front().t + line.by <= t + resolved(t);
  });
}

std::optional<double> DelayLines::next(double t) const {
  std::optional<double> first;
  for (const Line& line : memory_.lines)
    for (const DelayMemory::Knot& knot : line.knots) {
      const double at = knot.t + line.by;
      if (!(at > t + resolved(t))) continue;
      if (at <= stop_ && (!first || at < *first)) first = at;
      break;
    }
  return first;
}

void DelayLines::pass(double t) {
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    Line& line = memory_.lines[i];
    std::size_t passed = 0;
    while (passed < line.knots.size() && line.knots[passed].t + line.by <= t + resolved(t)) {
      memory_.passing =
          memory_.passed_at == t ? std::min(memory_.passing, line.knots[passed].level) : line.knots[passed].level;
      memory_.passed_at = t;
      line.window = line.knots[passed++].cell;
    }
    line.knots.erase(line.knots.begin(), line.knots.begin() + static_cast<std::ptrdiff_t>(passed));
    forget(i, t);
    frame(i);
  }
}

/// Where the table is to be looked up: from the last knot that was passed to the next.
void DelayLines::frame(std::size_t index) {
  const Line& line = memory_.lines[index];
  Table& table = *tables_[index];
  const std::size_t first = 2 * (line.window - line.dropped);
  const std::size_t end = line.knots.empty() ? table.x.size() : 2 * (line.knots.front().cell - line.dropped);
  table.first = std::min(first, table.x.size() < 2 ? 0 : table.x.size() - 2);
  table.last = std::max(std::min(end, table.x.size()), table.first + 2) - 1;
}

/// Cells that y has left.
void DelayLines::forget(std::size_t index, double t) {
  constexpr std::size_t kWorthIt = 4096;
  Line& line = memory_.lines[index];
  Table& table = *tables_[index];
  std::size_t old = 0;
  const std::size_t window = line.window - line.dropped;
  const double oldest = t - memory_.start - 2.0 * line.by;
  while (old < window && table.x[2 * old + 1] < oldest) ++old;
  if (2 * old < kWorthIt) return;
  const auto gone = static_cast<std::ptrdiff_t>(2 * old);
  table.x.erase(table.x.begin(), table.x.begin() + gone);
  table.y.erase(table.y.begin(), table.y.begin() + gone);
  table.slope2.erase(table.slope2.begin(), table.slope2.begin() + gone);
  line.dropped += old;
}

/// The cubic through values at both ends and at the thirds between them.
void DelayLines::append(std::size_t line, double from, double to, const std::array<double, 4>& values) {
  Table& table = *tables_[line];
  const double h = to - from, third = h / 3.0;
  table.x.push_back(from - memory_.start);
  table.x.push_back(to - memory_.start);
  table.y.push_back(values[0]);
  table.y.push_back(values[3]);
  table.slope2.push_back((2.0 * values[0] - 5.0 * values[1] + 4.0 * values[2] - values[3]) / (third * third));
  table.slope2.push_back((-values[0] + 4.0 * values[1] - 5.0 * values[2] + 2.0 * values[3]) / (third * third));
}

bool DelayLines::add(double to, int degree, const Branch& branch, const Solution& solution) {
  // Two events a rounding apart: over that nothing has a slope. It becomes part of what comes next.
  if (!any() || !(to > memory_.recorded + resolved(to))) return true;
  branch_ = branch;
  splits_ = splits_of_a_step();
  if (bounds_) {
    bounds_->set_modes(branch_.modes);
    polynomial_.take(memory_.recorded, to, degree, bounds_->states(), y_.size(),
                     [&](double t, double* y) { solution(t, y, branch_); });
  }
  if (!sample(memory_.recorded, to, 0, solution)) return false;
  memory_.recorded = to;
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    Line& line = memory_.lines[i];
    if (line.knots.empty()) {
      // What is behind the last knot is one piece; what y has left of it is behind the window.
      const double left = to - memory_.start - 2.0 * line.by;
      while (line.window + 1 < cells(i) && tables_[i]->x[2 * (line.window - line.dropped) + 1] < left) ++line.window;
      forget(i, to);
    }
    frame(i);
  }
  return true;
}

/// A piece of a step, and how far the cubics through its thirds are off between them.
struct DelayLines::Piece {
  double from = 0.0, to = 0.0;
  std::vector<std::array<double, 4>> thirds;  ///< by line
  double off = 0.0;                           ///< of the worst line, in parts of what its record may be off by
  std::size_t worst = 0;
};

bool DelayLines::measure(Piece& piece, std::size_t which, const Solution& solution) {
  constexpr std::array<double, kPlaces> kPoints{0.0, 1.0 / 6, 1.0 / 3, 0.5, 2.0 / 3, 5.0 / 6, 1.0};
  std::array<std::vector<double>, kPlaces>& at = at_;
  for (std::size_t k = 0; k < kPoints.size(); ++k) {
    const double t = k + 1 == kPoints.size() ? piece.to : piece.from + kPoints[k] * (piece.to - piece.from);
    solution(t, y_.data(), branch_);
    at[k].resize(values_.size());
    if (which == 0 ? !evaluate(t, y_.data(), branch_, at[k]) : !evaluate_before(t, y_.data(), at[k])) return false;
  }
  piece.thirds.resize(memory_.lines.size());
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    if (which != 0 && i != which / kPerDelay) continue;
    const std::size_t result = which == 0 ? kPerDelay * i : which;
    // What comes later in the step is no measure: a bell's tail is fed to states that have seen nothing larger.
    double scale = std::max(memory_.lines[i].scale, kLeastScale), steepest = 0.0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      scale = std::max(scale, std::abs(at[k][result]));
      if (k > 0) steepest = std::max(steepest, std::abs(at[k][result] - at[k - 1][result]));
    }
    // The time is rounded, too: what u changes by in as much is noise.
    const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(piece.from), std::abs(piece.to));
    const double noise = rounding * steepest * (kPoints.size() - 1.0) / (piece.to - piece.from);
    const double tolerance = std::max(kOfTolerance * relative_, kLeastTolerance) * scale + noise;
    const double a = at[0][result], b = at[2][result], c = at[4][result], d = at[6][result];
    piece.thirds[i] = {a, b, c, d};
    for (const std::size_t k : {1U, 3U, 5U}) {
      const double r = 3.0 * kPoints[k];
      const double cubic = a * (r - 1) * (r - 2) * (r - 3) / -6.0 + b * r * (r - 2) * (r - 3) / 2.0 -
                           c * r * (r - 1) * (r - 3) / 2.0 + d * r * (r - 1) * (r - 2) / 6.0;
      const double off = std::abs(cubic - at[k][result]);
      if (!(off <= piece.off * tolerance)) {
        piece.off = std::isfinite(off) ? off / tolerance : std::numeric_limits<double>::infinity();
        piece.worst = i;
      }
    }
  }
  std::optional<Enclosure>& bounds = which == 0 ? bounds_ : bounds_before_;
  if (bounds && piece.off <= 1.0) look_between(*bounds, piece, which);
  return true;
}

/// How far u may be outside of its values at the places of a piece, in parts of what it may be.
void DelayLines::look_between(Enclosure& bounds, Piece& piece, std::size_t which) {
  jets_.resize(bounds.states().size());
  if (!jets_.empty()) polynomial_.over(piece.from, piece.to, jets_);
  bounds.evaluate(piece.from, piece.to, jets_, {});
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    if (which != 0 && i != which / kPerDelay) continue;
    const std::size_t result = which == 0 ? kPerDelay * i : which;
    double least = at_.front()[result], most = least;
    for (const auto& values : at_) {
      least = std::min(least, values[result]);
      most = std::max(most, values[result]);
    }
    const double scale = std::max({memory_.lines[i].scale, kLeastScale, most, -least});
    const Range& all = bounds[i].value;
    const double outside = std::max(all.upper() - most, least - all.lower());
    const double part = outside / (kOutside * (most - least) + kOutsideOfScale * scale);
    if (!std::isfinite(outside) || !(part > std::max(1.0, piece.off))) continue;
    piece.off = part;
    piece.worst = i;
  }
}

/// Cubics over [from, to] that agree with u between their knots. @param which  0: of all lines; else the result that is
/// sampled, of one line. The piece that is worst is split first, as often as doubles allow: what is rough everywhere,
/// as what loops leave of their tolerance, takes no splits from what is steep.
bool DelayLines::sample(double from, double to, std::size_t which, const Solution& solution) {
  const auto better = [](const Piece& one, const Piece& other) { return one.off < other.off; };
  std::vector<Piece> open(1), done;
  open.front().from = from;
  open.front().to = to;
  if (!measure(open.front(), which, solution)) return false;
  while (!open.empty()) {
    std::pop_heap(open.begin(), open.end(), better);
    Piece piece = std::move(open.back());
    open.pop_back();
    const bool shortest = !(piece.to - piece.from > resolved(piece.to));
    if (piece.off <= 1.0 || shortest || splits_ == 0) {
      if (!shortest && piece.off > 1.0 / kOfTolerance && !memory_.coarse_at) {
        memory_.coarse_at = piece.from;
        memory_.coarse = piece.worst;
      }
      done.push_back(std::move(piece));
      continue;
    }
    --splits_;
    ++memory_.splits;
    const double middle = piece.from + (piece.to - piece.from) / 2;
    for (const auto& [begin, end] : {std::pair(piece.from, middle), std::pair(middle, piece.to)}) {
      Piece& half = open.emplace_back();
      half.from = begin;
      half.to = end;
      if (!measure(half, which, solution)) return false;
      std::push_heap(open.begin(), open.end(), better);
    }
  }
  std::sort(done.begin(), done.end(), [](const Piece& one, const Piece& other) { return one.from < other.from; });
  for (const Piece& piece : done)
    for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
      if (which != 0 && i != which / kPerDelay) continue;
      append(i, piece.from, piece.to, piece.thirds[i]);
      for (const double value : piece.thirds[i])
        memory_.lines[i].scale = std::max(memory_.lines[i].scale, std::abs(value));
    }
  return true;
}

bool DelayLines::changed(double t, const double* x, Branch& branch, bool mode) {
  constexpr double kJump = 1e-9;
  if (!any()) return true;
  if (!evaluate(t, x, branch, values_)) return false;
  for (std::size_t i = 0; i < memory_.lines.size(); ++i) {
    Line& line = memory_.lines[i];
    const double u = values_[kPerDelay * i];
    line.scale = std::max(line.scale, std::abs(u));
    const bool jumps = std::abs(u - tables_[i]->y.back()) > kJump * line.scale;
    int level = jumps ? 0 : memory_.passed_at == t && !mode ? memory_.passing + 1 : 1;
    if (!line.knots.empty() && line.knots.back().cell == cells(i)) {
      line.knots.back().level = std::min(line.knots.back().level, level);
      continue;  // nothing has been recorded since the one before
    }
    if (level >= kSmooth) continue;
    line.knots.push_back({t, cells(i), level});
    frame(i);
  }
  return true;
}

}  // namespace bgsim
