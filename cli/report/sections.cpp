// The sections of a report that are words, tables and formulas.
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "bgsim/modes.hpp"
#include "bgsim/xml.hpp"
#include "html.hpp"
#include "report/content.hpp"
#include "shell_word.hpp"

namespace bgsim::cli {

namespace {

using Cells = std::vector<std::string>;

std::string code(std::string_view text) { return xml_text_element("code", text); }

/// A separate text begins with a capital.
std::string capital(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

Cells scene_names(const ReportContent& content) {
  Cells names;
  for (const ReportedScene& scene : content.scenes) names.push_back(xml_text(scene.inputs.scene));
  return names;
}

/// What differs from scene to scene, in as few words as that takes.
std::string by_scene(const ReportContent& content, const std::vector<std::string>& texts) {
  std::vector<std::pair<std::string, std::string>> distinct;  // text, scenes
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto known =
        std::find_if(distinct.begin(), distinct.end(), [&](const auto& entry) { return entry.first == texts[i]; });
    const std::string& scene = content.scenes[i].inputs.scene;
    if (known == distinct.end())
      distinct.emplace_back(texts[i], scene);
    else
      known->second += ", " + scene;
  }
  if (distinct.size() == 1) return xml_text(texts.front());
  std::string cell;
  for (const auto& [text, scenes] : distinct)
    cell +=
        xml_element("span", {{"class", "of-scene"}}, xml_text(text) + " " + xml_text_element("small", "in " + scenes));
  return cell;
}

std::string file_and_line(const Model& model, const Place& place) {
  const auto [path, text] = source_texts(*model.sources)[place.document.index()];
  const std::string_view before = text.substr(0, place.begin);
  return std::string(path.substr(path.rfind('/') + 1)) + ":" + std::to_string(1 + std::ranges::count(before, '\n'));
}

}  // namespace

std::string short_number(double value, int digits) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string causality_section(const ReportContent& content) {
  const Study& study = content.study;
  const Model& model = study.model();
  std::string text;
  for (const Finding& finding : causal_findings(model, study.graph(), study.causality())) {
    if (finding.rows.empty()) {
      text += paragraph(xml_text(capital(finding.heading)));
      continue;
    }
    std::string rows;
    for (const auto& [left, right] : finding.rows)
      rows += xml_element("tr", xml_element("td", code(left)) + xml_text_element("td", right)) + "\n";
    std::string table = scrolling(xml_element("table", {{"class", "plain"}}, xml_element("tbody", rows))) + "\n";
    if (finding.more > 0)
      table += paragraph("... and " + std::to_string(finding.more) +
                         " more: " + code("bgsim show --stage causality " + content.file));
    const std::size_t count = finding.rows.size() + finding.more;
    text += folded(xml_text(capital(finding.heading) + " (" + std::to_string(count) + ")"), table,
                   finding.heading.rfind("strokes", 0) != 0);
  }
  const std::vector<std::string> loops = lines_of(describe_loops(model, study.equations(), study.order()));
  text += paragraph(xml_text(capital(loops.front())));
  for (std::size_t i = 1; i < loops.size(); ++i)
    text += xml_element("p", {{"class", "indented"}}, xml_text(loops[i])) + "\n";
  return html_section("causality", "Causality", text);
}

std::string parameters_section(const ReportContent& content) {
  const Model& model = content.study.model();
  if (model.parameters.empty()) return {};
  const auto name = [&](SymbolId symbol) { return symbol_name(model, symbol); };
  std::vector<Cells> rows;
  std::map<std::string, std::vector<Cells>> by_submodel;  // at the top
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    const Parameter& parameter = model.parameters[i];
    std::vector<std::string> values;
    for (const ReportedScene& scene : content.scenes) values.push_back(short_number(scene.inputs.parameters[i], 10));
    std::string value = by_scene(content, values);
    if (!model.pool.is_constant(parameter.value))
      value += " " + xml_element("small", "= " + code(readable_text(model.pool, parameter.value, name)));
    const std::size_t dot = parameter.name.find('.');
    auto& place = dot == std::string::npos ? rows : by_submodel[parameter.name.substr(0, dot)];
    place.push_back({code(parameter.name), value, xml_text(parameter.unit), xml_text(parameter.about),
                     code(file_and_line(model, parameter.place))});
  }
  std::string text;
  if (!model.source.empty()) text += paragraph("Source: " + xml_text(model.source));
  const std::vector<std::string> titles{"Name", "Value", "Unit", "Meaning", "Given in"};
  if (!rows.empty()) text += html_table(titles, rows);
  for (const auto& [submodel, inside] : by_submodel)
    text += folded("Submodel " + code(submodel) + ": " + std::to_string(inside.size()) +
                       (inside.size() == 1 ? " parameter" : " parameters"),
                   html_table(titles, inside));
  return html_section("parameters", "Parameters", text);
}

