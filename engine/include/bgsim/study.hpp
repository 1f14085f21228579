/// The way in: a model with all its stages, and scenes of it that are compiled once and run as often as wanted.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bgsim/linear.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/simulate.hpp"
#include "bgsim/slice.hpp"

namespace bgsim {

/// Wall time by stage, in the order in which they ran.
using StageSeconds = std::vector<std::pair<std::string, double>>;

class ModePrograms;
class Simulation;
struct ObservedPart;

/// What of a scene is compiled.
struct SceneOptions {
  bool energy_audit = true;
  bool keep_all = false;  ///< also what no output depends on
};

/// A model and the values of all stages (docs/pipeline.md). A stage runs when its value is first asked for, and once.
/// Copies share the values. All functions may be called from several threads.
class Study {
 public:
  /// Reads a model file, and the files that it names.
  /// @throws ModelError as read_model.
  explicit Study(const std::string& path, const ReadOptions& options = {});
  explicit Study(std::shared_ptr<const Model> model);
  /// Reads a model from @p text, as if it were the file @p path.
  /// @throws ModelError as read_model_text.
  static Study from_text(const std::string& text, const std::string& path = "model.json");

  [[nodiscard]] const Model& model() const;
  [[nodiscard]] const std::shared_ptr<const Model>& shared_model() const;
  /// @throws ModelError as build_bond_graph.
  [[nodiscard]] const BondGraph& graph() const;
  /// @throws ModelError as the stages up to assign_causality; so for the next ones.
  [[nodiscard]] const CausalGraph& causality() const;
  [[nodiscard]] const EquationSystem& equations() const;
  [[nodiscard]] const BlockOrder& order() const;

  /// Works out a scene, leaves out what its outputs do not depend on, and compiles the rest.
  /// @param name  empty for the first scene.
  /// @throws ModelError as prepare_scene, check_start and all stages.
  [[nodiscard]] Simulation scene(const std::string& name = "", const SceneOverrides& overrides = {},
                                 const SceneOptions& options = {}) const;
  /// The same for a scene that is worked out already.
  [[nodiscard]] Simulation scene(RunInputs inputs, const SceneOptions& options = {}) const;

  /// Linearized at a point, in the mode of the switches that the model is in (at_start() gives that of a scene's
  /// start); see linear_system().
  /// @throws ModelError as linear_system.
  [[nodiscard]] LinearSystem linearized(const RunInputs& point, const std::vector<std::string>& inputs = {}) const {
    return linear_system(shared_model(), point, inputs);
  }

  /// The same model in another mode of its switches.
  [[nodiscard]] Study in_mode(const Mode& closed) const;
  /// In the mode in which a scene begins; itself if the model has no switches or no scenes.
  /// @param name  empty for the first scene.
  /// @throws ModelError as prepare_scene, and BG405.
  [[nodiscard]] Study at_start(const std::string& name = "", const SceneOverrides& overrides = {}) const;
  /// The same of a scene that is worked out already.
  [[nodiscard]] Study at_start(const RunInputs& inputs) const;

  /// Of the stages that have run so far.
  [[nodiscard]] StageSeconds seconds() const;

 private:
  friend class Simulation;
  struct Stages;
  std::shared_ptr<Stages> stages_;
};

/// A scene, ready to run. Nothing changes it: one may be run from several threads at once.
class Simulation {
 public:
  [[nodiscard]] const Model& model() const { return study_.model(); }
  [[nodiscard]] const RunInputs& inputs() const { return inputs_; }
  /// Of a model with switches: that of the mode in which the scene begins.
  [[nodiscard]] const Program& program() const {
    return compiled_->first != nullptr ? *compiled_->first : compiled_->program;
  }
  /// Of slice and compile.
  [[nodiscard]] const StageSeconds& seconds() const { return compiled_->seconds; }

  /// The same scene with another value of a parameter ("R") or of an initial value ("mass.p"), in the unit that the
  /// model gives it. Parameters that are computed from it follow. Nothing is compiled again.
  /// @throws ModelError as prepare_scene for a --set: BG141 no such name, BG142, BG145 and so on; BG405.
  ///         std::logic_error if the scene was not asked for by its name: what else its inputs hold would be lost.
  /// @note Time linear in the model.
  [[nodiscard]] Simulation with(std::string_view name, double value) const;
  /// Runs; see bgsim::simulate(). Where no estimate of the outputs' errors can follow the run (switches, diodes,
  /// contacts, events, delays), a run of up to ten seconds is made a second time for it, at a tenth of the tolerance.
  [[nodiscard]] RunResult simulate(const SimulateOptions& options = {}) const;
  /// Runs with other times, tolerances or method.
  /// @throws std::invalid_argument if @p inputs ask for other outputs than those compiled; ModelError BG405.
  [[nodiscard]] RunResult simulate(const RunInputs& inputs, const SimulateOptions& options = {}) const;

 private:
  friend class Study;
  struct Compiled {
    std::shared_ptr<const ObservedPart> part;  ///< of a model with switches, events or delays; null: all of it
    std::optional<Study> part_study;           ///< of `part`
    std::optional<Slice> cut;                  ///< none if nothing was left out
    Program program;
    std::shared_ptr<ModePrograms> modes;  ///< of a model with switches, instead of `program`
    const Program* first = nullptr;       ///< among these
    StageSeconds seconds;
  };
  Simulation(Study study, RunInputs inputs, const SceneOptions& options);
  [[nodiscard]] const Study& compiled_study() const { return compiled_->part_study ? *compiled_->part_study : study_; }
  [[nodiscard]] RunInputs compiled_inputs(const RunInputs& inputs) const;
  void check(const RunInputs& inputs) const;
  [[nodiscard]] RunResult run(const RunInputs& inputs, const SimulateOptions& options) const;
  [[nodiscard]] RunResult run_once(const RunInputs& of_whole, const SimulateOptions& options) const;
  [[nodiscard]] RunResult run_compiled(const RunInputs& inputs, const SimulateOptions& options) const;

  Study study_;
  std::optional<SceneOverrides> overrides_;  ///< as the scene was asked for; none if it was worked out elsewhere
  RunInputs inputs_;
  std::shared_ptr<const Compiled> compiled_;
};

/// Equilibria of a model, in any mode of its switches.
struct SteadyStates {
  std::vector<Equilibrium> found;  ///< each in a mode whose sides it does not leave
  std::size_t looked_at = 1;       ///< modes
  std::size_t switches = 0;        ///< 2 to the power of that many modes are there
};
/// Equilibria near a scene. Of a model with switches, diodes or contacts in the mode of the scene's start, in those
/// that equilibria of other modes lead to, in the one in which a run comes to rest that holds its sources, and, of up
/// to six switches, in all others.
/// @throws ModelError as equilibria(); BG412 each equilibrium that was found leaves its mode.
SteadyStates steady_states(const Study& study, const RunInputs& scene, const SteadyOptions& options = {});

}  // namespace bgsim
