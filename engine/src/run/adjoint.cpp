#include "run/adjoint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "run/adjoint_guards.hpp"
#include "run/adjoint_step.hpp"
#include "run/clock.hpp"
#include "run/failures.hpp"
#include "run/integrate/radau_formula.hpp"
#include "run/variation.hpp"
#include "run/watch/pace_words.hpp"

namespace bgsim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::span<double> of(VectorXd& values) { return {values.data(), static_cast<std::size_t>(values.size())}; }

/// Where 0 is as good a unit as any.
double unit_of(double largest) { return largest > 0.0 ? largest : 1.0; }

/// The run back.
class Backward {
 public:
  Backward(const Program& program, const RunInputs& inputs, const Trajectory& trajectory,
           const std::vector<AdjointFigure>& figures, const std::vector<AdjointSeed>& seeds, const SimulateOptions& how)
      : program_(program),
        inputs_(inputs),
        trajectory_(trajectory),
        figures_(figures),
        asked_(figures.size()),
        seeds_(seeds),
        evaluator_(program, inputs.parameters),
        stages_(program.jacobian_pattern),
        integrals_(std::any_of(figures.begin(), figures.end(),
                               [](const AdjointFigure& f) { return f.kind != AdjointFigure::Kind::value; })),
        events_(program.state_names.size(), integrals_, inputs.stop - inputs.start),
        how_(how),
        clock_(how_, wall_seconds, inputs.stop) {
    if (how_.time_limit == 0.0) how_.time_limit = how_.longest_run;
    evaluator_.watch([this] { return clock_.look(); });
    const auto n = static_cast<Index>(program.state_names.size());
    const auto m = static_cast<Index>(program.transposed.columns.size());
    const auto k = static_cast<Index>(figures.size());
    for (const double largest : trajectory.largest()) units_.push_back(unit_of(largest));
    for (const std::uint32_t parameter : program.transposed.columns)
      units_.push_back(unit_of(std::abs(inputs.parameters[parameter])));
    now_ = {MatrixXd::Zero(n, k), MatrixXd::Zero(m, k)};
    largest_ = now_;
    by_instant_ = VectorXd::Zero(k);
    outputs_.resize(program.output_names.size());
    pending_.assign(figures.size(), false);
    for (std::size_t i = 0; i < figures.size(); ++i) pending_[i] = figures[i].kind == AdjointFigure::Kind::value;
  }

  AdjointResult run() {
    result_.value.assign(asked_, 0.0);
    if (look_at_events() && look_beyond_end()) go_back();
    if (!result_.failure) gather();
    return std::move(result_);
  }

 private:
  /// Adjoints by state and integrals by parameter, of each figure; or their rates backward in time.
  struct Adjoints {
    MatrixXd states, columns;
  };

  bool fail(Diagnostic diagnostic) {
    result_.failure = std::move(diagnostic);
    return false;
  }
  bool fail_with_fault() {
    return clock_.end() != RunClock::End::none ? fail_by_clock() : fail(fault_failure(evaluator_.fault()));
  }
  bool fail_by_clock() {
    return fail(clock_.end() == RunClock::End::interrupted
                    ? interrupted_failure(reached_)
                    : time_limit_failure(reached_, inputs_.start, how_.time_limit));
  }
  bool fail_to(double t, const char* what) {
    return fail(diagnostic_of("BG414", "at t = " + number_text(t) + ": the adjoint equations " + what, {},
                              "they are followed backward, through the slopes of all laws on the way",
                              "ask for --method forward"));
  }

  /// Events forward, as a run with sensitivities meets them.
  bool look_at_events() {
    FreeGuards at_start(program_, inputs_, units_, &seeds_), guards(program_, inputs_, units_, nullptr);
    if (auto refused = events_.begin(evaluator_, at_start, inputs_.start, trajectory_.start(),
                                     trajectory_.start_branch(), !inputs_.starting_events.empty()))
      return fail(std::move(*refused));
    for (const Trajectory::Event& event : trajectory_.events()) {
      std::optional<Diagnostic> refused;
      if (event.sets.empty()) {
        jumps_.push_back(
            events_.take(evaluator_, guards, event.t, event.x, event.before, event.after, event.crossed, refused));
      } else if (auto instant = events_.instant_of_set(guards, program_.events[event.sets.front()], event.t, refused)) {
        if (instant->empty()) instant->assign(units_.size(), 0.0);
        jumps_.push_back(VariationEvents::Jump{std::move(*instant), {}});
      }
      if (refused) return fail(std::move(*refused));
      instants_.push_back(events_.instant(guards, event.t));
    }
    return true;
  }

