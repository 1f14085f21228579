/// The programs of a model with switches, by mode.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "bgsim/modes.hpp"
#include "bgsim/program.hpp"
#include "run/diodes.hpp"
#include "run/switched.hpp"
#include "study/delayed_programs.hpp"

namespace bgsim {

/// Causality, equations and program of each mode, made when it is first asked for, and kept. From several threads.
class ModePrograms {
 public:
  /// Makes the program of a mode from its equations.
  using Compile = std::function<Program(const std::shared_ptr<const Model>&, const EquationSystem&, const BlockOrder&)>;

  /// @param of_mode  for the programs of modes; none: compile() with the options, as for all else
  ModePrograms(std::shared_ptr<const Model> model, CompileOptions options, Compile of_mode = {});

  /// @param settling  see ProgramOfMode
  /// @throws ModelError where the graph does not allow the mode, or its laws these parameters.
  const Program& at(const Mode& mode, const std::vector<double>& parameters, const Mode& settling = {});

  /// What the diodes see of the rest with the other switches as in @p mode.
  /// @throws ModelError where the graph does not allow it.
  const DiodeNetwork& network(const Mode& mode);

  /// For the jump of an impact into @p mode.
  /// @throws ModelError where the graph does not allow the mode.
  const ImpactProgram& impact(const Mode& mode);

  /// The mode of a scene's start, and what all stores hold there before any switch ties them to each other. Conditions
  /// are evaluated in a model in which a resistor stands for each switch, which every graph allows. A switch whose
  /// condition depends on efforts or flows that switches take part in is open at first; the run goes on from there.
  /// What delayed signals were before the start is found there, too, and put into the tables of @p own.
  /// @throws ModelError BG405.
  SwitchedStart start(const RunInputs& inputs, DelayedPrograms& own);
  SwitchedStart start(const RunInputs& inputs);

 private:
  struct Made {
    std::shared_ptr<const Model> model;
    BondGraph graph;
    CausalGraph causal;
    Program program;
    std::vector<bool> certain;  ///< by switch: its condition depends on no effort or flow that switches take part in
  };
  void begin_without_switches(const Made& without, const RunInputs& inputs, DelayedPrograms& own, SwitchedStart& start);
  void put_switches(const Made& without, const RunInputs& inputs, DelayedPrograms& own, SwitchedStart& start) const;
  void put_diodes(const RunInputs& inputs, DelayedPrograms& own, SwitchedStart& start);
  static std::unique_ptr<Made> make(const std::shared_ptr<const Model>& model, const Compile& compile);
  static Compile plain(CompileOptions options);

  /// The model of a mode's program.
  [[nodiscard]] Model in_mode(const Mode& mode) const;
  /// With those that the programs have more than the model: 0.
  [[nodiscard]] std::vector<double> completed(std::vector<double> parameters) const;

  std::shared_ptr<const Model> model_;
  CompileOptions options_;
  Compile of_mode_;
  std::mutex mutex_;
  std::map<std::pair<Mode, Mode>, std::unique_ptr<Made>> made_;  ///< by mode and settling contacts
  std::map<Mode, std::unique_ptr<DiodeNetwork>> networks_;       ///< with the diodes open in the key
  std::map<Mode, std::unique_ptr<ImpactProgram>> impacts_;
  std::unique_ptr<Made> without_switches_;
  bool looked_without_ = false;
};

}  // namespace bgsim
