/// trade: what accuracy costs on one scene, measured: methods and their tolerances or steps against a reference.
#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

class Simulation;

/// How a scene is integrated: what the command line's flags say.
struct TradeSetting {
  Method method = Method::automatic;
  int max_order = 0;      ///< 0: the method's own
  double relative = 0.0;  ///< tolerance of error-controlled methods; 0 for steps of one length
  double step = 0.0;      ///< of methods with steps of one length; else 0
};
/// "--method bdf --max-order 2 --relative 1e-05".
std::string setting_flags(const TradeSetting& setting);
/// What a curve of the picture is called: "bdf", "bdf of order up to 2".
std::string curve_name(const TradeSetting& setting);

/// An output and whether its errors can be measured.
struct TradeOutput {
  std::string name, unit;
  double range = 0.0;    ///< largest less smallest value of the reference; of a constant output its magnitude
  std::string why_not;   ///< not judged, and why: its range is not above what rounding and solvers make of zero
  bool drowned = false;  ///< not judged since two tight runs differ by as much as it varies
  /// Not judged since the reference is too loose to tell it from zero: it may vary, and be wrong, by any amount.
  bool unresolved = false;
  double reference = 0.0;  ///< estimated error of the reference, relative to the range
  [[nodiscard]] bool judged() const { return why_not.empty(); }
};

/// What errors are measured against.
struct TradeReference {
  TradeSetting setting, second;  ///< the reference, and the method that it is estimated by
  double error = 0.0;            ///< largest difference of the two, relative to the outputs' ranges
  double cpu_seconds = 0.0;
  std::string unresolved;  ///< name of an output that the reference is too loose to tell from zero; empty: none
  /// Whether an accuracy can be stated at all.
  [[nodiscard]] bool tells(double accuracy, double margin) const {
    return unresolved.empty() && margin * error <= accuracy;
  }
};

enum class TradeVerdict { stable, unstable, failed, too_costly };
const char* verdict_text(TradeVerdict verdict);

/// Error of one output relative to its range.
struct ErrorOfOutput {
  double max = 0.0, rms = 0.0;
};

struct TradeRow {
  TradeSetting setting;
  TradeVerdict verdict = TradeVerdict::stable;
  std::string why;                    ///< of a verdict other than stable; or what limits the steps
  std::vector<ErrorOfOutput> errors;  ///< by Trade::outputs, zero for those that are not judged; empty: no whole run
  double max_error = 0.0, rms_error = 0.0;  ///< the worst of the outputs'
  double check_error = 0.0;  ///< largest error midway between output times, which took no part in picking
  std::uint64_t steps = 0, rates = 0, jacobians = 0, factorizations = 0;
  double cpu_seconds = 0.0;  ///< median of the repeated runs without audit; of a run that was cut: till then
  int repeats = 0;
  std::optional<double> energy_residual;  ///< EnergyAudit::relative
  bool pareto = false;                    ///< no setting is both cheaper and more exact
  [[nodiscard]] bool whole() const { return verdict == TradeVerdict::stable || verdict == TradeVerdict::unstable; }
};

struct Trade {
  std::string model, scene;
  std::vector<TradeOutput> outputs;
  TradeReference reference;
  double fastest_rate = 0.0;  ///< largest magnitude of the Jacobian's eigenvalues at the start; 0: not known
  std::vector<TradeRow> rows;
  std::vector<std::string> notes;
};

struct TradeOptions {
  double budget = 60.0;            ///< seconds of processor time for the whole, roughly: each run may take a part of it
  std::vector<TradeSetting> also;  ///< measure_trade: settings to be measured before the methods' own, at any cost
  std::function<void(const std::string& what)> tell;  ///< what comes next
  std::function<bool()> goes_on;                      ///< asked now and then; false ends the whole
  std::uint64_t max_steps = 0;                        ///< of each run; 0: no limit
  double time_limit = 0.0;                            ///< seconds of wall time for the whole; 0: no limit
};

/// Why there is no trade, or no pick: BG611.
struct TradeFailure : std::runtime_error {
  explicit TradeFailure(Diagnostic why)
      : std::runtime_error(why.code + ": " + why.situation), diagnostic(std::move(why)) {}
  Diagnostic diagnostic;
};

/// Runs the scene with every method over its tolerances or steps.
///
/// Where a run finds events (switches, diodes, contacts, latches, events of the model), their instants are an output
/// more, "event times", whose range is the scene's length. An output time between the instants of one event in two runs
/// says how far these are apart, not how wrong the outputs are: only the instants are judged there.
///
/// Errors are taken at the scene's output times and, apart from these, midway between them. The reference is the most
/// exact of several methods at 1e-11 or, where these differ by more than 1e-9, at 1e-13; its own error is how far the
/// one that comes nearest to it stays from it.
/// @throws TradeFailure BG611 no two methods come to the end of the scene within the budget, or the scene has no
///         states, outputs or extent in time.
Trade measure_trade(const Simulation& scene, const TradeOptions& options);
/// The same for the program of a model without switches.
/// @param program  compiled with the audit's energies and the scene's outputs.
Trade measure_trade(const Program& program, const RunInputs& inputs, const TradeOptions& options);

/// The cheapest row with an error of at most @p accuracy, midway between the output times too; none if there is none,
/// or the reference itself is not exact enough to tell.
std::optional<std::size_t> pick_row(const Trade& trade, double accuracy);

/// A setting found for an accuracy without measuring everything.
struct TradePick {
  TradeSetting setting;
  double accuracy = 0.0;
  double error = 0.0, check_error = 0.0;  ///< at the output times and midway between them
  double cpu_seconds = 0.0;
  TradeReference reference;
  std::size_t runs = 0;         ///< made to find it
  double search_seconds = 0.0;  ///< processor time of these
};

/// Finds a setting with an error of at most @p accuracy in the outputs: with one method (that of `auto`, then others if
/// its runs fail) from the tolerance that equals the accuracy to tighter ones, each run judged by one of a tenth of its
/// tolerance. A second method must then come to the same: TradeReference::second and ::error say which and how near;
/// that is more than the accuracy, up to 30 times, where it needs more than the allowed sixteen runs to come nearer.
/// Cost: some 3 to 20 runs of what is found (docs/performance.md), up to three times that where its runs agree too
/// early.
/// @throws TradeFailure BG611 there is nothing to measure, or no method comes to the end; BG612 the accuracy is not
///         reached, or no second method comes near.
TradePick find_setting(const Simulation& scene, double accuracy, const TradeOptions& options);
/// The same for the program of a model without switches.
TradePick find_setting(const Program& program, const RunInputs& inputs, double accuracy, const TradeOptions& options);

/// The inputs with a setting applied.
RunInputs with_setting(const RunInputs& inputs, const TradeSetting& setting);

/// The table: one record a row; errors of each output in columns of their own.
std::string trade_csv(const Trade& trade);
std::string trade_json(const Trade& trade);

}  // namespace bgsim
