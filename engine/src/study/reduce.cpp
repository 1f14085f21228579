#include "bgsim/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "base/codes.hpp"
#include "bgsim/modes.hpp"
#include "model/element_kinds.hpp"
#include "run/failures.hpp"
#include "study/flat_model.hpp"
#include "study/junction_measure.hpp"
#include "study/observed_part.hpp"

namespace bgsim {
namespace {

std::size_t operations(const Program& program) {
  std::size_t count = 0;
  const auto add = [&count](const Routine& routine) {
    for (const auto& code : routine.code) count += code.size();
  };
  add(program.rates);
  for (const ProgramBlock& block : program.blocks) add(block.residual);
  return count;
}

/// The elements that a part leaves out.
std::vector<ElementId> elements_outside(const std::optional<ObservedPart>& part) {
  std::vector<ElementId> result;
  for (std::size_t i = 0; part && i < part->elements.size(); ++i)
    if (!part->elements[i].valid()) result.emplace_back(i);
  return result;
}

class Reducer {
 public:
  Reducer(const Study& study, const ReduceOptions& options)
      : options_(options),
        full_(study),
        inputs_(prepare_scene(study.model(), options.scene)),
        names_(flat_names(study.model())) {
    for (std::size_t i = 0; i < names_.size(); ++i) element_of_[names_[i]] = ElementId(i);
  }

  Reduction run() {
    check_question();
    const RunResult full = run_plain(full_, inputs_, 0, &result_.size_before);
    end_if_failed(full, full_.model());
    result_.reference = full.trace;
    // The full model may take its time; a cut that makes it much slower is none.
    constexpr std::uint64_t kTimesAsLong = 2, kAtLeast = 1000;
    max_steps_ = kTimesAsLong * full.report.steps + kAtLeast;
    result_.activity = observe(full_, inputs_);
    leave_away_unobserved();
    for (bool went = true; went;) went = round();
    finish();
    return std::move(result_);
  }

