/// Every stage's text for some of the shipped models, byte for byte. After a change that is meant, run the tests once
/// with BGSIM_UPDATE_GOLDEN=1 and review the difference.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string_view>

#include "support/files.hpp"
#include "support/run.hpp"

using namespace bgsim;

namespace {

const std::filesystem::path kSource = BGSIM_SOURCE_DIR;

/// The text without the folder of the checkout: references are shown with their whole path.
std::string without_checkout(std::string text) {
  const std::string folder = kSource.string() + "/";
  for (auto at = text.find(folder); at != std::string::npos; at = text.find(folder)) text.erase(at, folder.size());
  return text;
}

void check_golden(const std::filesystem::path& path, const std::string& printed) {
  const std::string text = without_checkout(printed);
  if (test::update_goldens()) {
    std::filesystem::create_directories(path.parent_path());
    test::write_file(path, text);
  }
  INFO(path.string());
  REQUIRE(std::filesystem::exists(path));
  CHECK(text == test::file_text(path));
}

/// One model for each thing a stage can do: loops, dependent stores, state-modulated moduli, submodels, fields, events.
const char* const kModels[] = {"rlc",    "lever",           "wheatstone", "pendulum",  "dc_motor",
                               "bellow", "actuator_masses", "amplifier",  "pi_control"};

/// Those whose graph and list of slots a reader can check by hand. For the others, what the graph and the program do is
/// tested (oracle, references, known answers); a text that nobody checks would only record.
const std::string_view kSmall[] = {"rlc", "lever", "wheatstone", "pi_control"};

/// Shipped models, or one that stands beside its texts.
std::filesystem::path file_of(const std::string& name) {
  const std::filesystem::path own = kSource / "tests" / "golden" / name / (name + ".json");
  return std::filesystem::exists(own) ? own : kSource / "models" / (name + ".json");
}

}  // namespace

TEST_CASE("every stage of every golden model prints what it printed before") {
  const std::string name = GENERATE(from_range(std::begin(kModels), std::end(kModels)));
  const Study study(file_of(name).string());
  const Model& model = study.model();
  const BondGraph& graph = study.graph();
  const EquationSystem& system = study.equations();
  const std::filesystem::path folder = kSource / "tests" / "golden" / name;
  const UnitReport units = infer_units(model, graph);
  check_golden(folder / "units.txt", show_units(model, graph, units));
  check_golden(folder / "causality.txt", show_causality(model, graph, study.causality()));
  check_golden(folder / "equations.txt", show_equations(model, system));
  check_golden(folder / "order.txt", show_order(model, system, study.order()));
  check_golden(folder / "check.txt", describe_causality(model, graph, study.causality()) +
                                         describe_loops(model, system, study.order()) + describe_units(model, units));
  check_golden(folder / "state_equations.txt", equations_text(model, system, study.order()));
  check_golden(folder / "state_equations.tex", equations_latex(model, system, study.order()));
  if (std::find(std::begin(kSmall), std::end(kSmall), name) == std::end(kSmall)) return;
  check_golden(folder / "model.txt", show_model(model));
  check_golden(folder / "graph.txt", show_graph(model, graph));
  check_golden(folder / "program.txt", show_program(study.scene("", {}, {.keep_all = true}).program()));
}

TEST_CASE("the same model gives the same bytes twice") {
  const std::string name = GENERATE(from_range(std::begin(kModels), std::end(kModels)));
  const auto text = [&] {
    const Study study(file_of(name).string());
    return show_equations(study.model(), study.equations()) +
           show_order(study.model(), study.equations(), study.order()) +
           show_program(study.scene("", {}, {.keep_all = true}).program());
  };
  CHECK(text() == text());
}
