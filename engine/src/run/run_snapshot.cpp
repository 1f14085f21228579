// Snapshots of a run.
#include <nlohmann/json.hpp>

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
  archive("step ends", step_ends_);
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
  if (delays_.any()) archive("delays", delays_);
  archive("defects", defects_);
  archive("loops", loops_);
  archive("vitality", vitality_);
  archive("mode order", mode_order_);
  archive("stiffness", stiffness_);
  archive("errors", errors_);
  archive("recorder", recorder_);
  archive("audit", audit_);
  archive("magnitudes", magnitudes_);
  if (log_ == &own_log_) archive("log", own_log_);
}

/// @throws ModelError BG171.
bool Run::resume() {
  const auto& sources = program_.model->sources;
  const nlohmann::ordered_json state =
      state_of_snapshot(options_.resume, fingerprint(program_, inputs_), kept_by(options_), sources);
  x_.assign(program_.state_names.size(), 0.0);
  branch_ = first_branch(program_);
  audit_.record_course(inputs_.output_times, options_.energy_course);
  log_->watch(program_);
  try {
    SnapshotReader reader(state);
    carry(reader);
    if (!(t_ >= inputs_.start)) throw SnapshotError("\"t\" in it lies before the scene");
  } catch (const SnapshotError& error) {
    refuse_snapshot(error.what(), sources);
  }
  if (given_at_ || eliminated_at_ || multistep_at_) change_form(implicit_);
  log_->take_over(branch_);
  if (t_ > inputs_.stop)
    refuse_snapshot("the snapshot is of t = " + number_text(t_) + ", after the end of the scene", sources);
  due_ = due_ || delays_.due(t_);
  if (!due_) evaluator_.go_on(t_, branch_, inputs_.stop);
  return true;
}

/// What the integrator remembers of past steps is no part of a snapshot: it restarts here, as it will where the run
/// is resumed.
void Run::offer_snapshot() {
  next_snapshot_ = steps_before_ + steps_ + options_.snapshot_steps;
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
  options_.snapshot(t_, snapshot_text(program_.model->name, inputs_.scene, t_, fingerprint(program_, inputs_),
                                      kept_by(options_), writer.json()));
}

}  // namespace bgsim