 private:
  void check_question() const {
    const auto refuse = [&](const char* code, std::string situation, std::string rule, std::string help) {
      Place place;
      for (const Scene& scene : full_.model().scenes)
        if (scene.name == inputs_.scene) place = scene.place;
      throw ModelError({diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help))},
                       full_.model().sources);
    };
    if (inputs_.outputs.empty())
      refuse("BG710", "the scene \"" + inputs_.scene + "\" records no outputs, so nothing can be in error",
             "a model is reduced to what the outputs of a scene require",
             "add \"outputs\" to the model: the quantities to record");
    std::vector<std::string> names;
    for (const Element& element : full_.model().elements) names.push_back(element.name);
    for (const std::string& name : options_.keep)
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        const std::string near = nearest_name(name, names);
        refuse("BG712", "there is no element \"" + name + "\" that could be kept", {},
               near.empty() ? "elements are named in full, such as left.mass" : "did you mean \"" + near + "\"?");
      }
    constexpr double kClear = 10.0;  // what a run adds up of the errors in its steps
    if (!(options_.error >= kClear * inputs_.relative))
      refuse("BG711",
             "an error of " + number_text(options_.error, 3) +
                 " cannot be distinguished from the solver's own at the relative tolerance " +
                 number_text(inputs_.relative, 3) + " of the scene \"" + inputs_.scene + "\"",
             "the error allowed must be ten times the relative tolerance or more",
             "allow a larger error, or give the scene a smaller \"relative\"");
  }

  /// As `bgsim run` does it, without the audit.
  RunResult run_plain(const Study& study, const RunInputs& inputs, std::uint64_t max_steps, ModelSize* size) const {
    const Simulation scene = study.scene(inputs, {.energy_audit = false});
    const Program& program = scene.program();
    if (size != nullptr)
      *size = {study.model().elements.size(), study.model().bonds.size(), program.state_names.size(),
               operations(program)};
    SimulateOptions how;
    how.energy_audit = false;
    how.error_estimate = false;
    how.max_steps = max_steps;
    how.progress = options_.progress;
    return scene.simulate(how);
  }

  static void end_if_failed(const RunResult& result, const Model& model) {
    if (result.failure) throw ModelError({*result.failure}, model.sources);
  }

  /// Runs with audit and all bonds' variables: activities, and how large efforts and flows are.
  std::vector<ElementActivity> observe(const Study& study, const RunInputs& inputs) {
    const Study observed(with_bonds_as_outputs(study.model()));
    RunInputs with_bonds = inputs;
    for (std::size_t i = study.model().outputs.size(); i < observed.model().outputs.size(); ++i)
      with_bonds.outputs.push_back(i);
    const Simulation scene = observed.scene(with_bonds, {.keep_all = true});
    SimulateOptions how;
    how.error_estimate = false;
    how.progress = options_.progress;
    const RunResult result = scene.simulate(how);
    end_if_failed(result, study.model());
    const JunctionMeasure measure(study.graph(), result.trace, inputs.outputs.size());
    std::vector<ElementActivity> table = activities(scene.program(), result);
    candidates_.clear();
    for (const ElementActivity& row : table) {
      const auto found = element_of_.find(study.model().elements[row.element.index()].name);
      const bool can_go = is_passive_one_port(study.graph().kinds[row.element.index()]);
      const ElementId id = &study == &full_ ? row.element : found->second;
      if (can_go && !is_kept(id)) candidates_.push_back({id, row.share, measure.first_choice(row.element)});
    }
    std::reverse(candidates_.begin(), candidates_.end());
    return table;
  }

  [[nodiscard]] bool is_kept(ElementId id) const {
    const std::string& name = full_.model().elements[id.index()].name;
    return std::find(options_.keep.begin(), options_.keep.end(), name) != options_.keep.end();
  }

  /// Exact, if what remains is a model: bonds to what is left away must have ended at junctions.
  void leave_away_unobserved() {
    result_.unobserved = equations_stay(full_.model())
                             ? unobserved_elements(full_.model(), full_.equations(), inputs_.outputs)
                             : elements_outside(observed_part(full_.model(), inputs_.outputs));
    while (!result_.unobserved.empty()) {
      try {
        const Study study(read(text_of({}, {}, 0.0)));
        const RunInputs inputs = prepare_scene(study.model(), inputs_.scene);
        const RunResult result = run_plain(study, inputs, max_steps_, nullptr);
        end_if_failed(result, study.model());
        if (worst(output_errors(result_.reference, result.trace)).error > options_.error) break;
        observe(study, inputs);
        return;
      } catch (const CutRefused& refusal) {
        // An output can be known without an element and name it, or its bond: the effort of a resistor at a source.
        // What is named stays.
        const auto is_needed = [&](ElementId id) {
          return std::find(refusal.needed().begin(), refusal.needed().end(), id) != refusal.needed().end();
        };
        if (std::erase_if(result_.unobserved, is_needed) == 0) break;
      } catch (const ModelError& error) {
        if (error.diagnostics.front().code == "BG606") throw;
        break;
      }
    }
    result_.unobserved.clear();
  }

  struct Candidate {
    ElementId element;
    double share;
    CutKind first;
  };

  /// Tries every element that is left, the least active first. True if any went.
  bool round() {
    bool any = false;
    std::vector<ElementId> tried;
    for (bool more = true; more;) {
      more = false;
      for (const Candidate candidate : candidates_) {
        if (std::find(tried.begin(), tried.end(), candidate.element) != tried.end()) continue;
        tried.push_back(candidate.element);
        // Nothing has changed since it was tried last.
        const auto last = tried_after_.find(candidate.element);
        if (last != tried_after_.end() && last->second == result_.cuts.size()) continue;
        tried_after_[candidate.element] = result_.cuts.size();
        const CutKind second = candidate.first == CutKind::zero_effort ? CutKind::zero_flow : CutKind::zero_effort;
        more = try_cut(candidate, candidate.first) || try_cut(candidate, second);
        // Activities and junctions are others now: the ranking begins again.
        if (more) break;
      }
      any = any || more;
    }
    return any;
  }

  bool try_cut(const Candidate& candidate, CutKind kind) {
    CutTrial trial;
    trial.cut = {candidate.element, kind};
    trial.share = candidate.share;
    try {
      std::vector<Cut> cuts = result_.cuts;
      cuts.push_back(trial.cut);
      const Study study(read(text_of(cuts, {}, 0.0)));
      const RunInputs inputs = prepare_scene(study.model(), inputs_.scene);
      const RunResult result = run_plain(study, inputs, max_steps_, nullptr);
      if (result.stop == StopReason::interrupted) end_if_failed(result, study.model());
      if (result.failure) {
        trial.refusal = result.failure->code + ": " + result.failure->situation;
      } else {
        trial.error = worst(output_errors(result_.reference, result.trace));
        if (trial.error.error <= options_.error) {
          observe(study, inputs);
          trial.made = true;
          result_.cuts = std::move(cuts);
        }
      }
    } catch (const ModelError& error) {
      const Diagnostic& first = error.diagnostics.front();
      if (first.code == "BG606") throw;
      trial.refusal = first.code + ": " + first.situation;
    } catch (const CutRefused& refusal) {
      trial.refusal = refusal.what();
    }
    result_.trials.push_back(trial);
    return trial.made;
  }

  [[nodiscard]] std::shared_ptr<const Model> read(std::string text) const {
    return std::make_shared<const Model>(read_model_text(options_.file, std::move(text)));
  }

  [[nodiscard]] std::string text_of(const std::vector<Cut>& cuts, const std::string& about, double tolerance) const {
    FlatModelOptions how;
    how.file = options_.file;
    how.scene = inputs_.scene;
    how.name = full_.model().name + "_reduced";
    how.about = about;
    how.cuts = cuts;
    how.dropped = result_.unobserved;
    if (tolerance > 0.0) {
      how.reference = options_.reference;
      how.reference_relative = tolerance;
    }
    return flat_model_json(full_.model(), full_.graph(), how);
  }

  void finish() {
    const Study reduced(read(text_of(result_.cuts, {}, 0.0)));
    const RunInputs inputs = prepare_scene(reduced.model(), inputs_.scene);
    const RunResult last = run_plain(reduced, inputs, 0, &result_.size_after);
    end_if_failed(last, reduced.model());
    result_.errors = output_errors(result_.reference, last.trace);
    result_.text = text_of(result_.cuts, story(), verify_tolerance(last.trace));
    result_.cost_before = cost(full_, inputs_);
    result_.cost_after = cost(reduced, inputs);
  }

  /// What `bgsim verify` needs to hold the reduced model against the reference: relative to the largest magnitude, half
  /// as much again as was found.
  [[nodiscard]] double verify_tolerance(const Trace& trace) const {
    constexpr double kMargin = 1.5;
    const Trace& full = result_.reference;
    double found = inputs_.relative;
    for (std::size_t c = 0; c < full.names.size(); ++c) {
      double magnitude = 0.0, distance = 0.0;
      for (std::size_t i = 0; i < full.times.size(); ++i) {
        magnitude = std::max(magnitude, std::abs(full.columns[c][i]));
        distance = std::max(distance, std::abs(full.columns[c][i] - trace.columns[c][i]));
      }
      if (magnitude > 0.0) found = std::max(found, distance / magnitude);
    }
    return kMargin * found;
  }

  [[nodiscard]] ModelCost cost(const Study& study, const RunInputs& inputs) const {
    ModelCost cost;
    cost.seconds = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::max<std::size_t>(1, options_.repetitions); ++i) {
      const RunResult result = run_plain(study, inputs, 0, nullptr);
      end_if_failed(result, study.model());
      const RunReport& report = result.report;
      cost.steps = report.steps;
      cost.rate_evaluations = report.rate_evaluations;
      for (const auto& [stage, seconds] : report.stage_seconds)
        if (stage == "integration") cost.seconds = std::min(cost.seconds, seconds);
    }
    return cost;
  }

  /// Where the model comes from, what was cut out of it, and with which effect.
  [[nodiscard]] std::string story() const {
    const OutputError error = worst(result_.errors);
    std::string text = "Reduced by bgsim from " + (options_.parent.empty() ? full_.model().name : options_.parent) +
                       " for its scene " + inputs_.scene + " with an error of " + number_text(options_.error, 3) +
                       " allowed in the outputs, relative to their ranges. ";
    if (!result_.unobserved.empty()) {
      text += "Left away, since no output depends on them: ";
      const char* between = "";
      for (const ElementId id : result_.unobserved) {
        text += between + full_.model().elements[id.index()].name;
        between = ", ";
      }
      text += ". ";
    }
    if (result_.cuts.empty()) return text + "Nothing was cut.";
    text += "Cut, with the largest error after each cut: ";
    const char* joint = "";
    for (const CutTrial& trial : result_.trials) {
      if (!trial.made) continue;
      text += joint + full_.model().elements[trial.cut.element.index()].name + " (" + cut_text(trial.cut.kind) + ", " +
              number_text(trial.error.error, 3) + ")";
      joint = ", ";
    }
    text += ". Largest error: " + number_text(error.error, 3) + " in " + error.output +
            " at t = " + number_text(error.time, 6) + ". It says nothing of other scenes.";
    if (!full_.model().about.empty()) text += " The parent: " + full_.model().about;
    return text;
  }

  const ReduceOptions& options_;
  const Study full_;
  RunInputs inputs_;
  std::vector<std::string> names_;  ///< flat, by ElementId
  std::unordered_map<std::string, ElementId> element_of_;
  std::vector<Candidate> candidates_;  ///< of the model with the cuts made so far, the least active first
  std::unordered_map<ElementId, std::size_t> tried_after_;  ///< so many cuts
  std::uint64_t max_steps_ = 0;
  Reduction result_;
};

}  // namespace

Reduction reduce(const Study& study, const ReduceOptions& options) { return Reducer(study, options).run(); }

}  // namespace bgsim
