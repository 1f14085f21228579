#include "bgsim/study.hpp"

#include <mutex>
#include <optional>
#include <stdexcept>

#include "base/codes.hpp"
#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "equations/idle_switches.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"
#include "run/clock.hpp"
#include "run/integrate/integrator.hpp"
#include "run/snapshot.hpp"
#include "study/mode_programs.hpp"
#include "study/observed_part.hpp"
#include "study/second_run.hpp"

namespace bgsim {

/// A value that is made when it is first asked for. Others wait; where it cannot be made, each one gets the error.
template <class Value>
class Lazy {
 public:
  template <class Make>
  const Value& get(const Make& make) {
    const std::scoped_lock lock(mutex_);
    if (!value_) value_.emplace(make());
    return *value_;
  }

 private:
  std::mutex mutex_;
  std::optional<Value> value_;
};

namespace {

/// Calls @p work and appends its wall time.
template <class Work>
auto timed(StageSeconds& seconds, const char* stage, const Work& work) {
  double took = 0.0;
  auto value = [&] {
    const Stopwatch watch(took);
    return work();
  }();
  seconds.emplace_back(stage, took);
  return value;
}

/// By id of a part, the id in the whole. @param ids  the other way round; invalid: not in the part
template <class Id>
std::vector<Id> in_the_whole(const std::vector<Id>& ids) {
  std::vector<Id> result;  // parts keep the order
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i].valid()) result.emplace_back(i);
  return result;
}

}  // namespace

struct Study::Stages {
  std::shared_ptr<const Model> model;
  Lazy<BondGraph> graph;
  Lazy<CausalGraph> causality;
  Lazy<EquationSystem> equations;
  Lazy<BlockOrder> order;
  std::mutex mutex;  ///< of `seconds`
  StageSeconds seconds;

  template <class Value, class Make>
  const Value& stage(Lazy<Value>& value, const char* name, const Make& make) {
    return value.get([&] {
      StageSeconds own;
      Value made = timed(own, name, make);
      const std::scoped_lock lock(mutex);
      seconds.push_back(std::move(own.front()));
      return made;
    });
  }
};

Study::Study(std::shared_ptr<const Model> model) : stages_(std::make_shared<Stages>()) {
  stages_->model = std::move(model);
}

Study::Study(const std::string& path, const ReadOptions& options) : stages_(std::make_shared<Stages>()) {
  stages_->model =
      timed(stages_->seconds, "read", [&] { return std::make_shared<const Model>(read_model(path, options)); });
}

Study Study::from_text(const std::string& text, const std::string& path) {
  return Study(std::make_shared<const Model>(read_model_text(path, text)));
}

const Model& Study::model() const { return *stages_->model; }
const std::shared_ptr<const Model>& Study::shared_model() const { return stages_->model; }

const BondGraph& Study::graph() const {
  return stages_->stage(stages_->graph, "graph", [&] { return build_bond_graph(model()); });
}

const CausalGraph& Study::causality() const {
  const BondGraph& before = graph();
  return stages_->stage(stages_->causality, "causality", [&] { return solvable_causality(model(), before); });
}

const EquationSystem& Study::equations() const {
  const CausalGraph& before = causality();
  return stages_->stage(stages_->equations, "equations", [&] { return derive_equations(model(), graph(), before); });
}

const BlockOrder& Study::order() const {
  const EquationSystem& before = equations();
  return stages_->stage(stages_->order, "order", [&] { return order_equations(model(), before); });
}

StageSeconds Study::seconds() const {
  const std::scoped_lock lock(stages_->mutex);
  return stages_->seconds;
}

Simulation Study::scene(const std::string& name, const SceneOverrides& overrides, const SceneOptions& options) const {
  Simulation result = scene(prepare_scene(model(), name, overrides), options);
  result.overrides_ = overrides;
  return result;
}

Simulation Study::scene(RunInputs inputs, const SceneOptions& options) const {
  return {*this, std::move(inputs), options};
}

