#include <algorithm>
#include <nlohmann/json.hpp>

#include "bgsim/simulate.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"

namespace bgsim {

namespace {

const char* stop_text(StopReason stop) {
  switch (stop) {
    case StopReason::completed:
      return "completed";
    case StopReason::interrupted:
      return "interrupted";
    case StopReason::failed:
      return "failed";
  }
  return "";
}

/// "name      text", names padded to one column, whatever the text in one line.
void line(std::string& out, const std::string& name, const std::string& text) {
  constexpr std::size_t kNames = 14;
  out += "  " + name + std::string(name.size() < kNames ? kNames - name.size() : 1, ' ') + visible_line(text) + "\n";
}

std::string count_text(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string tolerance_text(const RunReport& report) {
  std::string text = "relative " + number_text(report.relative, 3);
  if (report.absolute.empty()) return text;
  constexpr std::size_t kListed = 8;
  if (report.absolute.size() <= kListed) {
    text += "; absolute";
    for (std::size_t i = 0; i < report.absolute.size(); ++i)
      text += (i == 0 ? " " : ", ") + report.absolute[i].first + " " + number_text(report.absolute[i].second, 3);
    return text;
  }
  const auto by_size = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto [least, most] = std::minmax_element(report.absolute.begin(), report.absolute.end(), by_size);
  return text + "; absolute from " + number_text(least->second, 3) + " (" + least->first + ") to " +
         number_text(most->second, 3) + " (" + most->first + ")";
}

/// "what a, b, c and 2 more"
std::string names_text(const char* what, const std::vector<std::string>& names) {
  constexpr std::size_t kListed = 8;
  std::string text = what;
  for (std::size_t i = 0; i < names.size() && i < kListed; ++i) text += (i == 0 ? " " : ", ") + names[i];
  if (names.size() > kListed) text += " and " + std::to_string(names.size() - kListed) + " more";
  return text;
}

void left_out_lines(std::string& out, const LeftOut& left_out) {
  if (left_out.nothing()) return;
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (!left_out.states.empty()) add(names_text("states", left_out.states));
  if (!left_out.elements.empty()) add(names_text("elements", left_out.elements));
  if (!left_out.signals.empty()) add(names_text("signals", left_out.signals));
  if (left_out.loops > 0) add(count_text(left_out.loops, "algebraic loop", "algebraic loops"));
  line(out, "left out", text);
  line(out, "", "no output depends on these; --keep-all keeps them");
}

/// "x [m], P1 [Pa], n": what the trace holds.
std::string columns_text(const Trace& trace) {
  constexpr std::size_t kListed = 8;
  std::string text;
  for (std::size_t i = 0; i < trace.names.size() && i < kListed; ++i)
    text += (i == 0 ? "" : ", ") + short_name(trace.names[i]) +
            (trace.units[i].empty() ? "" : " [" + short_name(trace.units[i]) + "]");
  if (trace.names.size() > kListed) text += " and " + std::to_string(trace.names.size() - kListed) + " more";
  return text;
}

/// "up to 2.1e-07 of its range ("u"); instants of events 3e-10 ("free (conducts)"); by a second run at a tenth of ..."
std::string second_run_text(const Trace& trace, const OutputErrors& errors) {
  std::optional<std::size_t> worst;
  const auto part = [&](std::size_t i) { return errors.estimate[i] / errors.range[i]; };
  for (std::size_t i = 0; i < errors.estimate.size(); ++i)
    if (errors.estimate[i] > 0.0 && (!worst || part(i) > part(*worst))) worst = i;
  std::string text = "outputs " + std::string(worst ? "up to " + number_text(part(*worst), 2) + " of the range (\"" +
                                                          short_name(trace.names[*worst]) + "\")"
                                                    : "0");
  if (errors.instants)
    text += "; instants of events " + (errors.instants_of.empty() ? std::string("0")
                                                                  : "up to " + number_text(*errors.instants, 2) + " (" +
                                                                        short_name(errors.instants_of) + ")");
  return text + "; from a second run " + errors.second_run;
}

void errors_line(std::string& out, const Trace& trace, const OutputErrors& errors) {
  if (!errors.second_run.empty()) {
    line(out, "errors", second_run_text(trace, errors));
    return;
  }
  if (errors.possible) return;
  line(out, "errors", "not estimated: " + errors.why_not + "; a run at a tenth of the tolerance shows them");
}

void energy_lines(std::string& out, const RunReport& report) {
  const EnergyAudit& energy = report.energy;
  const LeftOut& left_out = report.left_out;
  const std::string unit = report.energy_unit.empty() ? "" : " [" + report.energy_unit + "]";
  if (!energy.done) {
    line(out, "energy", "not audited: " + energy.why_not);
    return;
  }
  const std::string events = report.set_events.empty() ? "" : " + events " + number_text(energy.events, 6);
  std::string terms = "supplied " + number_text(energy.supplied, 6) + events + " = stored " +
                      number_text(energy.stored, 6) + " + dissipated " + number_text(energy.dissipated, 6);
  if (report.switches) terms += " + switching " + number_text(energy.switching, 6);
  if (report.contacts) terms += " + impacts " + number_text(energy.impacts, 6);
  if (energy.exchanged != 0.0) terms += " + exchanged " + number_text(energy.exchanged, 6);
  line(out, "energy", terms + unit);
  line(out, "", "residual " + number_text(energy.residual, 3) + ", relative " + number_text(energy.relative, 3));
  if (!left_out.not_audited.empty())
    line(out, "", "of what is kept only, without " + names_text("", left_out.not_audited).substr(1));
  if (energy.least_dissipation < 0.0)
    line(out, "",
         "active element: \"" + energy.least_dissipation_element + "\" gave off up to " +
             number_text(-energy.least_dissipation, 4));
}

}  // namespace

std::string report_text(const RunResult& result) {
  const RunReport& r = result.report;
  std::string out = short_name(r.model) + (r.scene.empty() ? "" : ", scene " + short_name(r.scene)) + ": " +
                    stop_text(result.stop) + "\n";
  line(out, "time",
       number_text(r.start) + " to " + number_text(r.stop) +
           (r.reached == r.stop ? "" : ", reached " + number_text(r.reached)) + ", " +
           count_text(result.rows, "output time", "output times"));
  std::string system = count_text(r.states, "state", "states");
  if (r.loops > 0)
    system += ", " + count_text(r.loops, "algebraic loop", "algebraic loops") + " with " +
              count_text(r.algebraic, "variable", "variables");
  line(out, "system", system);
  if (!r.method.empty()) line(out, "method", r.method + (r.method_reason.empty() ? "" : " (" + r.method_reason + ")"));
  if (r.step > 0.0)
    line(out, "step", number_text(r.step) + " at most, whole steps between events");
  else
    line(out, "tolerance", tolerance_text(r));
  if (r.states > 0) {
    line(out, "steps",
         std::to_string(r.steps) + ", error test failures " + std::to_string(r.error_test_failures) +
             ", convergence failures " + std::to_string(r.convergence_failures));
    line(out, "evaluations",
         "rates " + std::to_string(r.rate_evaluations) + ", Jacobians " + std::to_string(r.jacobian_evaluations) +
             ", factorizations " + std::to_string(r.factorizations) +
             (r.loops > 0 ? ", loop iterations " + std::to_string(r.loop_iterations) : ""));
  }
  if (r.time_events + r.state_events > 0)
    line(out, "events",
         count_text(r.time_events, "known time", "known times") + ", " +
             count_text(r.state_events, "change of a condition", "changes of conditions"));
  if (!r.set_events.empty()) {
    constexpr std::size_t kListed = 8;
    std::string text;
    for (std::size_t i = 0; i < r.set_events.size() && i < kListed; ++i)
      text += (i == 0 ? "" : ", ") + short_name(r.set_events[i].name) + " " +
              count_text(r.set_events[i].count, "time", "times");
    if (r.set_events.size() > kListed) text += " and " + std::to_string(r.set_events.size() - kListed) + " more";
    line(out, "set", text);
  }
  if (r.switches)
    line(out, "switches",
         count_text(r.mode_changes, "change of the mode", "changes of the mode") + ", " +
             count_text(r.modes, "mode", "modes") + " met" +
             (r.contacts ? ", " + count_text(r.impacts, "impact", "impacts") : ""));
  left_out_lines(out, r.left_out);
  energy_lines(out, r);
  errors_line(out, result.trace, r.errors);
  if (!result.trace.names.empty()) line(out, "outputs", columns_text(result.trace));
  if (!r.stage_seconds.empty()) {
    std::string stages;
    for (const auto& [stage, seconds] : r.stage_seconds)
      stages += (stages.empty() ? "" : ", ") + stage + " " + number_text(1e3 * seconds, 3) + " ms";
    line(out, "wall time", stages);
  }
  for (const std::string& note : r.notes) line(out, "note", note);
  return out;
}

std::string report_json(const RunResult& result) {
  using Json = nlohmann::ordered_json;
  const RunReport& r = result.report;
  Json json;
  json["model"] = r.model;
  json["scene"] = r.scene;
  json["stop_reason"] = stop_text(result.stop);
  json["time"] = {{"start", r.start}, {"stop", r.stop}, {"reached", r.reached}, {"outputs", result.rows}};
  json["system"] = {{"states", r.states}, {"loops", r.loops}, {"algebraic", r.algebraic}};
  json["left_out"] = {{"states", r.left_out.states},
                      {"elements", r.left_out.elements},
                      {"signals", r.left_out.signals},
                      {"loops", r.left_out.loops}};
  json["method"] = {{"name", r.method}, {"reason", r.method_reason}};
  if (r.step > 0.0) json["method"]["step"] = r.step;
  Json absolute = Json::object();
  for (const auto& [state, tolerance] : r.absolute) absolute[state] = tolerance;
  json["tolerances"] = {{"relative", r.relative}, {"absolute", std::move(absolute)}};
  json["counts"] = {{"steps", r.steps},
                    {"rate_evaluations", r.rate_evaluations},
                    {"jacobian_evaluations", r.jacobian_evaluations},
                    {"factorizations", r.factorizations},
                    {"nonlinear_iterations", r.nonlinear_iterations},
                    {"error_test_failures", r.error_test_failures},
                    {"convergence_failures", r.convergence_failures},
                    {"loop_iterations", r.loop_iterations},
                    {"time_events", r.time_events},
                    {"state_events", r.state_events}};
  for (const RunReport::SetEvent& event : r.set_events) {
    json["set_events"][event.name] = {{"count", event.count}};
    if (r.energy.done) json["set_events"][event.name]["energy"] = event.energy;
  }
  if (r.switches) {
    json["counts"]["mode_changes"] = r.mode_changes;
    json["counts"]["modes"] = r.modes;
    if (r.contacts) json["counts"]["impacts"] = r.impacts;
  }
  if (r.energy.done) {
    json["energy"] = {{"supplied", r.energy.supplied},     {"stored", r.energy.stored},
                      {"dissipated", r.energy.dissipated}, {"exchanged", r.energy.exchanged},
                      {"residual", r.energy.residual},     {"relative", r.energy.relative}};
    if (!r.set_events.empty()) json["energy"]["events"] = r.energy.events;
    if (r.switches) json["energy"]["switching"] = r.energy.switching;
    if (r.contacts) json["energy"]["impacts"] = r.energy.impacts;
    if (!r.energy.least_dissipation_element.empty())
      json["energy"]["least_dissipation"] = {{"element", r.energy.least_dissipation_element},
                                             {"power", r.energy.least_dissipation}};
    if (!r.energy_unit.empty()) json["energy"]["unit"] = r.energy_unit;
    json["energy"]["not_audited"] = r.left_out.not_audited;
  } else {
    json["energy"] = {{"why_not", r.energy.why_not}};
  }
  json["errors"] = nlohmann::ordered_json::object();
  if (!r.errors.done) json["errors"]["why_not"] = r.errors.why_not;
  for (std::size_t i = 0; i < r.errors.estimate.size(); ++i)
    json["errors"][result.trace.names[i]] = {{"estimate", r.errors.estimate[i]}, {"range", r.errors.range[i]}};
  if (!r.errors.second_run.empty()) json["errors_from"]["second_run"] = r.errors.second_run;
  for (const std::size_t i : r.errors.beyond_first_order)
    json["errors_from"]["beyond_first_order"].push_back(result.trace.names[i]);
  if (r.errors.instants)
    json["errors_from"]["instants"] = {{"estimate", *r.errors.instants}, {"of", r.errors.instants_of}};
  json["units"] = Json::object();
  for (std::size_t i = 0; i < result.trace.names.size(); ++i)
    if (!result.trace.units[i].empty()) json["units"][result.trace.names[i]] = result.trace.units[i];
  Json seconds = Json::object();
  for (const auto& [stage, value] : r.stage_seconds) seconds[stage] = value;
  json["seconds"] = std::move(seconds);
  json["notes"] = r.notes;
  if (result.failure) {
    json["failure"] = {{"code", result.failure->code}, {"situation", result.failure->situation}};
    Json notes = Json::array();
    for (const Note& note : result.failure->notes) notes.push_back(note.text);
    if (!notes.empty()) json["failure"]["notes"] = std::move(notes);
    if (!result.failure->help.empty()) json["failure"]["help"] = result.failure->help;
  }
  return json_text(json, 2) + "\n";
}

}  // namespace bgsim