  /// Derivatives by state and parameter of the figures that are values at the run's end, at this point; of integrals,
  /// which have nothing of it, 0. False if they are not known.
  bool figures_at(double t, const std::vector<double>& x, const Branch& branch, Adjoints& figures,
                  std::vector<double>& values) {
    figures = {MatrixXd::Zero(now_.states.rows(), now_.states.cols()),
               MatrixXd::Zero(now_.columns.rows(), now_.columns.cols())};
    values.assign(asked_, 0.0);
    VectorXd by_states;
    std::vector<double> by_columns;
    Branch here = branch;
    for (std::size_t k = 0; k < asked_; ++k) {
      if (figures_[k].kind != AdjointFigure::Kind::value || figures_[k].time < t) continue;
      if (!slopes_of(figures_[k].output, t, x, here, by_states, by_columns)) return false;
      const auto column = static_cast<Index>(k);
      values[k] = outputs_[figures_[k].output];
      figures.states.col(column) = by_states;
      figures.columns.col(column) = Eigen::Map<const VectorXd>(by_columns.data(), figures.columns.rows());
    }
    return figures.states.allFinite() && figures.columns.allFinite();
  }

  /// A further column, which is followed back from here on.
  std::size_t add_column(const AdjointFigure& figure, const VectorXd& states, const VectorXd& parameters) {
    const Index column = now_.states.cols();
    for (Adjoints* each : {&now_, &largest_}) {
      each->states.conservativeResize(Eigen::NoChange, column + 1);
      each->columns.conservativeResize(Eigen::NoChange, column + 1);
      each->states.col(column) = states;
      each->columns.col(column) = parameters;
    }
    largest_.states.col(column) = states.cwiseAbs();
    largest_.columns.col(column) = parameters.cwiseAbs();
    by_instant_.conservativeResize(column + 1);
    by_instant_[column] = 0.0;
    figures_.push_back({figure.output, AdjointFigure::Kind::value, figure.time});
    pending_.push_back(false);
    begun_ = false;
    return figures_.size() - 1;
  }

  /// The other side of an event at the end of the run. From here on the event's instant, and by how much the figures
  /// differ on both sides, are followed back as well: the difference is as exact as a figure, however small it is
  /// beside one.
  /// @param instant  t' by states and parameters; none: not known
  /// @param other    null: not known
  void add_side(const std::optional<std::vector<double>>& instant, const Adjoints& here, const Adjoints* other,
                std::vector<double> values) {
    if (instant && std::all_of(instant->begin(), instant->end(), [](double by) { return by == 0.0; })) return;
    const Index n = now_.states.rows(), m = now_.columns.rows();
    Side side;
    side.values = std::move(values);
    if (instant)
      side.instant = add_column(figures_.front(), Eigen::Map<const VectorXd>(instant->data(), n),
                                Eigen::Map<const VectorXd>(instant->data() + n, m));
    for (std::size_t k = 0; k < asked_ && other != nullptr; ++k) {
      const auto from = static_cast<Index>(k);
      side.figures.push_back(add_column(figures_[k], here.states.col(from) - other->states.col(from),
                                        here.columns.col(from) - other->columns.col(from)));
    }
    sides_.push_back(std::move(side));
  }

  /// An event at the end of the run, behind which figures have been followed: those of a run that ends before it.
  /// Between what is set at one instant no run ends.
  bool look_beside(std::size_t event) {
    const Trajectory::Event& at = trajectory_.events()[event];
    if (instant_ != nullptr || !is_end(at.t, inputs_.start, inputs_.stop)) return true;
    Adjoints other;
    std::vector<double> values;
    if (!figures_at(at.t, at.x, at.before, other, values)) return fail_with_fault();
    const Adjoints here = now_;
    add_side(instants_[event], here, &other, std::move(values));
    return true;
  }