Simulation::Simulation(Study study, RunInputs inputs, const SceneOptions& options)
    : study_(std::move(study)), inputs_(std::move(inputs)) {
  const auto compiled = std::make_shared<Compiled>();
  compiled_ = compiled;
  if (!options.keep_all && !inputs_.outputs.empty() && !equations_stay(model())) {
    // What is left out is checked as far as it is the same in all modes.
    if (switches_of(model()).empty())
      static_cast<void>(study_.order());
    else
      static_cast<void>(study_.graph());
    auto part = timed(compiled->seconds, "slice", [&] { return observed_part(model(), inputs_.outputs); });
    if (part) {
      compiled->part_study.emplace(part->model);
      compiled->part = std::make_shared<const ObservedPart>(std::move(*part));
    }
  }
  const Study& of = compiled_study();
  const RunInputs own = compiled_inputs(inputs_);
  if (!switches_of(of.model()).empty()) {
    compiled->modes =
        std::make_shared<ModePrograms>(of.shared_model(), CompileOptions{own.outputs, options.energy_audit});
    compiled->first = timed(compiled->seconds, "compile", [&] {
      const SwitchedStart start = compiled->modes->start(own);
      if (start.failure) throw ModelError({*start.failure}, model().sources);
      return &compiled->modes->at(start.mode, own.parameters);
    });
    return;
  }
  const EquationSystem& system = of.equations();
  const BlockOrder& order = of.order();
  if (!options.keep_all && equations_stay(of.model()))
    compiled->cut = timed(compiled->seconds, "slice", [&] {
      return slice(of.model(), of.graph(), system, order, own.outputs, options.energy_audit);
    });
  check(inputs_);
  const std::optional<Slice>& cut = compiled->cut;
  compiled->program = timed(compiled->seconds, "compile", [&] {
    return compile(of.shared_model(), cut ? cut->system : system, cut ? cut->order : order,
                   {own.outputs, options.energy_audit});
  });
}

/// As a run of what is compiled takes them.
RunInputs Simulation::compiled_inputs(const RunInputs& inputs) const {
  return compiled_->part ? inputs_of_part(inputs, *compiled_->part) : inputs;
}

/// Laws that hold for some parameters only; initial values of what is left out: the run does not see them.
void Simulation::check(const RunInputs& inputs) const {
  if (compiled_->modes) return;  // each mode is looked at when the run comes to it
  const Study& of = compiled_study();
  check_laws(of.model(), of.graph(), of.causality(), inputs.parameters);
  if (compiled_->cut)
    check_start(of.shared_model(), of.equations(), of.order(), *compiled_->cut, compiled_inputs(inputs));
}

Simulation Simulation::with(std::string_view name, double value) const {
  if (!overrides_) throw std::logic_error("a scene that was not asked for by its name takes no other values");
  const std::string target = std::string(name) + '=';
  Simulation result = *this;
  std::vector<std::string>& set = result.overrides_->set;
  std::erase_if(set, [&](const std::string& before) { return before.starts_with(target); });
  set.push_back(target + shortest_number(value));
  result.inputs_ = prepare_scene(model(), inputs_.scene, *result.overrides_);
  check(result.inputs_);
  return result;
}

RunResult Simulation::simulate(const SimulateOptions& options) const { return run(inputs_, options); }

RunResult Simulation::simulate(const RunInputs& inputs, const SimulateOptions& options) const {
  if (inputs.outputs != inputs_.outputs)
    throw std::invalid_argument("the inputs ask for other outputs than those compiled");
  check(inputs);
  return run(inputs, options);
}

