// A scene, run and held against its reference for the report.
#include <algorithm>
#include <iterator>

#include "progress.hpp"
#include "report/content.hpp"
#include "scenes.hpp"

namespace bgsim::cli {

namespace {

/// Points of the energy audit over time: more than a screen has columns of pixels to draw its smooth curves.
constexpr std::size_t kCoursePoints = 2000;

/// The rows of @p trace at @p times, all of which it has.
Trace rows_at(const Trace& trace, const std::vector<double>& times) {
  Trace rows{trace.names, trace.units, times, {}};
  rows.columns.resize(trace.columns.size());
  std::size_t row = 0;
  for (const double t : times) {
    while (trace.times[row] < t) ++row;
    for (std::size_t i = 0; i < rows.columns.size(); ++i) rows.columns[i].push_back(trace.columns[i][row]);
  }
  return rows;
}

/// The scene's reference, whose times become output times beside the scene's own: then nothing that is compared is
/// interpolated.
void take_reference(const Model& model, ReportedScene& scene) {
  scene.reference = read_reference(model, *scene.inputs.reference);
  const std::vector<double> theirs = at_reference_times(model, scene.inputs, *scene.reference).output_times.list();
  const std::vector<double> ours = scene.inputs.output_times.list();
  std::vector<double> both;
  std::set_union(ours.begin(), ours.end(), theirs.begin(), theirs.end(), std::back_inserter(both));
  scene.inputs.output_times = std::move(both);
}

}  // namespace

ReportedScene run_for_report(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                             const RunLimits& limits, bool quiet) {
  const Model& model = study.model();
  ReportedScene done;
  done.inputs = prepare(model, scene, overrides);
  for (const Scene& written : model.scenes)
    if (written.name == done.inputs.scene) done.about = written.about;
  print_warnings(done.inputs.warnings, model);
  if (done.inputs.reference) take_reference(model, done);

  const Simulation compiled = study.scene(done.inputs, {.keep_all = true});
  {
    RunWatch watch(done.inputs.start, done.inputs.stop, quiet);
    SimulateOptions how;
    how.energy_course = kCoursePoints;
    LaneBook book;
    how.events = [&book](const RunEvent& event) { book.take(event); };
    limits.apply(how);
    how.progress = watch.progress();
    done.result = compiled.simulate(how);
    done.lanes = book.lanes(done.inputs.start);
  }
  auto& all_seconds = done.result.report.stage_seconds;
  all_seconds.insert(all_seconds.begin(), compiled.seconds().begin(), compiled.seconds().end());
  const StageSeconds before = study.seconds();
  all_seconds.insert(all_seconds.begin(), before.begin(), before.end());
  const UnitReport units = infer_units(model, study.graph(), done.inputs.scene);
  done.result.report.energy_unit = units.energy;
  for (std::size_t column = 0; column < done.inputs.outputs.size(); ++column)
    if (done.result.trace.units[column].empty())
      done.result.trace.units[column] = units.outputs[done.inputs.outputs[column]].text;
  done.activity = activities(compiled.program(), done.result);
  if (!done.reference) return done;

  const Reference& reference = *done.inputs.reference;
  done.bands = reference_bands(model, done.result.trace.names, *done.reference, reference);
  if (done.result.stop == StopReason::completed)
    done.check =
        hold_against(model, rows_at(done.result.trace, done.reference->columns.front()), *done.reference, reference);
  return done;
}

}  // namespace bgsim::cli