  /// Conditions at their borders as the run ends: the figures of a run that ends behind their changes.
  bool look_beyond_end() {
    const std::vector<Trajectory::Stretch>& stretches = trajectory_.stretches();
    if (!stretches.back().steps.empty())
      trajectory_.interpolate(stretches.back().steps.back(), inputs_.stop, x_);
    else
      x_ = trajectory_.events().empty() ? trajectory_.start() : trajectory_.events().back().behind();
    FreeGuards guards(program_, inputs_, units_, nullptr);
    const Branch& end = stretches.back().end;
    const std::vector<VariationEvents::Ahead> ahead = events_.ahead(evaluator_, guards, inputs_.stop, x_, end);
    if (ahead.empty()) return true;
    Adjoints here, other;
    std::vector<double> values;
    if (!figures_at(inputs_.stop, x_, end, here, values)) return fail_with_fault();
    for (const VariationEvents::Ahead& each : ahead) {
      const bool known =
          !each.sets && !each.jump.rates.empty() && figures_at(inputs_.stop, x_, each.behind, other, values);
      if (known) cross(other, each.jump, inputs_.stop, x_, end, each.behind);
      add_side(each.jump.instant, here, known ? &other : nullptr, values);
    }
    return true;
  }

  bool go_back() {
    const std::vector<Trajectory::Stretch>& stretches = trajectory_.stretches();
    for (std::size_t s = stretches.size(); s-- > 0;) {
      branch_ = stretches[s].end;
      begun_ = false;
      for (std::size_t i = stretches[s].steps.size(); i-- > 0;) {
        const Trajectory::Step& step = stretches[s].steps[i];
        double t = step.to;
        while (true) {
          trajectory_.interpolate(step, t, x_);
          if (!inject(t)) return false;
          double to = step.from;
          for (std::size_t k = 0; k < figures_.size(); ++k)
            if (pending_[k] && figures_[k].time < t) to = std::max(to, figures_[k].time);
          if (!follow(step, t, to)) return false;
          t = to;
          if (!(t > step.from)) break;
        }
      }
      const double begins = s > 0 ? trajectory_.events()[s - 1].t : inputs_.start;
      x_ = s > 0 ? trajectory_.events()[s - 1].behind() : trajectory_.start();
      if (!inject(begins)) return false;
      if (s == 0) break;
      if (trajectory_.events()[s - 1].sets.empty())
        cross(s - 1);
      else if (!cross_set(s - 1))
        return false;
      if (s == 1 || trajectory_.events()[s - 2].t < begins) move_instant();
      if (!look_beside(s - 1)) return false;
    }
    return true;
  }

  /// What an output, which outputs_ has then, changes by with the states, and with the parameters and the time.
  bool slopes_of(std::size_t output, double t, const std::vector<double>& x, Branch& branch, VectorXd& by_states,
                 std::vector<double>& by_columns) {
    std::vector<double> weights(outputs_.size(), 0.0);
    weights[output] = 1.0;
    by_states.resize(now_.states.rows());
    by_columns.resize(columns() + 1);
    if (!evaluator_.outputs(t, x.data(), branch, outputs_.data()) ||
        !evaluator_.take_partials(t, x.data(), branch, Evaluator::Rows::outputs))
      return false;
    evaluator_.pull_back({}, weights, of(by_states), by_columns);
    return true;
  }

  /// Values of outputs at this time and at x_ count from here on.
  bool inject(double t) {
    for (std::size_t k = 0; k < figures_.size(); ++k) {
      if (!pending_[k] || figures_[k].time < t) continue;
      pending_[k] = false;
      std::vector<double> by_columns;
      VectorXd by_states;
      if (!slopes_of(figures_[k].output, t, x_, branch_, by_states, by_columns)) return fail_with_fault();
      const auto column = static_cast<Index>(k);
      now_.states.col(column) += by_states;
      for (std::size_t i = 0; i < columns(); ++i) now_.columns(static_cast<Index>(i), column) += by_columns[i];
      result_.value[k] = outputs_[figures_[k].output];
      if (!now_.states.allFinite() || !now_.columns.allFinite())
        return fail_to(t, "have no value: an output has no slope");
      begun_ = false;
    }
    grow(now_);
    return true;
  }

