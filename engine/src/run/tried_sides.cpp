#include "run/tried_sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/jump.hpp"
#include "run/watch/stiction.hpp"

namespace bgsim {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();
constexpr double kJumpRounding = 1e-9;  ///< of the energies that a jump's loss is the difference of
constexpr int kSmallTimes = 10;         ///< small times, each ten times the one before

/// One mode of the diodes, from the present instant on.
class Trial {
 public:
  Trial(const Program& program, const RunInputs& inputs, const Stored& stored, const std::vector<DiodeState>& before,
        const std::function<double(const StateInfo&)>& resolution, const std::vector<AtBorder>& at_border)
      : program_(program),
        inputs_(inputs),
        parameters_(parameters_of(program, inputs, at_border)),
        evaluator_(program, parameters_),
        at_border_(at_border),
        t_(stored.t),
        before_(before),
        values_(4 * before.size()),
        shifted_(4 * before.size()) {
    Jump jump = jump_into(evaluator_, t_, stored);
    possible_ = !jump.failure && jump.loss >= -kJumpRounding * jump.scale;
    loss_ = jump.loss > kJumpRounding * jump.scale ? jump.loss : 0.0;
    if (!possible_) return;
    x_ = std::move(jump.x);
    for (std::size_t i = 0; i < x_.size(); ++i)
      resolution_.push_back(std::max(resolution(program.states[i]), 4.0 * kUlp * std::abs(x_[i])));
  }

  /// For how many of the times (the instant itself and kSmallTimes more, the shortest first) all diodes keep within
  /// their borders.
  int lasts(const std::vector<bool>& conducts, double shortest) {
    if (!possible_ || !keeps(t_, x_, conducts)) return 0;
    double h = shortest;
    for (int k = 1; k <= kSmallTimes; ++k, h *= 10.0) {
      std::vector<double> x = x_, slope(x_.size());
      if (!rates(t_, x, slope)) return k;
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i] + 0.5 * h * slope[i];
      if (!rates(t_ + 0.5 * h, x, slope)) return k;
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i] + h * slope[i];
      if (!keeps(t_ + h, x, conducts)) return k;
    }
    return kSmallTimes + 1;
  }

  /// The sides with what their efforts and flows may be off by at the instant itself; after lasts() has found that
  /// they hold there.
  TriedSides sides(const std::vector<bool>& conducts) {
    TriedSides result{conducts, {}, {}};
    if (!diodes(t_, x_, values_)) return result;
    const std::vector<double> error = errors(t_, x_);
    for (std::size_t i = 0; i < conducts.size(); ++i) {
      result.effort_error.push_back(error[2 * i]);
      result.flow_error.push_back(error[2 * i + 1]);
    }
    return result;
  }

  /// Of energy, in the jump into the mode.
  [[nodiscard]] double loss() const { return loss_; }

 private:
  static std::vector<double> parameters_of(const Program& program, const RunInputs& inputs,
                                           const std::vector<AtBorder>& at_border) {
    std::vector<double> parameters = inputs.parameters;
    parameters.resize(program.model->parameters.size(), 0.0);
    put_shares(program, at_border, parameters);
    return parameters;
  }

  bool begin(double t, const std::vector<double>& x, Branch& branch) {
    if (!evaluator_.initialize_modes(t, x.data(), branch)) return false;
    hold_at_border(evaluator_, parameters_, inputs_, at_border_, t, x.data(), branch);
    return true;
  }
  bool rates(double t, const std::vector<double>& x, std::vector<double>& slope) {
    Branch branch = first_branch(program_);
    return begin(t, x, branch) && evaluator_.rates(t, x.data(), branch, slope.data());
  }
  bool diodes(double t, const std::vector<double>& x, std::vector<double>& values) {
    Branch branch = first_branch(program_);
    return begin(t, x, branch) && evaluator_.diodes(t, x.data(), branch, values.data());
  }

  bool keeps(double t, const std::vector<double>& x, const std::vector<bool>& conducts) {
    if (!diodes(t, x, values_)) return false;
    std::vector<double> error;  // as many evaluations as there are states: only where something is beyond its border
    for (std::size_t i = 0; i < conducts.size(); ++i) {
      const bool fires = values_[4 * i + 3] != 0.0;
      if (conducts[i] && !before_[i].conducts && !fires) return false;
      // One that has ended is on the conducting side without a flow either way. One with a flow is a diode: it does
      // not end because it is not fired.
      const bool off = !fires && (!before_[i].conducts || before_[i].pinned);
      const double flow = off ? std::abs(values_[4 * i + 1]) : -values_[4 * i + 1];
      const double beyond = conducts[i] ? flow : values_[4 * i] - values_[4 * i + 2];
      if ((!conducts[i] && off) || !(beyond > 0.0)) continue;
      if (error.empty()) error = errors(t, x);
      if (beyond > error[2 * i + (conducts[i] ? 1 : 0)]) return false;
    }
    return true;
  }

  /// Of each effort and flow: what it moves where states and time move by as much as they may be off.
  std::vector<double> errors(double t, std::vector<double> x) {
    constexpr double kSafety = 4.0;
    std::vector<double> result(values_.size() / 2, 0.0);
    const auto add = [&](double at) {
      if (!diodes(at, x, shifted_)) return;
      for (std::size_t i = 0; i < result.size(); ++i) {
        const std::size_t k = 4 * (i / 2) + i % 2;
        result[i] += kSafety * std::abs(shifted_[k] - values_[k]);
      }
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double value = x[i];
      x[i] = value + resolution_[i];
      add(t);
      x[i] = value;
    }
    add(t + 4.0 * kUlp * std::abs(t));
    return result;
  }

  const Program& program_;
  const RunInputs& inputs_;
  std::vector<double> parameters_;
  Evaluator evaluator_;
  const std::vector<AtBorder>& at_border_;
  double t_;
  const std::vector<DiodeState>& before_;
  std::vector<double> values_, shifted_, x_, resolution_;
  double loss_ = 0.0;
  bool possible_ = false;
};

