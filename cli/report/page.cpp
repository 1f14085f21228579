// The report as one page: frame, overview, and the curves' data for cli/web/report.js.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "bgsim/xml.hpp"
#include "html.hpp"
#include "report/assets.hpp"
#include "report/content.hpp"
#include "thinning.hpp"

namespace bgsim::cli {

namespace {

using Cells = std::vector<std::string>;
using Json = nlohmann::ordered_json;

struct Section {
  const char* id;
  const char* title;
};
constexpr Section kSections[] = {{"summary", "Summary"},       {"drawing", "Bond graph"},  {"outputs", "Outputs"},
                                 {"energy", "Energy"},         {"causality", "Causality"}, {"parameters", "Parameters"},
                                 {"equations", "Equations"},   {"activity", "Activity"},   {"studies", "Studies"},
                                 {"statistics", "Statistics"}, {"reproduce", "Reproduce"}};

/// The arrays of the page, each once.
class Arrays {
 public:
  std::size_t add(std::span<const double> values) {
    texts_.push_back(base64(values));
    return texts_.size() - 1;
  }
  [[nodiscard]] const Json& texts() const { return texts_; }

 private:
  Json texts_ = Json::array();
};

std::vector<double> at(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> some;
  some.reserve(rows.size());
  for (const std::size_t row : rows) some.push_back(values[row]);
  return some;
}

std::size_t output_index(const Json& outputs, const std::string& name) {
  std::size_t i = 0;
  while (outputs[i]["name"] != name) ++i;
  return i;
}

/// All outputs that any scene records, in the model's order.
Json outputs_of(const ReportContent& content) {
  Json outputs = Json::array();
  for (const Output& output : content.study.model().outputs) {
    const std::string* unit = nullptr;  // given or inferred, by the first scene that records it
    for (const ReportedScene& scene : content.scenes) {
      const Trace& trace = scene.result.trace;
      const auto found = std::find(trace.names.begin(), trace.names.end(), output.name);
      if (found != trace.names.end() && unit == nullptr)
        unit = &trace.units[static_cast<std::size_t>(found - trace.names.begin())];
    }
    if (unit != nullptr) outputs.push_back({{"name", output.name}, {"unit", *unit}});
  }
  return outputs;
}

/// The curves of one scene, thinned for drawing. Curves that are kept whole share their times.
void add_curves(Json& data, Arrays& arrays, const ReportContent& content, std::size_t scene) {
  const Trace& trace = content.scenes[scene].result.trace;
  const std::size_t shared = arrays.add(trace.times.size() <= content.points ? trace.times : std::vector<double>());
  for (std::size_t i = 0; i < trace.names.size(); ++i) {
    const std::vector<double>& values = trace.columns[i];
    const std::vector<std::size_t> kept = thinned(trace.times, values, content.points / 4);
    const bool whole = kept.size() == values.size();
    data["curves"].push_back({{"output", output_index(data["outputs"], trace.names[i])},
                              {"scene", scene},
                              {"t", whole ? shared : arrays.add(at(trace.times, kept))},
                              {"v", arrays.add(at(values, kept))},
                              {"of", values.size()}});
  }
}

void add_references(Json& data, Arrays& arrays, const ReportContent& content, std::size_t scene) {
  const ReportedScene& reported = content.scenes[scene];
  for (const ReferenceBand& band : reported.bands) {
    const std::vector<double>& times = reported.reference->columns.front();
    const std::vector<std::size_t> kept = thinned(times, band.values, content.points / 4);
    data["references"].push_back({{"output", output_index(data["outputs"], band.output)},
                                  {"scene", scene},
                                  {"t", arrays.add(at(times, kept))},
                                  {"v", arrays.add(at(band.values, kept))},
                                  {"low", arrays.add(at(band.low, kept))},
                                  {"high", arrays.add(at(band.high, kept))}});
  }
}

void add_energy(Json& data, Arrays& arrays, const RunReport& report, std::size_t scene) {
  const EnergyCourse& course = report.energy.course;
  const std::string& unit = report.energy_unit;
  if (course.times.empty()) return;
  Json entry{{"scene", scene}, {"unit", unit}, {"t", arrays.add(course.times)}, {"terms", Json::array()}};
  const auto add = [&](const char* name, const std::vector<double>& values) {
    entry["terms"].push_back({{"name", name}, {"v", arrays.add(values)}});
  };
  add("supplied", course.supplied);
  add("stored", course.stored);
  add("dissipated", course.dissipated);
  if (std::any_of(course.exchanged.begin(), course.exchanged.end(), [](double e) { return e != 0.0; }))
    add("exchanged", course.exchanged);
  entry["residual"] = arrays.add(course.residual);
  data["energy"].push_back(std::move(entry));
}

constexpr std::size_t kMostLanes = 60;  // a scene

void add_lanes(Json& data, Arrays& arrays, const ReportContent& content, std::size_t scene) {
  const ReportedScene& reported = content.scenes[scene];
  const double start = reported.inputs.start, stop = reported.result.report.reached;
  for (const std::size_t i : lanes_to_draw(reported.lanes, kMostLanes)) {
    const Lane& whole = reported.lanes[i];
    const Lane lane = whole.from.size() > content.points ? merged(whole, start, stop, content.points / 4) : whole;
    data["lanes"].push_back({{"scene", scene},
                             {"kind", static_cast<int>(lane.kind)},
                             {"name", lane.name},
                             {"text", lane_text(lane)},
                             {"on", lane.on},
                             {"off", lane.off},
                             {"stop", stop},
                             {"t", arrays.add(lane.from)},
                             {"s", arrays.add(lane.share)},
                             {"marks", arrays.add(lane.marks)}});
  }
}

Json page_data(const ReportContent& content) {
  Arrays arrays;
  Json data{{"time", "s"}, {"scenes", Json::array()}, {"outputs", outputs_of(content)}};  // model format 1: seconds
  for (const char* const kind : {"curves", "references", "energy", "lanes"}) data[kind] = Json::array();
  for (std::size_t i = 0; i < content.scenes.size(); ++i) {
    const RunInputs& inputs = content.scenes[i].inputs;
    data["scenes"].push_back({{"name", inputs.scene}, {"start", inputs.start}, {"stop", inputs.stop}});
    add_curves(data, arrays, content, i);
    add_references(data, arrays, content, i);
    add_energy(data, arrays, content.scenes[i].result.report, i);
    add_lanes(data, arrays, content, i);
  }
  data["arrays"] = arrays.texts();
  return data;
}

std::string outcome(const ReportedScene& scene) {
  const std::string reached = " at t = " + short_number(scene.result.report.reached, 6);
  switch (scene.result.stop) {
    case StopReason::completed:
      return badge(true, "completed");
    case StopReason::interrupted:
      return badge(false, "interrupted" + reached);
    case StopReason::failed:
      return badge(false, "failed" + reached);
  }
  return {};
}

std::string reference_verdict(const ReportedScene& scene) {
  if (!scene.reference) return "none";
  if (!scene.check) return "not compared: the run ended early";
  const auto& columns = scene.check->columns;
  const auto held = std::count_if(columns.begin(), columns.end(), [](const ColumnCheck& c) { return c.ok(); });
  return badge(scene.check->ok(), std::to_string(held) + " of " + std::to_string(columns.size()) + " held");
}

std::string energy_verdict(const EnergyAudit& audit) {
  return audit.done ? short_number(audit.relative, 2) : "not audited";
}

std::string summary_section(const ReportContent& content) {
  const Model& model = content.study.model();
  std::vector<Cells> rows;
  for (const ReportedScene& scene : content.scenes) {
    std::string name = xml_text(scene.inputs.scene);
    if (!scene.about.empty()) name += xml_empty("br", {}) + xml_text_element("small", scene.about);
    rows.push_back({name, outcome(scene),
                    short_number(scene.inputs.start, 6) + " to " + short_number(scene.inputs.stop, 6),
                    reference_verdict(scene), energy_verdict(scene.result.report.energy)});
  }
  std::string text = html_table({"Scene", "Run", "Time", "Reference", "Energy residual, relative"}, rows);
  for (const ReportedScene& scene : content.scenes)
    if (scene.result.failure)
      text += xml_element(
          "div", {{"class", "failure"}},
          paragraph("Scene " + xml_text_element("b", scene.inputs.scene) +
                    " did not complete. The curves end at t = " + short_number(scene.result.report.reached, 6) + ".") +
              preformatted(render(*scene.result.failure, *model.sources)));
  std::vector<Diagnostic> warnings = model.warnings;
  for (const auto* const more : {&content.study.causality().warnings, &content.study.equations().warnings})
    warnings.insert(warnings.end(), more->begin(), more->end());
  for (const ReportedScene& scene : content.scenes)
    warnings.insert(warnings.end(), scene.inputs.warnings.begin(), scene.inputs.warnings.end());
  for (const Diagnostic& warning : warnings) text += preformatted(render(warning, *model.sources), "warning");
  return html_section("summary", "Summary", text);
}

std::string drawing_section(const ReportContent& content) {
  // The script puts the links to files there.
  const std::string files = xml_element("span", {{"class", "files"}}, "");
  // Text before the element (XML declaration, document type) belongs to a file, not into a page.
  const std::string drawing = content.svg ? xml_element("div", {{"class", "drawing"}, {"tabindex", "0"}},
                                                        content.svg->substr(content.svg->find("<svg")))
                                          : note_paragraph(xml_text(content.why_no_drawing));
  return xml_element("section", {{"id", "drawing"}}, files + xml_text_element("h2", "Bond graph") + "\n" + drawing) +
         "\n";
}

/// Least and greatest value of each output, and its difference from the reference: what a plot shows, in numbers.
std::string output_table(const ReportContent& content) {
  std::vector<Cells> rows;
  for (const ReportedScene& scene : content.scenes) {
    const Trace& trace = scene.result.trace;
    for (std::size_t i = 0; i < trace.names.size(); ++i) {
      const std::vector<double>& values = trace.columns[i];
      if (values.empty()) continue;
      const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
      Cells row{xml_text(trace.names[i]),
                xml_text(scene.inputs.scene),
                xml_text(trace.units[i]),
                short_number(*least, 6),
                short_number(*greatest, 6),
                "",
                ""};
      if (scene.check)
        for (const ColumnCheck& column : scene.check->columns)
          if (column.output == trace.names[i]) {
            row[5] = short_number(column.error, 3) + " of " + short_number(column.limit, 3);
            row[6] = column.ok() ? "held" : xml_text_element("b", "missed") + " at t = " + short_number(column.time, 6);
          }
      rows.push_back(std::move(row));
    }
  }
  return html_table({"Output", "Scene", "Unit", "Least", "Greatest", "Error of limit", "Reference"}, rows, {3, 4, 5});
}

/// An empty place that the script fills.
std::string place(const char* id, const char* css_class) {
  return xml_element("div", {{"id", id}, {"class", css_class}}, "") + "\n";
}

/// Where the script draws the lanes of modes, and what is said of them.
std::string lanes_place(const ReportContent& content) {
  std::string notes;
  bool any = false;
  for (const ReportedScene& scene : content.scenes) {
    any = any || !scene.lanes.empty();
    if (scene.lanes.size() > kMostLanes)
      notes +=
          note_paragraph("Scene " + xml_text(scene.inputs.scene) + ": " + std::to_string(kMostLanes) + " of " +
                         std::to_string(scene.lanes.size()) +
                         " lanes are drawn, those first that change. bgsim run --events and bgsim plot --lane show "
                         "the others.");
  }
  if (!any) return "";
  return place("lanes", "plots wide") + notes +
         note_paragraph(
             "Lanes: filled while a switch is closed or locked, a diode conducts, a contact touches, a latch is true, "
             "friction sticks. Paler where sides change too fast to be drawn one by one: the darker, the longer the "
             "time on; zooming in parts them. Upright marks are impacts, events, jumps of stores and samples.");
}

std::string outputs_section(const ReportContent& content) {
  std::string text = xml_element("div", {{"id", "toolbar"}, {"role", "toolbar"}, {"aria-label", "All plots"}}, "") +
                     place("plots", "plots") + lanes_place(content) +
                     xml_element("noscript", note_paragraph("The plots need JavaScript, which is off here.")) + "\n";
  std::size_t longest = 0;
  for (const ReportedScene& scene : content.scenes) longest = std::max(longest, scene.result.trace.times.size());
  if (longest > content.points)
    text +=
        note_paragraph("Of " + std::to_string(longest) + " samples a curve, up to " + std::to_string(content.points) +
                       " are drawn: first, last, least and greatest of each stretch, so no extreme is lost. The "
                       "trace has them all; --points keeps more here.");
  // One output over another: the script fills it in and shows it.
  text +=
      xml_element("div", {{"id", "phase"}, {"hidden", ""}},
                  folded("One output over another (phase plot)", xml_element("div", {{"class", "phase-bar"}}, "") +
                                                                     xml_element("div", {{"id", "phase-plot"}}, ""))) +
      "\n";
  return html_section("outputs", "Outputs",
                      text + folded("Ranges and references in numbers", output_table(content), true));
}

std::string energy_section(const ReportContent& content) {
  std::string text = paragraph(
      "The energy supplied by the sources is the increase of stored energy, the energy taken by the resistors, what "
      "switches, impacts and events take or bring where there are any, and a residual, which is an error of the run. "
      "Energies are in the model's own units: joules if it is written in SI "
      "units.");
  struct Term {
    const char* name;
    double EnergyAudit::*value;
    bool always;
  };
  constexpr Term kTerms[] = {
      {"Supplied", &EnergyAudit::supplied, true},    {"Events", &EnergyAudit::events, false},
      {"Stored", &EnergyAudit::stored, true},        {"Dissipated", &EnergyAudit::dissipated, true},
      {"Switching", &EnergyAudit::switching, false}, {"Impacts", &EnergyAudit::impacts, false},
      {"Exchanged", &EnergyAudit::exchanged, true},  {"Residual", &EnergyAudit::residual, true},
      {"Relative", &EnergyAudit::relative, true}};
  std::vector<Term> terms;
  for (const Term& term : kTerms)
    if (term.always || std::any_of(content.scenes.begin(), content.scenes.end(), [&](const ReportedScene& scene) {
          return scene.result.report.energy.*term.value != 0.0;
        }))
      terms.push_back(term);
  std::vector<Cells> rows;
  for (const ReportedScene& scene : content.scenes) {
    const EnergyAudit& audit = scene.result.report.energy;
    Cells row{xml_text(scene.inputs.scene)};
    for (const Term& term : terms) row.push_back(audit.done ? short_number(audit.*term.value, 5) : "");
    if (!audit.done) row[1] = "not audited: " + xml_text(audit.why_not);
    rows.push_back(std::move(row));
  }
  Cells titles{"Scene"};
  std::vector<std::size_t> numbers;
  for (const Term& term : terms) {
    titles.emplace_back(term.name);
    numbers.push_back(titles.size() - 1);
  }
  text += html_table(titles, rows, numbers);
  for (const ReportedScene& scene : content.scenes) {
    const EnergyAudit& audit = scene.result.report.energy;
    if (audit.done && audit.least_dissipation < 0.0)
      text += note_paragraph("Scene " + xml_text(scene.inputs.scene) + ": the resistor " +
                             xml_text_element("code", audit.least_dissipation_element) +
                             " is active; it gave off up to " + short_number(-audit.least_dissipation, 4) + ".");
  }
  return html_section("energy", "Energy audit", text + place("energies", "plots"));
}

std::string head(const ReportContent& content) {
  const auto meta = [](const char* name, const char* value) {
    return xml_empty("meta", {{"name", name}, {"content", value}}) + "\n";
  };
  std::string style(raw_text(kUplotStyle, "style"));
  style.append("\n").append(raw_text(kPageStyle, "style"));
  // Before anything is drawn: light or dark, and canvases fine enough for paper (uPlot asks for the ratio).
  const char* const script =
      "document.documentElement.dataset.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : "
      "'light';\n"
      "Object.defineProperty(window, 'devicePixelRatio', { value: Math.max(2, window.devicePixelRatio) });\n";
  // The page asks nobody for anything, and the browser sees to it.
  const char* const policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";
  return xml_element("head", xml_empty("meta", {{"charset", "utf-8"}}) + "\n" +
                                 xml_empty("meta", {{"http-equiv", "Content-Security-Policy"}, {"content", policy}}) +
                                 "\n" + meta("viewport", "width=device-width, initial-scale=1") +
                                 meta("color-scheme", "light dark") +
                                 xml_text_element("title", content.study.model().name + " - bgsim report") + "\n" +
                                 xml_empty("link", {{"rel", "icon"}, {"href", "data:,"}}) + "\n" +
                                 xml_element("style", style) + "\n" + xml_element("script", script)) +
         "\n";
}

std::string header(const Model& model) {
  std::string text = xml_text_element("h1", model.name);
  if (!model.about.empty()) text += xml_text_element("p", model.about);
  return xml_element("header", text) + "\n";
}

std::string navigation(const ReportContent& content) {
  const auto is_empty = [&](std::string_view id) {
    return (id == "parameters" && content.study.model().parameters.empty()) ||
           (id == "studies" && content.studies.empty());
  };
  std::string links;
  for (const Section& section : kSections)
    if (!is_empty(section.id)) links += xml_element("a", {{"href", std::string("#") + section.id}}, section.title);
  const std::string theme = xml_element("button", {{"type", "button"}, {"id", "theme"}, {"hidden", ""}}, "Theme");
  return xml_element("nav", {{"aria-label", "Sections"}}, xml_element("div", links) + theme) + "\n";
}

std::string scripts(const ReportContent& content) {
  const std::string license = "/*\n" + std::string(kUplotLicense) + "*/\n";
  return xml_element("script", {{"type", "application/json"}, {"id", "data"}}, script_json(page_data(content))) + "\n" +
         xml_element("script", license + std::string(raw_text(kUplotScript, "script"))) + "\n" +
         xml_element("script", raw_text(kPageScript, "script")) + "\n";
}

}  // namespace

std::string report_page(const ReportContent& content) {
  const Model& model = content.study.model();
  const std::string sections = summary_section(content) + drawing_section(content) + outputs_section(content) +
                               energy_section(content) + causality_section(content) + parameters_section(content) +
                               equations_section(content) + activity_section(content) + studies_section(content) +
                               statistics_section(content) + reproduction_section(content);
  const std::string body =
      xml_element("a", {{"class", "skip"}, {"href", "#main"}}, "To the content") + "\n" + header(model) +
      navigation(content) + xml_element("main", {{"id", "main"}}, "\n" + sections) + "\n" +
      xml_element("footer",
                  "Made by bgsim " + xml_text(content.version) + ", " + xml_text(content.date) + ". Plots by uPlot.") +
      "\n" + scripts(content);
  return "<!DOCTYPE html>\n" +
         xml_element("html", {{"lang", "en"}}, head(content) + xml_element("body", "\n" + body) + "\n") + "\n";
}

}  // namespace bgsim::cli
