// Every failing model in this folder against its golden message, each a test of its own, and every code against its
// section in docs/errors.md.
//
//   BGnnn_what.json   the model; files without BG in front are submodels and data that these need
//   BGnnn_what.txt    what the command line prints, the paths being bare file names
//   BGnnn_what.args   options, one a line: --set NAME=EXPR, --scene NAME, --relative X, --max-steps N, --interrupt,
//                     --time-limit SECONDS, --tick SECONDS (by which the clock goes on at each look);
//                     --parameters FILE, --stop EXPR, --record NAME, --output NAME=EXPR;
//                     BG71x, which are reduced: --error X, --keep NAME
//
// BGSIM_UPDATE_GOLDEN=1 in the environment rewrites the messages; the difference is then to be reviewed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "bgsim/bgsim.hpp"
#include "bgsim/input_file.hpp"
#include "failing_models.hpp"
#include "run/clock.hpp"
#include "support/files.hpp"
#include "support/test_of_each.hpp"

namespace {

namespace fs = std::filesystem;
using namespace bgsim;

const fs::path kSource = BGSIM_SOURCE_DIR;

/// Codes without a failing model, and why.
const std::map<std::string, std::string> kWithoutModel{
    {"BG100", "there is no file to be read"},
    {"BG104", "the file would be larger than 4 GiB"},
    {"BG105", "the message follows 100 others; tested in tests/unit/read_model_test.cpp"},
    {"BG406", "no run linearizes; tested in tests/unit/linearize_test.cpp"},
    {"BG407", "no run linearizes; tested in tests/unit/linearize_test.cpp"},
    {"BG408", "no run linearizes; tested in tests/physics/linear_test.cpp"},
    {"BG409", "no run looks for poles; tested in tests/physics/linear_test.cpp"},
    {"BG410", "no run looks for zeros; tested in tests/physics/linear_test.cpp"},
    {"BG412", "no run looks for a steady state; tested in tests/physics/steady_test.cpp"},
    {"BG413", "no run asks for sensitivities; tested in tests/cli/sensitivity.cpp"},
    {"BG414", "no run asks for sensitivities; tested in tests/physics/sensitivity_test.cpp"},
    {"BG415", "no run is fitted; tested in tests/fit/messages_test.cpp"},
    {"BG416", "no run is fitted; tested in tests/fit/messages_test.cpp"},
    {"BG417", "no run is fitted; tested in tests/fit/messages_test.cpp"},
    {"BG418", "no run is fitted; tested in tests/fit/messages_test.cpp"},
    {"BG419", "no run is fitted; tested in tests/fit/messages_test.cpp"},
    {"BG420", "no run is fitted; tested in tests/fit/fit_test.cpp"},
    {"BG421", "no run is fitted; tested in tests/fit/fitted_text_test.cpp"},
    {"BG171", "no run of a model alone continues another; tested in tests/physics/snapshot_test.cpp"},
    {"BG173", "no run of a model alone names a mode; tested in tests/unit/modes_test.cpp"},
    {"BG620", "the laws that have been tied so far have common values, or end (BG601)"},
    {"BG611", "no run measures a trade; tested in tests/physics/trade_test.cpp"},
    {"BG612", "no run measures a trade; tested in tests/physics/trade_test.cpp"},
    {"BG137", "submodels of 10 million elements; tested in tests/unit/submodel_test.cpp"},
};

struct Options {
  std::string scene;
  SceneOverrides overrides;
  ReadOptions reading;
  SimulateOptions run;
  Clock clock = wall_seconds;
  ReduceOptions reduction;
};

Options read_options(const fs::path& model) {
  Options options;
  std::istringstream lines(test::file_text(fs::path(model).replace_extension(".args")));
  for (std::string line; std::getline(lines, line);) {
    const auto space = line.find(' ');
    const std::string option = line.substr(0, space);
    const std::string value = space == std::string::npos ? "" : line.substr(space + 1);
    if (option == "--set")
      options.overrides.set.push_back(value);
    else if (option == "--parameters")
      options.reading.parameter_files.push_back(value);
    else if (option == "--stop")
      options.reading.stop = value;
    else if (option == "--record")
      options.reading.record.push_back(value);
    else if (option == "--output")
      options.reading.outputs.emplace_back(value.substr(0, value.find('=')), value.substr(value.find('=') + 1));
    else if (option == "--scene")
      options.scene = value;
    else if (option == "--relative")
      options.overrides.relative = std::stod(value);
    else if (option == "--max-steps")
      options.run.max_steps = std::stoul(value);
    else if (option == "--error")
      options.reduction.error = std::stod(value);
    else if (option == "--keep")
      options.reduction.keep.push_back(value);
    else if (option == "--time-limit")
      options.run.time_limit = std::stod(value);
    else if (option == "--tick")
      options.clock = [now = 0.0, tick = std::stod(value)]() mutable { return now += tick; };
    else if (option == "--interrupt")
      options.run.progress = [](double) { return false; };
    else
      FAIL("unknown option in " << model << ": " << line);
  }
  return options;
}

std::string rendered(const std::vector<Diagnostic>& diagnostics, const Sources& sources) {
  std::string text;
  for (const Diagnostic& diagnostic : diagnostics) text += render(diagnostic, sources);
  return text;
}

void hold_against_reference(const Model& model, const RunInputs& inputs, const RunResult& result) {
  const CsvTable table = read_reference(model, inputs.reference.value());
  at_reference_times(model, inputs, table);
  hold_against(model, result.trace, table, inputs.reference.value());
}

/// All that is printed for a model: the warnings of the stages, then the error that ends it.
std::string messages(const std::string& path) {
  Options options = read_options(path);
  options.reading.allow_outside = false;  // as the command does
  std::string text;
  try {
    const Study study = Study(path, options.reading).at_start();
    const Model* const model = &study.model();
    const auto warn = [&](const std::vector<Diagnostic>& warnings) { text += rendered(warnings, *model->sources); };
    warn(model->warnings);
    if (path.substr(0, 4) == "BG71") reduce(study, options.reduction);
    if (path.substr(0, 4) == "BG16") warn(unit_problems(*model, study.graph()));
    warn(study.causality().warnings);
    warn(study.equations().warnings);
    static_cast<void>(study.order());  // for its faults
    const RunInputs inputs = prepare_scene(*model, options.scene, options.overrides);
    warn(inputs.warnings);
    options.run.remark = [&](const Diagnostic& remark) { warn({remark}); };
    const Simulation scene = study.scene(inputs, {.keep_all = true});
    const RunResult result = mode_of(*model).empty() ? simulate(scene.program(), inputs, options.run, options.clock)
                                                     : scene.simulate(options.run);
    if (result.failure) text += render(*result.failure, *model->sources);
    if (path.substr(0, 4) == "BG15") hold_against_reference(*model, inputs, result);
  } catch (const ModelError& error) {
    text += render(error);
  }
  return text;
}

/// Numbers of five digits and more come out of steps and iterations: what they are is for other tests to say.
std::string without_computed_numbers(const std::string& text) {
  static const std::regex computed("-?[0-9]+\\.[0-9]{4,}(e[+-][0-9]+)?");
  return std::regex_replace(text, computed, "#");
}

/// The BGnnn of a model's name.
std::string code_of(std::string_view model) { return std::string(model.substr(0, 5)); }

std::set<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> codes;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), pattern); it != std::sregex_iterator(); ++it)
    codes.insert((*it)[1]);
  return codes;
}