  void grow(const Adjoints& values) {
    largest_.states = largest_.states.cwiseMax(values.states.cwiseAbs());
    largest_.columns = largest_.columns.cwiseMax(values.columns.cwiseAbs());
  }

  /// Back over an event: the transposed saltation matrix.
  void cross(std::size_t event) {
    begun_ = false;
    if (!jumps_[event]) return;
    const Trajectory::Event& at = trajectory_.events()[event];
    cross(now_, *jumps_[event], at.t, at.x, at.before, at.after);
    grow(now_);
  }
  void cross(Adjoints& adjoints, const VariationEvents::Jump& jump, double t, const std::vector<double>& x,
             const Branch& before, const Branch& after) {
    const Index n = adjoints.states.rows();
    for (Index k = 0; k < adjoints.states.cols(); ++k) {
      double gain = adjoints.states.col(k).dot(Eigen::Map<const VectorXd>(jump.rates.data(), n));
      const AdjointFigure& figure = figures_[static_cast<std::size_t>(k)];
      const std::size_t output = static_cast<std::size_t>(n) + figure.output;
      if (figure.kind == AdjointFigure::Kind::integral) gain += jump.rates[output];
      if (figure.kind == AdjointFigure::Kind::square) gain += square_jump(t, x, before, after, figure.output);
      adjoints.states.col(k) += gain * Eigen::Map<const VectorXd>(jump.instant.data(), n);
      adjoints.columns.col(k) += gain * Eigen::Map<const VectorXd>(jump.instant.data() + n, adjoints.columns.rows());
    }
  }

  /// Back over what events set: x+ = h(x-, z, p, t) of the states that are set, at an instant that follows x- and p.
  bool cross_set(std::size_t event) {
    begun_ = false;
    const Trajectory::Event& at = trajectory_.events()[event];
    instant_ = &jumps_[event]->instant;
    const Index n = now_.states.rows();
    VectorXd before(n), after(n), by_states(n);
    std::vector<double> outputs_before(outputs_.size()), by_columns(columns() + 1);
    Branch here = at.before, behind = at.after;
    if (!evaluator_.rates(at.t, at.x_after.data(), behind, after.data()) ||
        !evaluator_.outputs(at.t, at.x_after.data(), behind, outputs_.data()) ||
        !evaluator_.rates(at.t, at.x.data(), here, before.data()) ||
        !evaluator_.outputs(at.t, at.x.data(), here, outputs_before.data()) ||
        !evaluator_.take_partials(at.t, at.x.data(), here, Evaluator::Rows::sets))
      return fail_with_fault();
    for (Index k = 0; k < now_.states.cols(); ++k) {
      const AdjointFigure& figure = figures_[static_cast<std::size_t>(k)];
      double gain = -now_.states.col(k).dot(after);
      const double one = outputs_before[figure.output], other = outputs_[figure.output];
      if (figure.kind == AdjointFigure::Kind::integral) gain += one - other;
      if (figure.kind == AdjointFigure::Kind::square) gain += one * one - other * other;
      std::vector<double> weights(program_.event_values.results.size(), 0.0);
      for (auto set_by = at.sets.rbegin(); set_by != at.sets.rend(); ++set_by) {
        const ProgramEvent& what = program_.events[*set_by];
        for (std::size_t i = 0; i < what.sets.size(); ++i)
          weights[what.first_value + i] += std::exchange(now_.states(*what.sets[i].state, k), 0.0);
      }
      evaluator_.pull_back({}, weights, of(by_states), by_columns);
      now_.states.col(k) += by_states;
      now_.columns.col(k) += Eigen::Map<const VectorXd>(by_columns.data(), now_.columns.rows());
      by_instant_[k] += gain + now_.states.col(k).dot(before) + by_columns.back();
    }
    if (!now_.states.allFinite() || !now_.columns.allFinite())
      return fail_to(at.t, "have no value: what an event sets has no slope");
    grow(now_);
    return true;
  }

