#include "bgsim/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/sweep.hpp"
#include "bgsim/text.hpp"
#include "fit/fit_runs.hpp"
#include "fit/fit_statistics.hpp"
#include "fit/solver.hpp"

namespace bgsim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// A fit has converged where the next step would move no value by more than this part of its standard error.
constexpr double kOffset = 0.01;

class Fitting {
 public:
  Fitting(const Study& study, const FitPlan& plan, const SceneOverrides& overrides, const SimulateOptions& how,
          unsigned threads)
      : study_(study), plan_(plan), runs_(study, plan, overrides, how, threads), start_(runs_.start()) {}

  FitResult run() {
    take_start();
    if (plan_.global_runs > 0) search();
    require_influence();
    const std::vector<double> values = plan_.starts > 0 ? descend_from_all() : descend();
    take_values(values);
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const char* code, std::string situation, std::string rule, std::string help) const {
    throw ModelError({diagnostic_of(code, std::move(situation), {}, std::move(rule), std::move(help))},
                     study_.model().sources);
  }

  /// The variables of the search are those values that are not held on a bound, over their scales.
  std::vector<double> values_of(const double* x, const std::vector<double>& from,
                                const std::vector<std::size_t>& free) const {
    std::vector<double> values = from;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const std::size_t j = free[k];
      const FitVariation& range = plan_.vary[j];
      // The very bounds, and the very start: a quotient and its product differ by roundings.
      if (x[k] != from[j] / runs_.scale(j)) values[j] = std::clamp(x[k] * runs_.scale(j), range.lower, range.upper);
    }
    return values;
  }

  int bound_at(std::size_t variation, double value) const {
    const FitVariation& range = plan_.vary[variation];
    const double near = 1e-9 * std::max(std::abs(value), runs_.scale(variation));
    return value - range.lower <= near ? -1 : range.upper - value <= near ? 1 : 0;
  }

  /// Local searches, each among the values that the one before leaves free: a value on its bound is held there as long
  /// as the sum of squares would fall beyond. Ceres alone stops short of the least sum where one is on its bound, since
  /// it cuts off steps instead of looking for the best of those that remain.
  std::vector<double> descend() {
    std::vector<double> values = start_;
    std::vector<char> held(values.size(), 0);
    const std::size_t most = 4 * values.size() + 4;
    std::optional<double> offset;
    for (std::size_t round = 0; round < most && result_.iterations < plan_.iterations; ++round) {
      std::vector<std::size_t> free;
      for (std::size_t j = 0; j < values.size(); ++j)
        if (held[j] == 0) free.push_back(j);
      bool ended = true;
      if (!free.empty()) {
        LeastSquares problem = local_problem(values, free);
        const LeastSquaresSolution solution = solve_least_squares(problem);
        result_.iterations += solution.iterations;
        result_.stopped = solution.stopped;
        ended = solution.converged;
        values = values_of(solution.x.data(), values, free);
      }
      const FitSlope slope = slope_at(values, held);
      offset = slope.found ? std::optional(slope.offset) : std::nullopt;
      std::vector<char> next(values.size(), 0);
      for (std::size_t j = 0; j < values.size() && slope.found; ++j) {
        const int bound = bound_at(j, values[j]);
        if (bound == 0 || slope.gradient[j] * bound > 0.0) continue;
        next[j] = 1;
        values[j] = bound < 0 ? plan_.vary[j].lower : plan_.vary[j].upper;
      }
      result_.converged = ended && slope.found && next == held && slope.offset <= kOffset;
      if (result_.converged || !slope.found) break;
      held = next;
    }
    if (result_.converged)
      result_.stopped = "converged";
    else if (result_.stopped == "converged")
      result_.stopped = "the derivatives at the last point say that the sum of squares falls further";
    if (!result_.converged && !runs_.last_fault().empty())
      result_.stopped += "; steps led to values whose runs fail, the last of them with " + runs_.last_fault();
    // Within a standard error the values are as good as their data: what is left to the least sum of squares is small
    // enough to be hidden by the errors of the runs.
    constexpr double kTight = 1e-9;
    if (!result_.converged && offset && *offset <= 1.0)
      result_.stopped +=
          ", " + number_text(*offset, 2) + " of a standard error from the least sum of squares, where " +
          number_text(kOffset) + " is enough" +
          (accuracy() > kTight ? "; if the errors of the runs hide the rest, a smaller tolerance helps: --relative " +
                                     number_text(kTight)
                               : std::string());
    return values;
  }

  /// From the start and from further ones: each part of each range is begun in once (a Latin hypercube). A start whose
  /// runs fail is left out.
  std::vector<double> descend_from_all() {
    SweepPlan plan;
    plan.sampling = Sampling::latin_hypercube;
    plan.samples = plan_.starts;
    for (const FitVariation& range : plan_.vary) {
      const bool decades = range.lower > 0.0 && range.upper > 100.0 * range.lower;
      plan.variations.push_back({range.name,
                                 {},
                                 decades ? Variation::Kind::log_uniform : Variation::Kind::uniform,
                                 {range.lower, range.upper}});
    }
    const SweepPoints points(std::move(plan));
    struct End {
      std::vector<double> values;
      double cost;
      bool converged;
      std::uint64_t iterations;
      std::string stopped;
    };
    std::vector<End> ends;
    std::uint64_t failed = 0, iterations = 0;
    for (std::uint64_t i = 0; i <= plan_.starts; ++i) {
      if (i > 0) start_ = points.at(i - 1);
      if (!std::isfinite(cost_at(start_))) {
        ++failed;
        continue;
      }
      result_.iterations = 0;
      const std::vector<double> values = descend();
      iterations += result_.iterations;
      ends.push_back({values, cost_at(values), result_.converged, result_.iterations, result_.stopped});
    }
    // Converged before not, then the least sum; at equal sums the first.
    const auto best = std::min_element(ends.begin(), ends.end(), [](const End& a, const End& b) {
      return a.converged != b.converged ? a.converged : a.cost < b.cost;
    });
    result_.starts = ends.size();
    result_.same = 0;
    double other = std::numeric_limits<double>::infinity();
    for (const End& end : ends) {
      bool same = end.converged == best->converged;
      // Ends of one minimum differ by what convergence leaves, a hundredth of a standard error: far below a thousandth
      // of the range.
      for (std::size_t j = 0; j < plan_.vary.size(); ++j)
        same = same && std::abs(end.values[j] - best->values[j]) <= 1e-3 * (plan_.vary[j].upper - plan_.vary[j].lower);
      result_.same += same ? 1U : 0U;
      if (!same && end.converged) other = std::min(other, end.cost);
    }
    if (failed > 0)
      runs_.notes.push_back(std::to_string(failed) + " of " + std::to_string(plan_.starts + 1) +
                            " starts are left out: their runs fail");
    if (std::isfinite(other))
      runs_.notes.push_back("other starts come to other values: the next sum of squares is " +
                            number_text(other / best->cost, 4) + " times as large");
    result_.iterations = iterations;
    result_.converged = best->converged;
    result_.stopped = best->stopped;
    return best->values;
  }

  /// The sum of squares near a point.
  struct FitSlope {
    bool found = false;
    std::vector<double> gradient;  ///< by value
    double offset = 0.0;           ///< see relative_offset()
  };

  FitSlope slope_at(const std::vector<double>& values, const std::vector<char>& held) {
    FitSlope slope;
    const std::vector<Trace> outputs = runs_.outputs(values);
    FitJacobian jacobian{runs_.residuals(), values.size(), {}, {}};
    if (outputs.empty()) return slope;
    jacobian.residuals = runs_.residuals_of(outputs);
    jacobian.derivatives.resize(jacobian.rows * jacobian.columns);
    slope.found = runs_.derivatives(values, jacobian.derivatives.data());
    if (!slope.found) return slope;
    // Below their own errors the outputs say nothing of the residuals.
    const double outputs_norm = norm_of_outputs(jacobian.residuals);
    root_of_loss(plan_.loss, plan_.loss_at, jacobian.rows, jacobian.columns, jacobian.residuals.data(),
                 jacobian.derivatives.data());
    slope.gradient.assign(values.size(), 0.0);
    for (std::size_t i = 0; i < jacobian.rows; ++i)
      for (std::size_t j = 0; j < values.size(); ++j)
        slope.gradient[j] += jacobian.residuals[i] * jacobian.derivatives[i * values.size() + j];
    slope.offset = relative_offset(jacobian, held, accuracy(), accuracy() * outputs_norm);
    return slope;
  }

  /// The outputs at the times of the data, weighted as the residuals are.
  double norm_of_outputs(const std::vector<double>& residuals) const {
    double square = 0.0;
    std::size_t row = 0;
    for (const FitScene& scene : runs_.scenes())
      for (const FitCell& cell : scene.cells) square += std::pow(residuals[row++] + cell.value * cell.weight, 2);
    return std::sqrt(square);
  }

  double accuracy() const {
    double relative = 1e-10;
    for (const FitScene& scene : runs_.scenes()) relative = std::max(relative, scene.simulation->inputs().relative);
    return relative;
  }

  void take_start() {
    std::optional<ModelError> why;
    first_ = runs_.outputs(start_, &why);
    if (first_.empty()) {
      if (why) throw ModelError(*why);
      refuse("BG420", "the outputs have no finite values at the start of the fit", {},
             "begin elsewhere: --set NAME=VALUE");
    }
    double sum = 0.0;
    for (const double r : runs_.residuals_of(first_)) sum += r * r;
    const double rms = std::sqrt(sum / static_cast<double>(runs_.residuals()));
    if (rms > 0.0) unit_ = rms;
  }

  /// A value whose derivatives are all 0 at the start, or what rounding makes of 0, cannot be moved by the others, nor
  /// by itself.
  void require_influence() {
    std::vector<double> rows(runs_.residuals() * start_.size());
    if (!runs_.derivatives(start_, rows.data()))
      refuse("BG420", "no derivative of the runs was found at the start of the fit",
             "a fit needs runs on one side, at least, of each value", "begin elsewhere: --set NAME=VALUE");
    constexpr double kRounding = 1e-12;  // of the outputs, if the value were another one altogether
    const double least = kRounding * norm_of_outputs(runs_.residuals_of(first_));
    for (std::size_t j = 0; j < start_.size(); ++j) {
      double square = 0.0;
      for (std::size_t i = 0; i < runs_.residuals(); ++i) square += std::pow(rows[i * start_.size() + j], 2);
      if (std::sqrt(square) * runs_.scale(j) > least) continue;
      std::vector<std::string> outputs;
      for (const FitMatch& match : plan_.matches) outputs.push_back(match.output);
      refuse(
          "BG419",
          in_quotes(plan_.vary[j].name) + " = " + number_text(start_[j]) + " has no influence on " +
              list_of(outputs, " or ", 6) + " at any time of the data",
          "a fit moves values by the changes that they make in the outputs",
          "leave it out, match an output that it changes, or begin elsewhere: --set " + plan_.vary[j].name + "=VALUE");
    }
  }

  LeastSquares local_problem(const std::vector<double>& from, const std::vector<std::size_t>& free) {
    LeastSquares problem;
    problem.residuals = runs_.residuals();
    for (const std::size_t j : free) {
      problem.start.push_back(from[j] / runs_.scale(j));
      problem.lower.push_back(plan_.vary[j].lower / runs_.scale(j));
      problem.upper.push_back(plan_.vary[j].upper / runs_.scale(j));
    }
    problem.loss = plan_.loss;
    problem.loss_at = plan_.loss_at / unit_;
    problem.iterations = plan_.iterations - result_.iterations;
    problem.evaluate = [this, from, free](const double* x, double* residuals, double* derivatives) {
      const std::vector<double> values = values_of(x, from, free);
      const std::vector<Trace> outputs = runs_.outputs(values);
      if (outputs.empty()) return false;
      const std::vector<double> found = runs_.residuals_of(outputs);
      for (std::size_t i = 0; i < found.size(); ++i) residuals[i] = found[i] / unit_;
      if (derivatives == nullptr) return true;
      const std::size_t n = values.size(), k = free.size();
      std::vector<double> all(found.size() * n);
      if (!runs_.derivatives(values, all.data(), free)) return false;
      for (std::size_t i = 0; i < found.size(); ++i)
        for (std::size_t c = 0; c < k; ++c)
          derivatives[i * k + c] = all[i * n + free[c]] * runs_.scale(free[c]) / unit_;
      return true;
    };
    return problem;
  }

  double cost(double r) const {
    r = std::abs(r);
    const double at = plan_.loss_at;
    if (plan_.loss == FitLoss::huber && r > at) return at * (2.0 * r - at);
    if (plan_.loss == FitLoss::cauchy) return at * at * std::log1p(r * r / (at * at));
    return r * r;
  }

  double cost_at(const std::vector<double>& values) {
    const std::vector<Trace> outputs = runs_.outputs(values);
    if (outputs.empty()) return std::numeric_limits<double>::infinity();
    double sum = 0.0;
    for (const double r : runs_.residuals_of(outputs)) sum += cost(r);
    return sum;
  }

  /// Ranges over decades are searched by the logarithm.
  void search() {
    const std::size_t n = start_.size();
    std::vector<char> decades(n);
    std::vector<double> lower(n), upper(n);
    for (std::size_t j = 0; j < n; ++j) {
      const FitVariation& range = plan_.vary[j];
      decades[j] = range.lower > 0.0 && range.upper > 100.0 * range.lower;
      lower[j] = decades[j] ? std::log(range.lower) : range.lower;
      upper[j] = decades[j] ? std::log(range.upper) : range.upper;
    }
    const auto values = [&](const std::vector<double>& point) {
      std::vector<double> at = point;
      for (std::size_t j = 0; j < n; ++j) {
        if (decades[j]) at[j] = std::exp(at[j]);
        at[j] = std::clamp(at[j], plan_.vary[j].lower, plan_.vary[j].upper);
      }
      return at;
    };
    const std::vector<double> found = search_everywhere(
        lower, upper, plan_.global_runs, [&](const std::vector<double>& point) { return cost_at(values(point)); });
    if (found.empty()) return;
    const std::vector<double> best = values(found);
    if (cost_at(best) < cost_at(start_)) start_ = best;
  }

  void take_values(const std::vector<double>& values) {
    const std::size_t n = values.size();
    const std::vector<Trace> outputs = runs_.outputs(values);
    FitJacobian jacobian;
    jacobian.rows = runs_.residuals();
    jacobian.columns = n;
    jacobian.derivatives.resize(jacobian.rows * n);
    jacobian.residuals = runs_.residuals_of(outputs);
    const bool derived = runs_.derivatives(values, jacobian.derivatives.data());
    std::vector<char> free(n, 1);
    std::vector<double> scales(n);
    result_.values.resize(n);
    for (std::size_t j = 0; j < n; ++j) {
      FittedValue& value = result_.values[j];
      const FitVariation& range = plan_.vary[j];
      value.name = range.name;
      value.unit = runs_.units()[j];
      value.start = runs_.start()[j];
      value.value = values[j];
      value.bound = bound_at(j, values[j]);
      free[j] = value.bound == 0;
      scales[j] = values[j] != 0.0 ? std::abs(values[j]) : 1.0;
    }
    result_.known_sigma = runs_.known_sigma();
    result_.residuals = jacobian.rows;
    if (derived) {
      const FitStatistics statistics = fit_statistics(plan_, jacobian, free, scales, accuracy(), runs_.known_sigma());
      result_.covariance = statistics.covariance;
      result_.correlation = statistics.correlation;
      result_.undetermined = statistics.undetermined;
      result_.deviation = statistics.deviation;
      for (std::size_t j = 0; j < n; ++j) {
        FittedValue& value = result_.values[j];
        value.error = statistics.errors[j];
        value.determined = statistics.determined[j] != 0;
        value.low = value.value - statistics.quantile * value.error;
        value.high = value.value + statistics.quantile * value.error;
      }
    } else {
      for (FittedValue& value : result_.values) value.error = value.low = value.high = kNone;
      result_.covariance.assign(n, std::vector<double>(n, kNone));
      result_.correlation = result_.covariance;
      runs_.notes.emplace_back("there are no standard errors: no derivative was found at the fitted values");
    }
    take_matches(outputs);
    result_.runs = runs_.runs();
    result_.notes = runs_.notes;
  }

  void take_matches(const std::vector<Trace>& outputs) {
    const Model& model = study_.model();
    for (std::size_t p = 0; p < runs_.pairs().size(); ++p) {
      const FitPair& pair = runs_.pairs()[p];
      const FitScene& scene = runs_.scenes()[pair.data];
      FittedMatch match;
      match.scene = scene.name;
      match.data = plan_.data[pair.data].name;
      match.output = plan_.matches[pair.match].output;
      match.column = plan_.matches[pair.match].column;
      match.unit = model.outputs[scene.simulation->inputs().outputs[pair.output]].unit;
      match.missing = pair.missing;
      double square = 0.0, start_square = 0.0;
      std::vector<double> data(scene.times.size(), kNone);
      for (const FitCell& cell : scene.cells) {
        if (cell.match != p) continue;
        ++match.rows;
        const double difference = outputs[pair.data].columns[pair.output][cell.row] - cell.value;
        const double before = first_[pair.data].columns[pair.output][cell.row] - cell.value;
        square += difference * difference;
        start_square += before * before;
        if (std::abs(difference) > match.largest) {
          match.largest = std::abs(difference);
          match.largest_at = scene.times[cell.row];
        }
        data[cell.row] = cell.value;
      }
      const double count = std::max(1.0, static_cast<double>(match.rows));
      match.rms = std::sqrt(square / count);
      match.start_rms = std::sqrt(start_square / count);
      if (pair.data == 0) {
        Trace& trace = result_.trace;
        trace.times = scene.times;
        trace.names.push_back(match.output);
        trace.columns.push_back(outputs[0].columns[pair.output]);
        trace.names.push_back("data(" + match.column + ")");
        trace.columns.push_back(std::move(data));
        trace.units.insert(trace.units.end(), 2, match.unit);
      }
      result_.matches.push_back(std::move(match));
    }
  }

  const Study& study_;
  const FitPlan& plan_;
  FitRuns runs_;
  std::vector<double> start_;  ///< of the local search
  std::vector<Trace> first_;   ///< the outputs at the start
  double unit_ = 1.0;          ///< of residuals: their root mean square at the start
  FitResult result_;
};

}  // namespace

FitResult fit(const Study& study, const FitPlan& plan, const SceneOverrides& overrides, const SimulateOptions& how,
              unsigned threads) {
  return Fitting(study, plan, overrides, how, threads).run();
}

}  // namespace bgsim
