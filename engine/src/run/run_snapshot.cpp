// Snapshots of a run.
#include <nlohmann/json.hpp>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "run/run.hpp"
#include "run/snapshot.hpp"

namespace bgsim {

template <class Archive>
void Run::carry(Archive& archive) {
  archive("t", t_);
  archive("x", x_);
  archive("branch", branch_);
  archive("implicit", implicit_);
  archive("given at", given_at_);
  archive("eliminated at", eliminated_at_);
  archive("multistep at", multistep_at_);
  archive("next look", next_look_);
  archive("failures seen", failures_seen_);
  archive("due", due_);
  archive("steps", steps_);
  archive("time events", time_events_);
  archive("next estimate", next_estimate_);
  archive("rescued at", rescued_at_);
  archive("jumped at", jumped_at_);
  archive("strayed at", strayed_at_);
  archive("strayed", strayed_);
  archive("counts", counts_before_);
  archive("loop iterations", loop_iterations_before_);
  archive("notes", result_.report.notes);
  archive("tolerances", tolerances_);
  archive("events", events_);
  archive("jumps", jumps_);
  archive("defects", defects_);
  archive("loops", loops_);
  archive("vitality", vitality_);
  archive("mode order", mode_order_);
  archive("errors", errors_);
  archive("recorder", recorder_);
  archive("audit", audit_);
  archive("magnitudes", magnitudes_);
  archive("log", *log_);
}

/// @throws ModelError BG171.
bool Run::resume() {
  const auto refuse = [&](const std::string& why) {
    Diagnostic diagnostic = diagnostic_of("BG171", "the run cannot be continued: " + why);
    diagnostic.rule = "a snapshot holds the state of a run of one model, scene and method";
    diagnostic.help = "give the model, scene and options of the run that wrote it; output times and the end may differ";
    throw ModelError({std::move(diagnostic)}, program_.model->sources);
  };
  const auto json = nlohmann::ordered_json::parse(options_.resume, nullptr, false);
  if (!json.is_object() || json.value("bgsim_snapshot", nlohmann::ordered_json()) != kSnapshotFormat ||
      !json.contains("state") || !json["state"].is_object())
    refuse("the text is no snapshot that this version of bgsim has written");
  if (json.value("program", nlohmann::ordered_json()) != fingerprint(program_, inputs_))
    refuse("the snapshot is one of another model, scene, method or set of outputs");
  x_.assign(program_.state_names.size(), 0.0);
  branch_ = first_branch(program_);
  audit_.record_course(inputs_.output_times, options_.energy_course);
  log_->watch(program_);
  try {
    SnapshotReader reader(json["state"]);
    carry(reader);
    if (!(t_ >= inputs_.start)) throw SnapshotError("\"t\" in it lies before the scene");
  } catch (const SnapshotError& error) {
    refuse(error.what());
  }
  if (given_at_ || eliminated_at_ || multistep_at_) change_form(implicit_);
  log_->take_over(branch_);
  if (t_ > inputs_.stop) refuse("the snapshot is of t = " + number_text(t_) + ", after the end of the scene");
  return true;
}

/// What the integrator remembers of past steps is no part of a snapshot: it restarts here, as it will where the run
/// is resumed.
void Run::offer_snapshot() {
  next_snapshot_ = steps_ + options_.snapshot_steps;
  if (!options_.snapshot || between_ || !integrator_) return;
  counts_before_ = counts();
  integrator_.reset();
  choose_integrator();
  fresh_ = true;
  const std::uint64_t before = loop_iterations_before_;
  loop_iterations_before_ += evaluator_.counts().loop_iterations;
  SnapshotWriter writer;
  carry(writer);
  loop_iterations_before_ = before;
  const nlohmann::ordered_json json = {
      {"bgsim_snapshot", kSnapshotFormat},         {"model", program_.model->name}, {"scene", inputs_.scene}, {"t", t_},
      {"program", fingerprint(program_, inputs_)}, {"state", writer.json()}};
  options_.snapshot(t_, json.dump(1, '\t') + "\n");
}

}  // namespace bgsim