  /// What was set at an instant counts by that instant, which follows the states before all that happened at it.
  void move_instant() {
    if (instant_ == nullptr) return;
    const Index n = now_.states.rows();
    for (Index k = 0; k < now_.states.cols(); ++k) {
      now_.states.col(k) += by_instant_[k] * Eigen::Map<const VectorXd>(instant_->data(), n);
      now_.columns.col(k) += by_instant_[k] * Eigen::Map<const VectorXd>(instant_->data() + n, now_.columns.rows());
    }
    grow(now_);
    by_instant_.setZero();
    instant_ = nullptr;
  }

  double square_jump(double t, const std::vector<double>& x, const Branch& before, const Branch& after,
                     std::size_t output) {
    double sides[2] = {};
    for (const bool behind : {false, true}) {
      Branch branch = behind ? after : before;
      evaluator_.outputs(t, x.data(), branch, outputs_.data());
      sides[behind ? 1 : 0] = outputs_[output] * outputs_[output];
    }
    return sides[0] - sides[1];
  }

  [[nodiscard]] std::size_t columns() const { return program_.transposed.columns.size(); }

  /// What adjoints @p y grow by backward in time, at x.
  bool rates(double t, const std::vector<double>& x, const MatrixXd& y, bool with_outputs, Adjoints& rates) {
    if (with_outputs && !evaluator_.outputs(t, x.data(), branch_, outputs_.data())) return fail_with_fault();
    if (!evaluator_.take_partials(t, x.data(), branch_, Evaluator::Rows::outputs)) return fail_with_fault();
    rates.states.resize(y.rows(), y.cols());
    rates.columns.resize(static_cast<Index>(columns()), y.cols());
    std::vector<double> weights(outputs_.size(), 0.0), by_columns(columns() + 1);
    VectorXd by_states(y.rows());
    for (Index k = 0; k < y.cols(); ++k) {
      const AdjointFigure& figure = figures_[static_cast<std::size_t>(k)];
      double& weight = weights[figure.output];
      if (with_outputs && figure.kind == AdjointFigure::Kind::integral) weight = 1.0;
      if (with_outputs && figure.kind == AdjointFigure::Kind::square) weight = 2.0 * outputs_[figure.output];
      evaluator_.pull_back({y.col(k).data(), static_cast<std::size_t>(y.rows())}, weights, of(by_states), by_columns);
      weight = 0.0;
      rates.states.col(k) = by_states;
      rates.columns.col(k) = Eigen::Map<const VectorXd>(by_columns.data(), rates.columns.rows());
    }
    if (!rates.states.allFinite() || !rates.columns.allFinite()) return fail_to(t, "have no value: a law has no slope");
    return true;
  }

  bool jacobian(double t, const std::vector<double>& x, std::size_t stage) {
    return evaluator_.jacobian(t, x.data(), branch_, stages_.jacobian(stage).data()) || fail_with_fault();
  }

  /// From @p t back to @p to within one step of the run, with steps as the tolerance asks for.
  bool follow(const Trajectory::Step& step, double t, double to) {
    constexpr double kMost = 5.0, kLeast = 0.1, kSafe = 0.9, kRoundings = 64.0 * 2.3e-16;
    while (t > to) {
      const double left = t - to;
      const bool least = left <= kRoundings * std::max(std::abs(t), std::abs(to));
      double h = wanted_ > 0.0 && wanted_ < left && !least ? wanted_ : left;
      if (h < left && h > 0.5 * left) h = 0.5 * left;  // two equal ones
      double error = 0.0;
      if (!attempt(step, t, h == left ? to : t - h, error)) return false;
      ++result_.steps;
      reached_ = t;
      clock_.reach(t);
      if (clock_.end() != RunClock::End::none) return fail_by_clock();
      const double factor = std::clamp(kSafe * std::pow(std::max(error, 1e-30), -0.25), kLeast, kMost);
      if (error > 1.0 && !least) {
        wanted_ = factor * h;
        if (!(wanted_ > kRoundings * std::max(std::abs(t), std::abs(inputs_.stop - inputs_.start))))
          return fail_to(t, "cannot be followed to the tolerance");
        continue;
      }
      if (factor < 1.0 || h < left || wanted_ <= 0.0 || factor * h > wanted_) wanted_ = factor * h;
      t = h == left ? to : t - h;
      now_ = next_;
      grow(now_);
      std::swap(stages_.jacobian(AdjointStages::kBegin), stages_.jacobian(2));
      begin_ = stage_[2];
      begun_ = true;
    }
    return true;
  }