/// By number of changes to the present sides, kMostModes at most.
/// @param free  by diode: may change
std::vector<std::vector<bool>> nearest_first(const std::vector<bool>& present, const std::vector<bool>& free) {
  constexpr std::size_t kMostModes = 256;
  std::vector<std::vector<bool>> result{present};
  std::vector<std::size_t> last{0};  // behind the last change, so that each comes up once
  for (std::size_t at = 0; at < result.size() && result.size() < kMostModes; ++at)
    for (std::size_t i = last[at]; i < present.size() && result.size() < kMostModes; ++i) {
      if (!free[i]) continue;
      result.push_back(result[at]);
      result.back()[i] = !present[i];
      last.push_back(i + 1);
    }
  return result;
}

}  // namespace

std::optional<TriedSides> tried_sides(const ProgramOfMode& program_of, const Mode& mode,
                                      const std::vector<bool>& is_diode, const std::vector<DiodeState>& before,
                                      const std::vector<bool>& free, const RunInputs& inputs, const Stored& stored,
                                      const std::function<double(const StateInfo&)>& resolution,
                                      const std::vector<AtBorder>& at_border) {
  std::vector<bool> present;
  for (const DiodeState& diode : before) present.push_back(diode.conducts);
  constexpr double kShortest = 1e-13;
  const double shortest = std::max(kShortest * (inputs.stop - stored.t), 64.0 * kUlp * std::abs(stored.t));
  std::optional<TriedSides> best;
  int longest = 0;
  double loss = 0.0;
  for (const std::vector<bool>& conducts : nearest_first(present, free)) {
    Mode tried = mode;
    std::size_t next = 0;
    for (std::size_t i = 0; i < tried.size(); ++i)
      if (is_diode[i]) tried[i] = conducts[next++];
    try {
      Trial trial(program_of(tried, {}), inputs, stored, before, resolution, at_border);
      const int lasts = trial.lasts(conducts, shortest);
      // A diode that blocks would take away the momentum of what it lets pass, and keep within its border afterwards.
      if (lasts < longest || (lasts == longest && !(trial.loss() < loss))) continue;
      longest = lasts;
      loss = trial.loss();
      best = trial.sides(conducts);
      if (longest > kSmallTimes && loss == 0.0) break;  // no other is better, and the nearer ones were before
    } catch (const ModelError&) {
      continue;  // the graph does not allow this mode
    }
  }
  // A mode that keeps within its borders at this instant alone, as the wrong sides of a flow of 0 do, leads nowhere.
  return longest > 1 ? best : std::nullopt;
}

}  // namespace bgsim
