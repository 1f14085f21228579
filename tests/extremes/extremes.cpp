#include "extremes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <utility>

#include "support/files.hpp"
#include "support/test_of_each.hpp"

namespace bgsim::test {

namespace {

const char* const kPath = BGSIM_SOURCE_DIR "/docs/extremes.md";

const char* const kHead =
    R"(<!-- Written by the suite tests/extremes: BGSIM_UPDATE_GOLDEN=1 build/dev/tests/test_extremes. Do not edit. -->

# Extreme models

Models that break simulators, and the result with bgsim: correct within a stated tolerance, or an error message with
names, time and fix. Each row is a test of the suite `tests/extremes`, which runs it, checks it and writes this table;
errors are rounded up to a power of ten, times and values in messages to three digits, so that they do not depend
on a machine's last bits. Unless a row says otherwise, runs have the default relative tolerance 1e-6 and method.
Statements on plain CVODE, with the same equations, are measured by `scripts/bench plain-cvode`
([plain-cvode.md](plain-cvode.md)).

)";

/// Headings in the document's order.
const char* const kTitles[] = {"Sources",          "Values and units", "Laws at the limits of their domain",
                               "Loops and starts", "Conditions",       "Time, size and tolerance"};

/// The rows by heading, as the sources of the suite register them.
std::map<std::string, std::vector<Extreme>>& table() {
  static std::map<std::string, std::vector<Extreme>> rows;
  return rows;
}

std::string cell(const std::string& text) { return std::regex_replace(text, std::regex("\\|"), "\\|"); }

/// What a row begins with, whatever the result is.
std::string beginning(const Extreme& row) { return "| " + cell(row.input) + " | " + cell(row.must) + " | "; }

/// The row in the document; empty if it is not there.
std::string written(const std::string& document, const std::string& title, const Extreme& row) {
  const auto section = document.find("## " + title + "\n");
  if (section == std::string::npos) return {};
  const auto begin = document.find("\n" + beginning(row), section);
  if (begin == std::string::npos || begin > document.find("\n## ", section)) return {};
  return document.substr(begin + 1, document.find('\n', begin + 1) - begin);
}

/// The document as the suite has it, with the results that @p document has; @p result is that of the row @p of.
std::string rewritten(const std::string& document, const Extreme* of = nullptr, const std::string& result = {}) {
  std::string text = kHead;
  for (const char* const title : kTitles) {
    text += std::string("## ") + title + "\n\n| input | required result, and why | result of bgsim |\n|---|---|---|\n";
    for (const Extreme& row : table().at(title)) text += &row == of ? result : written(document, title, row);
    text += "\n";
  }
  return text;
}

void check_row(const std::string& title, const Extreme& row) {
  INFO(row.input);
  const std::string result = beginning(row) + cell(row.does()) + " |\n";
  if (update_goldens()) write_file(kPath, rewritten(file_text(kPath), &row, result));
  CHECK(written(file_text(kPath), title, row) == result);
}

/// Numbers with more than three digits cut to three.
std::string rounded(const std::string& text) {
  static const std::regex number(R"(-?\b\d+(\.\d+)?(e[-+]?\d+)?\b)");
  std::string result;
  auto at = text.cbegin();
  for (std::sregex_iterator i(text.begin(), text.end(), number), end; i != end; ++i) {
    result.append(at, (*i)[0].first);
    char shown[40];
    std::snprintf(shown, sizeof shown, "%.3g", std::stod(i->str()));
    result += shown;
    at = (*i)[0].second;
  }
  return result.append(at, text.cend());
}

std::optional<Diagnostic> first_error(const ModelError& error) {
  for (const Diagnostic& diagnostic : error.diagnostics)
    if (diagnostic.severity == Severity::error) return diagnostic;
  return std::nullopt;
}

}  // namespace

Section::Section(std::string title, std::vector<Extreme> rows, const Catch::SourceLineInfo& where) {
  const std::vector<Extreme>& kept = table().emplace(title, std::move(rows)).first->second;
  for (const Extreme& row : kept)
    add_test(
        title + ": " + row.input, [title, &row] { check_row(title, row); }, row.tags, where);
}

TEST_CASE("docs/extremes.md holds the rows of the suite and nothing else") {
  CHECK(table().size() == std::size(kTitles));
  const std::string document = file_text(kPath);
  for (const char* const title : kTitles)
    for (const Extreme& row : table().at(title))
      CHECK((written(document, title, row).empty() ? row.input + " is missing" : row.input) == row.input);
  CHECK(document == rewritten(document));
}

