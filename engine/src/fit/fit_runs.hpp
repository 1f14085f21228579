/// The runs of a fit: residuals and their derivatives at a point.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/fit.hpp"
#include "bgsim/sensitivity.hpp"

namespace bgsim {

/// A cell of the data that is compared.
struct FitCell {
  std::size_t match = 0;  ///< position among FitRuns::matches
  std::size_t row = 0;    ///< of the run: position among its times
  double value = 0.0;
  double weight = 1.0;  ///< 1/sigma, or the scale that stands in its place
};

/// A match in one of the data.
struct FitPair {
  std::size_t data = 0, match = 0;
  std::size_t output = 0;  ///< position in the trace
  std::size_t missing = 0;
};

/// One of the data with its scene, compiled.
struct FitScene {
  std::string name;
  std::vector<double> times;       ///< of the rows that are compared, increasing
  std::vector<std::size_t> pairs;  ///< positions in FitRuns::pairs
  std::vector<FitCell> cells;      ///< match: position in FitRuns::pairs
  std::shared_ptr<const Simulation> simulation;
  std::vector<std::shared_ptr<const SensitivityScene>> varied;  ///< by variation; null: differences
};

class FitRuns {
 public:
  /// @throws ModelError BG415 to BG419 for a plan that cannot be carried out.
  FitRuns(const Study& study, const FitPlan& plan, const SceneOverrides& overrides, const SimulateOptions& how,
          unsigned threads);

  [[nodiscard]] const std::vector<FitScene>& scenes() const { return scenes_; }
  [[nodiscard]] const std::vector<FitPair>& pairs() const { return pairs_; }
  [[nodiscard]] const std::vector<double>& start() const { return start_; }
  [[nodiscard]] const std::vector<std::string>& units() const { return units_; }
  [[nodiscard]] std::size_t residuals() const { return residuals_; }
  [[nodiscard]] bool known_sigma() const { return known_sigma_; }
  [[nodiscard]] std::uint64_t runs() const { return runs_; }
  /// Code and words of the last run that failed; empty if none did.
  [[nodiscard]] const std::string& last_fault() const { return last_fault_; }
  /// What a change of a value is measured in: its start, or its range where that is 0.
  [[nodiscard]] double scale(std::size_t variation) const { return scales_[variation]; }

  /// The outputs at the rows, by scene and output. Empty if a run fails there, which @p why then tells.
  /// @throws ModelError BG606
  std::vector<Trace> outputs(const std::vector<double>& values, std::optional<ModelError>* why = nullptr);
  /// Weighted output minus data, by scene and cell.
  [[nodiscard]] std::vector<double> residuals_of(const std::vector<Trace>& outputs) const;
  /// Their derivatives by the values, row by row. False if a run fails.
  /// @param only  positions of the values by which they are wanted; empty: all
  bool derivatives(const std::vector<double>& values, double* rows, const std::vector<std::size_t>& only = {});

  std::vector<std::string> notes;

 private:
  void check_variations(const SceneOverrides& overrides);
  void take_data(const SceneOverrides& overrides);
  void take_rows(const FitData& data, FitScene& scene, const RunInputs& inputs);
  void compile_scenes();
  [[nodiscard]] SceneOverrides with(const std::vector<double>& values) const;
  std::optional<Trace> run(const FitScene& scene, const std::vector<double>& values, std::optional<ModelError>* why);
  bool derive(const FitScene& scene, std::size_t first_row, std::size_t variation, const std::vector<double>& values,
              double* rows);
  bool differ(const FitScene& scene, std::size_t first_row, std::size_t variation, const std::vector<double>& values,
              double* rows);
  void note(const std::string& text);
  void work(std::size_t count, const std::function<void(std::size_t)>& task) const;
  [[noreturn]] void refuse(const char* code, std::string situation, std::string rule, std::string help,
                           std::optional<Place> place = {}) const;

  const Study& study_;
  const FitPlan& plan_;
  SceneOverrides overrides_;  ///< without what is varied
  SimulateOptions how_;
  unsigned threads_;
  std::vector<FitScene> scenes_;
  std::vector<FitPair> pairs_;
  std::vector<double> start_, scales_;
  std::vector<std::string> units_;
  std::size_t residuals_ = 0;
  bool known_sigma_ = false;
  std::atomic<std::uint64_t> runs_ = 0;
  std::vector<double> last_values_;  ///< of the traces in last_
  std::string last_fault_;
  std::vector<Trace> last_;
};

}  // namespace bgsim