  /// One step from t to @p to, before it: next_, and its error in tolerances.
  bool attempt(const Trajectory::Step& step, double t, double to, double& error) {
    const auto& a = radau::kCoefficients;
    const Index n = now_.states.rows(), k = now_.states.cols();
    const double h = t - to;
    trajectory_.interpolate(step, t, x_);
    if (!begun_) {
      if (!jacobian(t, x_, AdjointStages::kBegin) || !rates(t, x_, now_.states, integrals_, begin_)) return false;
      begun_ = true;
    }
    std::array<double, 3> at{};
    std::array<MatrixXd, 3> forcing;
    for (std::size_t j = 0; j < 3; ++j) {
      at[j] = j == 2 ? to : t - radau::kAt[j] * h;
      trajectory_.interpolate(step, at[j], x_);
      if (!jacobian(at[j], x_, j)) return false;
      forcing[j] = stages_.times(j, now_.states);
      if (!integrals_) continue;
      if (!rates(at[j], x_, MatrixXd::Zero(n, k), true, scratch_)) return false;
      forcing[j] += scratch_.states;
    }
    MatrixXd moved(3 * n, k);
    for (std::size_t i = 0; i < 3; ++i)
      moved.middleRows(static_cast<Index>(i) * n, n) =
          h * (a[i][0] * forcing[0] + a[i][1] * forcing[1] + a[i][2] * forcing[2]);
    if (!stages_.solve(h, moved)) return fail_to(t, "have no solution");
    Adjoints off{h * begin_.states, h * begin_.columns};
    Adjoints size{largest_.states, largest_.columns};
    for (std::size_t j = 0; j < 3; ++j) {
      const MatrixXd increment = moved.middleRows(static_cast<Index>(j) * n, n);
      const MatrixXd value = now_.states + increment;
      trajectory_.interpolate(step, at[j], x_);
      if (!rates(at[j], x_, value, integrals_, stage_[j])) return false;
      off.states += radau::kError[j] * increment;
      size.states = size.states.cwiseMax(value.cwiseAbs());
      if (j == 2) next_.states = value;
    }
    next_.columns = now_.columns;
    for (std::size_t i = 0; i < 3; ++i) {
      const MatrixXd increment =
          h * (a[i][0] * stage_[0].columns + a[i][1] * stage_[1].columns + a[i][2] * stage_[2].columns);
      off.columns += radau::kError[i] * increment;
      size.columns = size.columns.cwiseMax(increment.cwiseAbs());
      if (i == 2) next_.columns += increment;
    }
    if (!stages_.filter(h, off.states)) return fail_to(t, "have no solution");
    // The error of the adjoints within the step, in the integrals.
    trajectory_.interpolate(step, t, x_);
    if (!rates(t, x_, off.states, false, scratch_)) return false;
    off.columns = (off.columns + h * scratch_.columns) / radau::kGamma;
    error = in_tolerances(off, size);
    return true;
  }

  /// The largest of all errors over their tolerances. What is below the tolerance of the largest adjoint, in units of
  /// the states and parameters, has to be known to that alone.
  [[nodiscard]] double in_tolerances(const Adjoints& off, const Adjoints& size) const {
    double error = 0.0;
    for (Index k = 0; k < off.states.cols(); ++k) {
      double most = 0.0;
      for (Index i = 0; i < off.states.rows(); ++i)
        most = std::max(most, size.states(i, k) * units_[static_cast<std::size_t>(i)]);
      const auto look = [&](const MatrixXd& errors, const MatrixXd& sizes, std::size_t first) {
        for (Index i = 0; i < errors.rows(); ++i) {
          if (errors(i, k) == 0.0) continue;
          const double least = inputs_.relative * most / units_[first + static_cast<std::size_t>(i)];
          error = std::max(error, std::abs(errors(i, k)) / (inputs_.relative * std::max(sizes(i, k), least)));
        }
      };
      look(off.states, size.states, 0);
      look(off.columns, size.columns, static_cast<std::size_t>(off.states.rows()));
    }
    return error;
  }