RunResult Simulation::run(const RunInputs& inputs, const SimulateOptions& options) const {
  // What a run of many states is wrong by is not followed along it: that would be most of its time. Where it is short,
  // a second one tells.
  constexpr double kShort = 1e6;  // of steps times states, and of numbers that are kept
  const std::size_t states = program().state_names.size();
  const bool followed = !compiled_->modes && program().events.empty() && program().delays.empty();
  const bool carried = followed && states <= kDenseStates && program().plan.explicit_form;
  if (!options.error_estimate || !options.second_run) return run_once(inputs, options);
  if (followed && SecondRun::values_kept(inputs) > kShort) return run_once(inputs, options);
  SecondRun second(inputs, options, !followed);
  const double begin = wall_seconds();
  RunResult result = run_once(inputs, second.options());
  const std::vector<double>& estimates = result.report.errors.estimate;
  bool exceeds = !carried;
  for (std::size_t c = 0; c < estimates.size(); ++c)
    exceeds = exceeds || exceeds_range(result.report.errors, c, inputs.relative);
  if (!exceeds) return result;
  if (followed && static_cast<double>(result.report.steps) * static_cast<double>(states) > kShort) return result;
  double took = 0.0;
  {
    const Stopwatch watch(took);
    second.estimate(result, wall_seconds() - begin,
                    [this](const RunInputs& changed, const SimulateOptions& how) { return run_once(changed, how); });
  }
  if (!result.report.errors.second_run.empty()) result.report.stage_seconds.emplace_back("second run", took);
  return result;
}

RunResult Simulation::run_once(const RunInputs& of_whole, const SimulateOptions& options) const {
  RunResult result = run_compiled(compiled_inputs(of_whole), options);
  if (!compiled_->part) return result;
  const ObservedPart& part = *compiled_->part;
  const std::vector<ElementId> elements = in_the_whole(part.elements);
  const std::vector<SignalId> signals = in_the_whole(part.signals);
  for (RunInputs::Initial& value : result.stored.values) {
    if (value.element.valid()) value.element = elements[value.element.index()];
    if (value.signal.valid()) value.signal = signals[value.signal.index()];
  }
  // Switches that are left out are on no side but that of the model as read.
  Mode mode = mode_of(model());
  const std::vector<ElementId> switches = switches_of(model());
  for (std::size_t i = 0, next = 0; i < switches.size(); ++i)
    if (part.elements[switches[i].index()].valid() && next < result.mode.size()) mode[i] = result.mode[next++];
  result.mode = std::move(mode);
  LeftOut left_out = part.left_out;
  const auto add = [](std::vector<std::string>& names, const std::vector<std::string>& more) {
    names.insert(names.end(), more.begin(), more.end());
  };
  add(left_out.states, result.report.left_out.states);
  add(left_out.elements, result.report.left_out.elements);
  add(left_out.signals, result.report.left_out.signals);
  left_out.not_audited = result.report.left_out.not_audited;
  left_out.loops = result.report.left_out.loops;
  result.report.left_out = std::move(left_out);
  return result;
}

RunResult Simulation::run_compiled(const RunInputs& inputs, const SimulateOptions& options) const {
  if (!compiled_->modes) return bgsim::simulate(program(), inputs, options);
  ModePrograms& modes = *compiled_->modes;
  DelayedPrograms own(program());
  const auto program_of = [&](const Mode& mode, const Mode& settling) -> const Program& {
    return own.of(modes.at(mode, inputs.parameters, settling));
  };
  const auto network_of = [&](const Mode& mode) -> const DiodeNetwork& { return own.of(modes.network(mode)); };
  const auto impact_of = [&](const Mode& mode) -> const ImpactProgram& { return own.of(modes.impact(mode)); };
  RunResult result = simulate_switched({program_of, network_of, impact_of, own.tables()}, modes.start(inputs, own),
                                       inputs, options, wall_seconds);
  if (!result.trace.names.empty()) return result;
  result.trace.names = program().output_names;  // the run ended before its first mode
  result.trace.units = program().output_units;
  result.trace.columns.resize(result.trace.names.size());
  return result;
}

Study Study::in_mode(const Mode& closed) const {
  return Study(std::make_shared<const Model>(with_idle_switches(bgsim::in_mode(model(), closed))));
}

Study Study::at_start(const std::string& name, const SceneOverrides& overrides) const {
  if (switches_of(model()).empty() || model().scenes.empty()) return *this;
  return at_start(prepare_scene(model(), name, overrides));
}

Study Study::at_start(const RunInputs& inputs) const {
  if (switches_of(model()).empty()) return *this;
  return in_mode(ModePrograms(shared_model(), {{}, false}).start(inputs).mode);
}

}  // namespace bgsim