std::string Ran::note(const std::string& containing) const {
  for (const std::string& note : result->report.notes)
    if (note.find(containing) != std::string::npos) return note;
  return {};
}

Ran ran(const CompiledModel& compiled) {
  Ran outcome;
  outcome.warnings = compiled.inputs.warnings;
  outcome.warnings.insert(outcome.warnings.end(), compiled.system().warnings.begin(), compiled.system().warnings.end());
  try {
    outcome.result = compiled.run();
  } catch (const ModelError& error) {
    outcome.said = first_error(error);
    return outcome;
  }
  outcome.said = outcome.result->failure;
  for (const std::vector<double>& values : outcome.result->trace.columns)
    CHECK(std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }));
  return outcome;
}

Ran ran(const std::string& text, const SceneOverrides& overrides, const std::string& scene) {
  std::optional<CompiledModel> compiled;
  try {
    compiled = compile_text(text, overrides, scene);
  } catch (const ModelError& error) {
    Ran outcome;
    outcome.said = first_error(error);
    return outcome;
  }
  return ran(*compiled);
}

std::string within(double error, double limit) {
  CHECK(error <= limit);
  if (error == 0.0) return "exact";
  constexpr double kRounding = 1e-12;  // below this the last bits decide
  char text[40];
  std::snprintf(text, sizeof text, "%.0e", std::pow(10.0, std::ceil(std::log10(std::max(error, kRounding)))));
  return std::string("error below ") + text;
}

std::string diagnosis(const Ran& ran, const std::string& code, const std::vector<std::string>& words) {
  REQUIRE(ran.said);
  CHECK(ran.said->code == code);
  std::string all = ran.said->situation;
  for (const Note& note : ran.said->notes) all += "\n" + note.text;
  for (const std::string& word : words) {
    INFO(all);
    CHECK(all.find(word) != std::string::npos);
  }
  CHECK((!ran.said->help.empty() || !ran.said->rule.empty()));
  return "[" + ran.said->code + "](errors.md#bg" + ran.said->code.substr(2) + "): " + rounded(ran.said->situation);
}

std::string model_of(const std::string& elements, const std::string& bonds, const std::string& outputs,
                     const std::string& scene) {
  std::string list;
  std::istringstream in(bonds);
  for (std::string bond; in >> bond;) {
    const auto arrow = bond.find('>');
    list += (list.empty() ? "" : ", ") + std::string("{ \"from\": \"") + bond.substr(0, arrow) + "\", \"to\": \"" +
            bond.substr(arrow + 1) + "\" }";
  }
  return R"({ "bgsim": 1, "name": "extreme", "elements": { )" + elements + " }, \"bonds\": [ " + list +
         " ], \"outputs\": { " + outputs + " }, \"scenes\": { \"main\": { " + scene + " } } }";
}

std::string charging(const std::string& effort, const std::string& resistance, const std::string& capacitance,
                     const std::string& scene, const std::string& initial) {
  return model_of(R"("source": { "kind": "Se", "effort": ")" + effort +
                      R"(" }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": ")" + resistance +
                      R"(" }, "c": { "kind": "C", "capacitance": ")" + capacitance + "\"" +
                      (initial.empty() ? "" : ", \"initial\": { \"q\": " + initial + " }") + " }",
                  "source>loop loop>r loop>c", R"("q": "c.q", "u": "c.e", "i": "r.f")", scene);
}

std::string filling(const std::string& flow, const std::string& initial, const std::string& scene) {
  return model_of(R"("source": { "kind": "MSf", "flow": ")" + flow +
                      R"(" }, "tank": { "kind": "0" }, "store": { "kind": "C", "capacitance": 1, "initial": { "q": )" +
                      initial + " } }",
                  "source>tank tank>store", R"("q": "store.q")", scene);
}

std::string oscillator(const std::string& inertance, const std::string& capacitance, const std::string& initial,
                       const std::string& scene) {
  return model_of(R"("loop": { "kind": "1" }, "l": { "kind": "I", "inertance": )" + inertance +
                      R"( }, "c": { "kind": "C", "capacitance": )" + capacitance + R"(, "initial": { "q": )" + initial +
                      " } }",
                  "loop>l c>loop", R"("q": "c.q", "p": "l.p", "i": "l.f")", scene);
}

}  // namespace bgsim::test