std::string equations_section(const ReportContent& content) {
  constexpr std::size_t kMostStates = 500;
  const Study& study = content.study;
  const auto section = [](const std::string& inside) { return html_section("equations", "State equations", inside); };
  if (study.equations().states.size() > kMostStates)
    return section(paragraph(std::to_string(study.equations().states.size()) +
                             " equations are too many to be read here: " + code("bgsim equations " + content.file) +
                             " prints them."));
  const auto formula = [](const std::string& inside) {
    return xml_element("math", {{"displaystyle", "true"}}, inside);
  };
  std::string text;
  if (const Mode mode = mode_of(study.model()); !mode.empty())
    text += paragraph("In the mode " + xml_text(mode_text(study.model(), mode)) + ". " +
                      code("bgsim equations " + content.file + " --mode NAME=SIDE") + " prints those of others.");
  for (const EquationGroup& group : equations_mathml(study.model(), study.equations(), study.order())) {
    if (group.title != "state equations") text += xml_text_element("h3", capital(group.title));
    std::string lines;
    for (const EquationLine& line : group.lines) {
      std::string right = formula(xml_element("mo", "=") + line.right.front());
      for (std::size_t i = 1; i < line.right.size(); ++i) right += " " + formula(line.right[i]);
      lines += xml_element("div", {{"class", "left"}}, formula(line.left)) +
               xml_element("div", {{"class", "right"}, {"tabindex", "0"}}, right) + "\n";
    }
    text += xml_element("div", {{"class", "equations"}}, "\n" + lines) + "\n";
  }
  return section(text);
}

namespace {

std::string share_bar(double share) {
  constexpr double kLeast = 1e-4;  // below that the digits of a percentage say nothing
  const std::string text = share > 0.0 && share < kLeast ? "&lt; 0.01" : short_number(100.0 * share, 3);
  const std::string filled = xml_element("i", {{"style", "width:" + short_number(100.0 * share, 3) + "%"}}, "");
  return xml_element("span", {{"class", "bar"}}, filled) + text + "&nbsp;%";
}

}  // namespace

std::string activity_section(const ReportContent& content) {
  constexpr std::size_t kMostRows = 60;
  const Model& model = content.study.model();
  const auto section = [](const std::string& inside) {
    return html_section("activity", "Activity of the elements", inside);
  };
  std::string text = paragraph(
      "Activity is the integral of |power| over the scene: how much energy an element turned over, whichever way it "
      "went. What has little of it contributes little to the motion (" +
      code("bgsim reduce") + ").");
  std::vector<ElementId> order;
  std::map<ElementId, std::vector<const ElementActivity*>> by_element;
  for (std::size_t i = 0; i < content.scenes.size(); ++i)
    for (const ElementActivity& row : content.scenes[i].activity) {
      auto& cells = by_element[row.element];
      if (cells.empty()) order.push_back(row.element);
      cells.resize(content.scenes.size());
      cells[i] = &row;
    }
  if (order.empty()) return section(text + paragraph("No element of this model has one, or no run was audited."));
  Cells header{"Element", "Kind"};
  std::vector<std::size_t> numeric;
  for (const std::string& scene : scene_names(content)) {
    numeric.push_back(header.size());
    header.insert(header.end(), {scene, "share"});
  }
  std::vector<Cells> rows;
  for (std::size_t i = 0; i < std::min(order.size(), kMostRows); ++i) {
    const Element& element = model.elements[order[i].index()];
    Cells row{code(element.name), xml_text(kind_text(element.kind, element.modulated))};
    for (const ElementActivity* const activity : by_element[order[i]]) {
      row.push_back(activity != nullptr ? short_number(activity->activity, 4) : "");
      row.push_back(share_bar(activity != nullptr ? activity->share : 0.0));
    }
    rows.push_back(std::move(row));
  }
  text += html_table(header, rows, numeric);
  if (order.size() > kMostRows) text += paragraph("... and " + std::to_string(order.size() - kMostRows) + " more.");
  return section(text);
}