/// Codes that the sources can emit.
std::set<std::string> emitted_codes() {
  std::set<std::string> codes;
  for (const char* folder : {"engine", "cli"}) {
    if (!fs::exists(kSource / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(kSource / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".cpp" || extension == ".hpp")
        codes.merge(matches(test::file_text(entry.path()), std::regex("\"(BG[0-9]{3})\"")));
    }
  }
  return codes;
}

std::set<std::string> documented_codes() {
  return matches(test::file_text(kSource / "docs/errors.md"), std::regex("\n## (BG[0-9]{3}) "));
}

void check_message(const std::string& model) {
  fs::current_path(kSource / "tests/errors");
  const std::string text = messages(model);
  const fs::path golden = fs::path(model).replace_extension(".txt");
  const std::string expected = test::file_text(golden);
  if (without_computed_numbers(text) == without_computed_numbers(expected)) {
    SUCCEED();
  } else {
    CHECK(text == expected);
    if (test::update_goldens()) test::write_file(golden, text);
  }
  CHECK(text.find(" " + code_of(model) + ": ") != std::string::npos);
}

[[maybe_unused]] const bool kRegistered = [] {
  for (const char* const model : kFailingModels)
    test::add_test(fs::path(model).stem().string() + " gets its message", [model] { check_message(model); });
  return true;
}();

}  // namespace

TEST_CASE("every failing model of the folder is a test, and every message and every list of options belongs to one") {
  const std::set<std::string> tested(std::begin(kFailingModels), std::end(kFailingModels));
  for (const auto& entry : fs::directory_iterator(kSource / "tests/errors")) {
    const fs::path file = entry.path().filename();
    if (file.string().starts_with("BG") && file.extension() != ".csv") {
      INFO(file);
      CHECK(tested.contains(fs::path(file).replace_extension(".json").string()));
    }
  }
  for (const std::string& model : tested) {
    INFO(model);
    CHECK(fs::exists(kSource / "tests/errors" / fs::path(model).replace_extension(".txt")));
  }
}

TEST_CASE("every code has a section in docs/errors.md, and every section a code") {
  const std::set<std::string> emitted = emitted_codes(), documented = documented_codes();
  for (const std::string& code : emitted) CHECK((documented.contains(code) ? code : code + " has no section") == code);
  for (const std::string& code : documented)
    CHECK((emitted.contains(code) ? code : code + " is never emitted") == code);
}

TEST_CASE("every code has a failing model, or a reason why not") {
  std::set<std::string> shown;
  for (const char* const model : kFailingModels) shown.insert(code_of(model));
  const std::set<std::string> emitted = emitted_codes();
  for (const std::string& code : emitted) {
    const bool known = shown.contains(code) || kWithoutModel.contains(code);
    CHECK((known ? code : code + " has no failing model") == code);
  }
  for (const auto& [code, reason] : kWithoutModel) CHECK(emitted.contains(code));
}

TEST_CASE("sections of docs/errors.md stand in order and have the anchors that messages point to") {
  const std::string text = test::file_text(kSource / "docs/errors.md");
  std::string last;
  const std::regex section("(<a id=\"(bg[0-9]{3})\"></a>\n)?## (BG[0-9]{3}) ");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), section); it != std::sregex_iterator(); ++it) {
    const std::string code = (*it)[3];
    std::string anchor = code;
    std::transform(anchor.begin(), anchor.end(), anchor.begin(),
                   [](char c) { return c == 'B' || c == 'G' ? static_cast<char>(c + 32) : c; });
    CHECK((*it)[2] == anchor);
    CHECK(last < code);
    last = code;
  }
}
