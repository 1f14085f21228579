/// sweep: one scene many times with other values, and a few numbers of each run.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/study.hpp"

namespace bgsim {

/// A text that says what to vary, or what to keep, is not understood. What was asked for is quoted in the message.
class SweepError : public std::runtime_error {
 public:
  explicit SweepError(const std::string& message, std::string help_ = {})
      : std::runtime_error(message), help(std::move(help_)) {}
  std::string help;
};

/// A quantity that differs from run to run: a parameter, an initial value of a store, or one of the scene's settings.
struct Variation {
  enum class Kind {
    list,         ///< numbers: the values
    uniform,      ///< numbers: least and largest value
    log_uniform,  ///< the same; the logarithm is distributed evenly
    normal,       ///< mean, standard deviation
    log_normal,   ///< median, standard deviation of the natural logarithm
    triangular,   ///< least value, mode, largest value
  };
  std::string name;  ///< "k", "mass.p", or one of kSceneSettings
  std::string text;  ///< as it was written
  Kind kind = Kind::list;
  std::vector<double> numbers;
};

/// Settings of a scene that may be varied.
inline constexpr const char* kSceneSettings[] = {"scene.start", "scene.stop", "scene.relative", "scene.absolute",
                                                 "scene.step"};

/// "k=1,2,5", "k=1:5:9" (nine values from 1 to 5), "k=log(1:100:5)", "k=1:5", "k=log(1:100)", "k=normal(3,0.1)",
/// "k=lognormal(3,0.1)", "k=uniform(1,5)", "k=triangular(1,2,5)".
/// @throws SweepError
Variation parse_variation(const std::string& text);

enum class Sampling {
  grid,
  sobol,
  latin_hypercube,
  random,
  saltelli,  ///< for the variance that each quantity makes: indices.hpp
  morris,    ///< for elementary effects: indices.hpp
};

struct SweepPlan {
  std::vector<Variation> variations;
  Sampling sampling = Sampling::grid;
  /// Number of runs; of a grid it follows from the values. With k quantities saltelli makes k + 2 runs for each of
  /// these, morris k + 1.
  std::uint64_t samples = 0;
  std::uint64_t seed = 1;
};

/// "sobol:1000", "lhs:200", "random:500", "saltelli:1024", "morris:20" into @p plan.
/// @throws SweepError
void parse_sampling(const std::string& text, SweepPlan& plan);

/// The values of all runs of a plan. Those of a run depend on its number and the plan alone, so runs may be made in any
/// order and anywhere.
///
/// Grid: all combinations, the last quantity fastest. Latin hypercube: each quantity has one value in each of N equally
/// probable parts (McKay, Beckman, Conover, Technometrics 21, 1979). Sobol's sequence with the direction numbers of Joe
/// and Kuo (SIAM J. Sci. Comput. 30, 2008), as in Boost.Random, shifted digit by digit by the seed (both from memory).
/// Saltelli: for each point of Sobol's sequence in twice as many dimensions, the first half (A), the second (B), and
/// for each quantity A with that quantity of B. Morris: paths on a grid of four levels, at shares 1/8, 3/8, 5/8, 7/8 of
/// each distribution, along which each quantity moves once, in random order, by half of the distribution.
class SweepPoints {
 public:
  /// @throws SweepError  a range without a number of values in a grid, a name twice, nothing to vary, too many runs.
  explicit SweepPoints(SweepPlan plan);
  ~SweepPoints();
  SweepPoints(const SweepPoints&) = delete;
  SweepPoints& operator=(const SweepPoints&) = delete;

  [[nodiscard]] const SweepPlan& plan() const;
  [[nodiscard]] std::uint64_t size() const;
  /// The values of run @p index, by variation. @pre index < size()
  [[nodiscard]] std::vector<double> at(std::uint64_t index) const;

  /// Of Morris' paths: which quantity differs between run @p index and the next, and by which share of its
  /// distribution.
  struct Move {
    std::size_t variation;
    double share;
  };
  /// @pre index % (k + 1) < k
  [[nodiscard]] Move move_after(std::uint64_t index) const;

 private:
  struct Inside;
  std::unique_ptr<const Inside> inside_;
};

/// What is kept of a run: expressions over functions of time, "max(x) - final(x)".
///
/// initial(x) final(x) min(x) max(x) mean(x) rms(x) integral(x) time_of_min(x) time_of_max(x), of an output or any
/// expression over the model's names; first(condition): when it first holds (no value if never); duration(condition):
/// how long it holds in all. Parameters have the values of the run.
class SweepResults {
 public:
  /// @param wanted  name and expression of each; none: final, min, max, mean and rms of all outputs of the scene.
  /// @param scene  empty for the first.
  /// @throws SweepError  with the text and what is wrong in it.
  SweepResults(const Model& model, const std::string& scene,
               const std::vector<std::pair<std::string, std::string>>& wanted);
  ~SweepResults();
  SweepResults(const SweepResults&) = delete;
  SweepResults& operator=(const SweepResults&) = delete;

  [[nodiscard]] const std::vector<std::string>& names() const;
  /// The outputs that runs must record for this, in addition to the model's: name and expression.
  [[nodiscard]] const std::vector<std::pair<std::string, std::string>>& further_outputs() const;
  /// All outputs that they must record.
  [[nodiscard]] const std::vector<std::string>& outputs() const;
  /// The results of a run with SimulateOptions::measures; NaN where one has no value. One that is no finite number,
  /// though all that it is made of has a value, is named in @p notes.
  /// @pre the run is completed
  [[nodiscard]] std::vector<double> of(const RunResult& run, const RunInputs& inputs,
                                       std::vector<std::string>& notes) const;

 private:
  struct Inside;
  std::unique_ptr<const Inside> inside_;
};

/// One run of a sweep.
struct SweepRun {
  std::uint64_t index = 0;
  std::vector<double> values;   ///< by variation
  std::vector<double> results;  ///< by SweepResults::names(); empty if it failed
  bool completed = false;
  std::string message;             ///< why it failed: code and situation
  std::vector<std::string> notes;  ///< what the run's report notes
};

struct SweepOptions {
  unsigned threads = 1;
  SimulateOptions how;  ///< of each run; rows, progress and remarks are not used
  /// Which runs to make: next number, or none when there are no more. Called by one thread at a time.
  std::function<std::optional<std::uint64_t>()> next;
  /// Takes runs as they are done, in no order; called by one thread at a time.
  std::function<void(const SweepRun&, const RunResult&)> done;
  std::function<bool()> goes_on;  ///< false ends the sweep; runs that are not done are dropped
};

/// Runs @p scene, the compiled scene @p name of its model with @p overrides, for those points that SweepOptions::next
/// names. A run whose values the model refuses, or that fails, is reported as such, and the others go on.
///
/// Each worker takes as many runs as it makes in some 0.2 s. The results of a run do not depend on the number of
/// workers, nor on what was run before.
/// @throws what SweepOptions::done throws.
void sweep(const Simulation& scene, const std::string& name, const SceneOverrides& overrides, const SweepPoints& points,
           const SweepResults& results, const SweepOptions& options);

}  // namespace bgsim