namespace {

struct Statistic {
  const char* name;
  std::string (*text)(const ReportedScene&);
};

std::string count(std::uint64_t n) { return std::to_string(n); }

std::string tolerances(const ReportedScene& scene) {
  const RunReport& report = scene.result.report;
  if (report.step > 0.0) return "step " + short_number(report.step, 6);
  std::string text = "relative " + short_number(report.relative, 3);
  if (report.absolute.empty()) return text;
  const auto by_size = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto [least, most] = std::minmax_element(report.absolute.begin(), report.absolute.end(), by_size);
  text += ", absolute " + short_number(least->second, 3);
  if (most->second != least->second) text += " to " + short_number(most->second, 3);
  return text;
}

const Statistic kStatistics[] = {
    {"Method", [](const ReportedScene& s) { return s.result.report.method; }},
    {"Chosen since", [](const ReportedScene& s) { return s.result.report.method_reason; }},
    {"Tolerance", tolerances},
    {"States", [](const ReportedScene& s) { return count(s.result.report.states); }},
    {"Algebraic loops", [](const ReportedScene& s) { return count(s.result.report.loops); }},
    {"Variables of loops", [](const ReportedScene& s) { return count(s.result.report.algebraic); }},
    {"Output times", [](const ReportedScene& s) { return count(s.result.rows); }},
    {"Steps", [](const ReportedScene& s) { return count(s.result.report.steps); }},
    {"Steps tried again: error test",
     [](const ReportedScene& s) { return count(s.result.report.error_test_failures); }},
    {"Steps tried again: convergence",
     [](const ReportedScene& s) { return count(s.result.report.convergence_failures); }},
    {"Evaluations of the rates", [](const ReportedScene& s) { return count(s.result.report.rate_evaluations); }},
    {"Evaluations of the Jacobian", [](const ReportedScene& s) { return count(s.result.report.jacobian_evaluations); }},
    {"Factorizations", [](const ReportedScene& s) { return count(s.result.report.factorizations); }},
    {"Newton iterations", [](const ReportedScene& s) { return count(s.result.report.nonlinear_iterations); }},
    {"Iterations of loops", [](const ReportedScene& s) { return count(s.result.report.loop_iterations); }},
    {"Events at known times", [](const ReportedScene& s) { return count(s.result.report.time_events); }},
    {"Events by conditions", [](const ReportedScene& s) { return count(s.result.report.state_events); }},
};

/// Wall time by stage; blank for a stage that a scene does not have: of two scenes one may need a second run.
void add_stage_times(std::vector<Cells>& rows, const ReportContent& content) {
  std::vector<std::string> stages;
  for (const ReportedScene& scene : content.scenes)
    for (const auto& [stage, seconds] : scene.result.report.stage_seconds)
      if (std::find(stages.begin(), stages.end(), stage) == stages.end()) stages.push_back(stage);
  for (const std::string& stage : stages) {
    Cells row{"Wall time: " + xml_text(stage)};
    for (const ReportedScene& scene : content.scenes) {
      const auto& own = scene.result.report.stage_seconds;
      const auto found = std::find_if(own.begin(), own.end(), [&](const auto& entry) { return entry.first == stage; });
      row.push_back(found == own.end() ? "" : short_number(1e3 * found->second, 3) + " ms");
    }
    rows.push_back(std::move(row));
  }
}

}  // namespace

std::string statistics_section(const ReportContent& content) {
  Cells header = scene_names(content);
  header.insert(header.begin(), "");
  std::vector<Cells> rows;
  for (const Statistic& statistic : kStatistics) {
    Cells row{xml_text(statistic.name)};
    for (const ReportedScene& scene : content.scenes) row.push_back(xml_text(statistic.text(scene)));
    rows.push_back(std::move(row));
  }
  add_stage_times(rows, content);
  std::string text = html_table(header, rows);
  for (const ReportedScene& scene : content.scenes)
    for (const std::string& note : scene.result.report.notes)
      text += note_paragraph(xml_text_element("b", scene.inputs.scene + ":") + " " + xml_text(note));
  return html_section("statistics", "Run statistics", text);
}

namespace {

std::string command_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_word(word);
  return line;
}

std::string state_name(const Model& model, const RunInputs::Initial& initial) {
  if (initial.signal.valid()) return model.signals[initial.signal.index()].name;
  const Element& store = model.elements[initial.element.index()];
  return port_name(store, initial.port) + (stores_displacement(store, initial.port) ? ".q" : ".p");
}

std::string settings_of(const ReportContent& content, const ReportedScene& scene) {
  const RunInputs& inputs = scene.inputs;
  std::string text = "t from " + short_number(inputs.start, 10) + " to " + short_number(inputs.stop, 17) + ", " +
                     std::to_string(inputs.output_times.size()) + " output times, method " +
                     method_name(inputs.method) + ", relative tolerance " + short_number(inputs.relative, 6);
  if (inputs.reference) text += ", reference " + inputs.reference->file;
  for (const RunInputs::Initial& initial : inputs.initial) {
    text += "; " + state_name(content.study.model(), initial) + " begins at " + short_number(initial.value, 10);
  }
  return text;
}

}  // namespace

std::string reproduction_section(const ReportContent& content) {
  constexpr std::size_t kLongestSource = 1U << 18U;
  std::string lines;
  for (const ReportedScene& scene : content.scenes) {
    std::vector<std::string> words{"bgsim", content.file, "--scene", scene.inputs.scene, "--keep-all"};
    words.insert(words.end(), content.settings.begin(), content.settings.end());
    lines += command_line(words) + "\n";
  }
  std::string settings;
  for (const ReportedScene& scene : content.scenes)
    settings += xml_text_element("dt", scene.inputs.scene) + xml_text_element("dd", settings_of(content, scene)) + "\n";
  std::string text = paragraph("bgsim " + xml_text(content.version) + ", " + xml_text(content.date) + ":") +
                     preformatted(command_line(content.command)) + paragraph("One scene's trace alone, as CSV:") +
                     preformatted(lines) + xml_element("dl", "\n" + settings) + "\n" +
                     paragraph("The model as it was read:");
  for (const auto& [path, file] : source_texts(*content.study.model().sources)) {
    const std::string inside = file.size() <= kLongestSource
                                   ? preformatted(file)
                                   : paragraph("Too long to be shown: " + std::to_string(file.size()) + " bytes.");
    text += folded(xml_text(path), inside);
  }
  return html_section("reproduce", "How to reproduce it", text);
}

}  // namespace bgsim::cli
