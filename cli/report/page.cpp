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
constexpr Section kSections[] = {{"summary", "Summary"},     {"drawing", "Bond graph"},  {"outputs", "Outputs"},
                                 {"energy", "Energy"},       {"causality", "Causality"}, {"parameters", "Parameters"},
                                 {"equations", "Equations"}, {"activity", "Activity"},   {"statistics", "Statistics"},
                                 {"reproduce", "Reproduce"}};

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

Json page_data(const ReportContent& content) {
  Arrays arrays;
  Json data{{"time", "s"}, {"scenes", Json::array()}, {"outputs", outputs_of(content)}};  // model format 1: seconds
  for (const char* const kind : {"curves", "references", "energy"}) data[kind] = Json::array();
  for (std::size_t i = 0; i < content.scenes.size(); ++i) {
    const RunInputs& inputs = content.scenes[i].inputs;
    data["scenes"].push_back({{"name", inputs.scene}, {"start", inputs.start}, {"stop", inputs.stop}});
    add_curves(data, arrays, content, i);
    add_references(data, arrays, content, i);
    add_energy(data, arrays, content.scenes[i].result.report, i);
  }
  data["arrays"] = arrays.texts();
  return data;
}

std::string outcome(const ReportedScene& scene) {
  const auto badge = [](const char* kind, const std::string& text) {
    return std::string("<span class=\"badge ") + kind + "\">" + xml_text(text) + "</span>";
  };
  const std::string reached = " at t = " + short_number(scene.result.report.reached, 6);
  switch (scene.result.stop) {
    case StopReason::completed:
      return badge("good", "completed");
    case StopReason::interrupted:
      return badge("bad", "interrupted" + reached);
    case StopReason::failed:
      return badge("bad", "failed" + reached);
  }
  return {};
}

std::string reference_verdict(const ReportedScene& scene) {
  if (!scene.reference) return "none";
  if (!scene.check) return "not compared: the run ended early";
  const auto& columns = scene.check->columns;
  const auto held = std::count_if(columns.begin(), columns.end(), [](const ColumnCheck& c) { return c.ok(); });
  const std::string text = std::to_string(held) + " of " + std::to_string(columns.size()) + " held";
  return std::string("<span class=\"badge ") + (scene.check->ok() ? "good" : "bad") + "\">" + text + "</span>";
}

std::string energy_verdict(const EnergyAudit& audit) {
  return audit.done ? short_number(audit.relative, 2) : "not audited";
}

std::string summary_section(const ReportContent& content) {
  const Model& model = content.study.model();
  std::string text = "<section id=\"summary\"><h2>Summary</h2>\n";
  std::vector<Cells> rows;
  for (const ReportedScene& scene : content.scenes) {
    std::string name = xml_text(scene.inputs.scene);
    if (!scene.about.empty()) name += "<br><small>" + xml_text(scene.about) + "</small>";
    rows.push_back({name, outcome(scene),
                    short_number(scene.inputs.start, 6) + " to " + short_number(scene.inputs.stop, 6),
                    reference_verdict(scene), energy_verdict(scene.result.report.energy)});
  }
  text += html_table({"Scene", "Run", "Time", "Reference", "Energy residual, relative"}, rows);
  for (const ReportedScene& scene : content.scenes)
    if (scene.result.failure)
      text += "<div class=\"failure\"><p>Scene <b>" + xml_text(scene.inputs.scene) +
              "</b> did not complete. The curves end at t = " + short_number(scene.result.report.reached, 6) +
              ".</p><pre tabindex=\"0\">" + xml_text(render(*scene.result.failure, *model.sources)) + "</pre></div>\n";
  std::vector<Diagnostic> warnings = model.warnings;
  for (const auto* const more : {&content.study.causality().warnings, &content.study.equations().warnings})
    warnings.insert(warnings.end(), more->begin(), more->end());
  for (const ReportedScene& scene : content.scenes)
    warnings.insert(warnings.end(), scene.inputs.warnings.begin(), scene.inputs.warnings.end());
  for (const Diagnostic& warning : warnings)
    text += "<pre class=\"warning\" tabindex=\"0\">" + xml_text(render(warning, *model.sources)) + "</pre>\n";
  return text + "</section>\n";
}

std::string drawing_section(const ReportContent& content) {
  std::string text = "<section id=\"drawing\"><span class=\"files\"></span><h2>Bond graph</h2>\n";
  if (!content.svg) return text + "<p class=\"note\">" + xml_text(content.why_no_drawing) + "</p>\n</section>\n";
  // Text before the element (XML declaration, document type) belongs to a file, not into a page.
  return text + "<div class=\"drawing\" tabindex=\"0\">" + content.svg->substr(content.svg->find("<svg")) +
         "</div>\n</section>\n";
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
            row[6] = column.ok() ? "held" : "<b>missed</b> at t = " + short_number(column.time, 6);
          }
      rows.push_back(std::move(row));
    }
  }
  return html_table({"Output", "Scene", "Unit", "Least", "Greatest", "Error of limit", "Reference"}, rows, {3, 4, 5});
}