  /// What a column comes to by a seed, and the sum of the magnitudes that this is a sum of.
  struct Gathered {
    double sum = 0.0, terms = 0.0;
  };
  [[nodiscard]] Gathered gathered(std::size_t k, const AdjointSeed& seed) const {
    Gathered result;
    const auto add = [&](double term) {
      result.sum += term;
      result.terms += std::abs(term);
    };
    const auto column = static_cast<Index>(k);
    for (std::size_t i = 0; i < seed.states.size(); ++i)
      add(seed.states[i] * now_.states(static_cast<Index>(i), column));
    for (std::size_t i = 0; i < seed.columns.size(); ++i)
      add(seed.columns[i] * now_.columns(static_cast<Index>(i), column));
    return result;
  }

  void gather() {
    constexpr double kRoundings = 64.0 * 2.3e-16;
    for (std::size_t k = 0; k < asked_; ++k) {
      result_.gradient.emplace_back();
      result_.terms.emplace_back();
      for (const AdjointSeed& seed : seeds_) {
        const Gathered found = gathered(k, seed);
        result_.gradient.back().push_back(found.sum);
        result_.terms.back().push_back(found.terms);
      }
    }
    for (Side& side : sides_) {
      AdjointBeside beside;
      beside.values = std::move(side.values);
      for (const AdjointSeed& seed : seeds_) {
        const Gathered found = side.instant ? gathered(*side.instant, seed) : Gathered{1.0, 0.0};
        beside.moves.push_back(std::abs(found.sum) > kRoundings * found.terms);
      }
      for (const std::size_t column : side.figures) {
        beside.difference.emplace_back();
        for (const AdjointSeed& seed : seeds_) beside.difference.back().push_back(gathered(column, seed).sum);
      }
      result_.beside.push_back(std::move(beside));
    }
  }

  const Program& program_;
  const RunInputs& inputs_;
  const Trajectory& trajectory_;
  std::vector<AdjointFigure> figures_;  ///< those asked for, then further columns for sides_
  std::size_t asked_;
  const std::vector<AdjointSeed>& seeds_;
  Evaluator evaluator_;
  AdjointStages stages_;
  bool integrals_;
  VariationEvents events_;
  std::vector<std::optional<VariationEvents::Jump>> jumps_;   ///< by event
  std::vector<std::optional<std::vector<double>>> instants_;  ///< by event: t' of all at its instant; none: not known
  /// See add_side().
  struct Side {
    std::optional<std::size_t> instant;  ///< column; none: not known
    std::vector<std::size_t> figures;    ///< columns by figure; empty: not known
    std::vector<double> values;          ///< by figure
  };
  std::vector<Side> sides_;
  std::vector<double> units_;  ///< of states, then parameters
  AdjointResult result_;
  Adjoints now_, next_, largest_;
  VectorXd by_instant_;                           ///< by figure: what it grows by with the instant of what was set
  const std::vector<double>* instant_ = nullptr;  ///< t' of that
  Adjoints begin_;                                ///< rates at the step's beginning, if begun_
  bool begun_ = false;
  std::array<Adjoints, 3> stage_;
  Adjoints scratch_;
  std::vector<bool> pending_;  ///< by figure: its time is yet to come
  std::vector<double> x_, outputs_;
  Branch branch_;
  double wanted_ = 0.0;  ///< length of the next step; 0: not known
  SimulateOptions how_;
  RunClock clock_;
  double reached_ = 0.0;
};

}  // namespace

AdjointResult run_back(const Program& program, const RunInputs& inputs, const Trajectory& trajectory,
                       const std::vector<AdjointFigure>& figures, const std::vector<AdjointSeed>& seeds,
                       const SimulateOptions& how) {
  return Backward(program, inputs, trajectory, figures, seeds, how).run();
}

}  // namespace bgsim
