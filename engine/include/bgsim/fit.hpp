/// fit: parameters and initial values for which the runs of scenes come nearest to measured data.
///
/// Of the library bgsim::fit, which is built where Ceres and NLopt are installed (docs/fit.md).
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/csv.hpp"
#include "bgsim/study.hpp"

namespace bgsim {

/// A parameter, or an initial value ("mass.p"), that is to be found, and its range.
struct FitVariation {
  std::string name;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// An output, and the column of the data that it is to follow.
struct FitMatch {
  std::string output;
  std::string column;
  double sigma = 0.0;             ///< standard deviation of the measurement, in the output's unit; 0: not known
  std::string sigma_column = {};  ///< of the data, with the standard deviation of each row; empty: sigma for all
  [[nodiscard]] bool has_sigma() const { return sigma > 0.0 || !sigma_column.empty(); }
};

/// What was measured in one scene.
struct FitData {
  std::string scene;  ///< empty for the first
  std::string name;   ///< of the file, for messages
  CsvCells cells;
};

/// What a residual r, in standard deviations, costs: r^2 where it is small. The others let outliers pull less.
enum class FitLoss {
  squares,
  huber,   ///< r^2, and beyond D 2 D |r| - D^2
  cauchy,  ///< D^2 log(1 + r^2/D^2)
};

struct FitPlan {
  std::vector<FitVariation> vary;
  std::vector<FitMatch> matches;
  std::vector<FitData> data;
  std::string time;  ///< the column of times; empty: "t", or else the first
  FitLoss loss = FitLoss::squares;
  double loss_at = 0.0;            ///< D of the loss, in standard deviations
  std::uint64_t global_runs = 0;   ///< points that are tried all over the ranges before; 0: the start alone
  std::uint64_t iterations = 100;  ///< at most, from each start
  std::uint64_t starts = 0;        ///< further starts, all over the ranges (a Latin hypercube); the best end is taken
};

/// "k=300:400", "m" into a variation.
/// @throws ModelError BG416 a range that is empty, reversed or no range.
FitVariation parse_fit_variation(const std::string& text);

/// A table of measurements in which cells may be missing.
/// @throws ModelError BG417 with the file and line.
FitData fit_data(const std::string& scene, const std::string& name, std::string_view text);

struct FittedValue {
  std::string name, unit;
  double start = 0.0, value = 0.0;
  double error = 0.0;            ///< standard error; NaN if the data do not determine it, or it sits on its bound
  double low = 0.0, high = 0.0;  ///< 95 % confidence (Student's t); NaN likewise
  int bound = 0;                 ///< -1 or 1: it sits on its lower or upper bound
  bool determined = true;        ///< false: the data do not tell it apart from others
};

struct FittedMatch {
  std::string scene, data, output, column, unit;
  std::size_t rows = 0;     ///< compared
  std::size_t missing = 0;  ///< cells without a value
  double rms = 0.0;         ///< of output minus data, in the output's unit
  double start_rms = 0.0;   ///< the same at the start
  double largest = 0.0;     ///< magnitude of the largest difference
  double largest_at = 0.0;  ///< its time
};

/// Values that can be changed together without a change of the runs, to first order.
struct FitDirection {
  std::vector<std::string> names;
  std::vector<double> shares;  ///< relative changes (absolute ones of a value of 0), the largest 1
};

struct FitResult {
  std::vector<FittedValue> values;
  std::vector<FittedMatch> matches;
  std::vector<std::vector<double>> covariance, correlation;  ///< by value; NaN where there is none
  std::vector<FitDirection> undetermined;
  double deviation = 0.0;  ///< root of the sum of squared residuals (in sigmas, where known) over degrees of freedom
  std::uint64_t residuals = 0, iterations = 0, runs = 0;
  bool converged = false;
  std::uint64_t starts = 1, same = 1;  ///< how many local searches, and how many of them came to these values
  bool known_sigma = false;            ///< of all matches: standard errors are from these and not from the residuals
  std::string stopped;                 ///< why the search ended, in words
  std::vector<std::string> notes;      ///< differences in place of derivatives, rows that were not used, ...
  Trace trace;                         ///< of the first data: t, then output and data of each match (NaN: missing)
};

/// Fits. Levenberg-Marquardt within bounds (Ceres) on the derivatives of the runs: exact ones by the variational
/// equations, or central differences where the model has none (BG414), which a note says. With FitPlan::global_runs
/// after a search all over the ranges (DIRECT, NLopt). The result depends on neither @p threads nor the time.
///
/// Residuals are divided by sigma. Without sigma, all matches but a single one are divided by the standard deviation of
/// their data, which makes them comparable; standard errors then take the scale from the residuals.
/// @param how  of each run; rows, progress, measures and audits are not used but for progress.
/// @throws ModelError BG413, BG415 to BG420; the failure of the run at the start; BG606 when interrupted.
/// @note Each iteration makes one run, and one of twice the size for each value that is varied, for each scene.
FitResult fit(const Study& study, const FitPlan& plan, const SceneOverrides& overrides = {},
              const SimulateOptions& how = {}, unsigned threads = 1);

/// The text of the model's file with the fitted values (and those of @p overrides) in place of its own, all else byte
/// for byte as it was. A value that stands elsewhere, as in a submodel's file, is written into the scenes of the fit.
/// @param reading  with which the model was read
/// @param path  of the file that it is for, from whose folder the model names others; empty: the model's own
/// @throws ModelError BG421 if the text cannot be written so that it gives the same values.
std::string fitted_text(const Study& study, const FitPlan& plan, const FitResult& result,
                        const SceneOverrides& overrides = {}, const ReadOptions& reading = {},
                        const std::string& path = {});

}  // namespace bgsim