std::string outputs_section(const ReportContent& content) {
  std::string text =
      "<section id=\"outputs\"><h2>Outputs</h2>\n<div id=\"toolbar\" role=\"toolbar\" "
      "aria-label=\"All plots\"></div>\n<div id=\"plots\" class=\"plots\"></div>\n"
      "<noscript><p class=\"note\">The plots need JavaScript, which is off here.</p></noscript>\n";
  std::size_t longest = 0;
  for (const ReportedScene& scene : content.scenes) longest = std::max(longest, scene.result.trace.times.size());
  if (longest > content.points)
    text += "<p class=\"note\">Of " + std::to_string(longest) + " samples a curve, up to " +
            std::to_string(content.points) +
            " are drawn: first, last, least and greatest of each stretch, so no "
            "extreme is lost. The trace has them all; --points keeps more here.</p>\n";
  // One output over another: the script fills it in and shows it.
  text +=
      "<div id=\"phase\" hidden><details><summary>One output over another (phase plot)</summary>\n"
      "<div class=\"phase-bar\"></div><div id=\"phase-plot\"></div></details></div>\n";
  return text + "<details open><summary>Ranges and references in numbers</summary>\n" + output_table(content) +
         "</details>\n</section>\n";
}

std::string energy_section(const ReportContent& content) {
  std::string text =
      "<section id=\"energy\"><h2>Energy audit</h2>\n<p>The energy supplied by the sources is the increase of "
      "stored energy, the energy taken by the resistors, and a residual, which is an error of the "
      "run. Energies are in the model's own units: joules if it is written in SI units.</p>\n";
  std::vector<Cells> rows;
  for (const ReportedScene& scene : content.scenes) {
    const EnergyAudit& audit = scene.result.report.energy;
    if (!audit.done) {
      rows.push_back({xml_text(scene.inputs.scene), "not audited: " + xml_text(audit.why_not), "", "", "", "", ""});
      continue;
    }
    Cells row{xml_text(scene.inputs.scene)};
    for (const double term :
         {audit.supplied, audit.stored, audit.dissipated, audit.exchanged, audit.residual, audit.relative})
      row.push_back(short_number(term, 5));
    rows.push_back(std::move(row));
  }
  text += html_table({"Scene", "Supplied", "Stored", "Dissipated", "Exchanged", "Residual", "Relative"}, rows,
                     {1, 2, 3, 4, 5, 6});
  for (const ReportedScene& scene : content.scenes) {
    const EnergyAudit& audit = scene.result.report.energy;
    if (audit.done && audit.least_dissipation < 0.0)
      text += "<p class=\"note\">Scene " + xml_text(scene.inputs.scene) + ": the resistor <code>" +
              xml_text(audit.least_dissipation_element) + "</code> is active; it gave off up to " +
              short_number(-audit.least_dissipation, 4) + ".</p>\n";
  }
  return text + "<div id=\"energies\" class=\"plots\"></div>\n</section>\n";
}

std::string head(const ReportContent& content) {
  std::string text =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      // The page asks nobody for anything, and the browser sees to it.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data:\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
      xml_text(content.study.model().name) + " - bgsim report</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>";
  text.append(raw_text(kUplotStyle, "style")).append("\n").append(raw_text(kPageStyle, "style"));
  // Before anything is drawn: light or dark, and canvases fine enough for paper (uPlot asks for the ratio).
  return text + "</style>\n<script>\n" +
         "document.documentElement.dataset.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : "
         "'light';\n"
         "Object.defineProperty(window, 'devicePixelRatio', { value: Math.max(2, window.devicePixelRatio) });\n" +
         "</script>\n</head>\n";
}

std::string body_begin(const ReportContent& content) {
  const Model& model = content.study.model();
  std::string text =
      "<body>\n<a class=\"skip\" href=\"#main\">To the content</a>\n<header><h1>" + xml_text(model.name) + "</h1>\n";
  if (!model.about.empty()) text += xml_text_element("p", model.about) + "\n";
  text += "</header>\n<nav aria-label=\"Sections\"><div>";
  for (const Section& section : kSections)
    if (!model.parameters.empty() || section.id != std::string_view("parameters"))
      text += std::string("<a href=\"#") + section.id + "\">" + section.title + "</a>";
  return text + "</div><button type=\"button\" id=\"theme\" hidden>Theme</button></nav>\n<main id=\"main\">\n";
}

std::string scripts(const ReportContent& content) {
  std::string text = "<script type=\"application/json\" id=\"data\">" + script_json(page_data(content)) + "</script>\n";
  text.append("<script>/*\n").append(kUplotLicense).append("*/\n");
  text.append(raw_text(kUplotScript, "script")).append("</script>\n<script>");
  text.append(raw_text(kPageScript, "script")).append("</script>\n");
  return text;
}

}  // namespace

std::string report_page(const ReportContent& content) {
  std::string page = head(content) + body_begin(content);
  page += summary_section(content) + drawing_section(content) + outputs_section(content) + energy_section(content);
  page += causality_section(content) + parameters_section(content) + equations_section(content);
  page += activity_section(content) + statistics_section(content) + reproduction_section(content);
  page += "</main>\n<footer>Made by bgsim " + xml_text(content.version) + ", " + xml_text(content.date) +
          ". Plots by uPlot.</footer>\n";
  return page + scripts(content) + "</body>\n</html>\n";
}

}  // namespace bgsim::cli
