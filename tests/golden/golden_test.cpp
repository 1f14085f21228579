/// Every stage's text for some of the shipped models, byte for byte. After a change that is meant, run the tests once
/// with BGSIM_UPDATE_GOLDEN=1 and review the difference.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/pipeline.hpp"

using namespace bgsim;

namespace {

const std::filesystem::path kSource = BGSIM_SOURCE_DIR;

std::string content(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The text without the folder of the checkout: references are shown with their whole path.
std::string without_checkout(std::string text) {
  const std::string folder = kSource.string() + "/";
  for (auto at = text.find(folder); at != std::string::npos; at = text.find(folder)) text.erase(at, folder.size());
  return text;
}

void check_golden(const std::filesystem::path& path, const std::string& printed) {
  const std::string text = without_checkout(printed);
  if (std::getenv("BGSIM_UPDATE_GOLDEN") != nullptr) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  INFO(path.string());
  REQUIRE(std::filesystem::exists(path));
  CHECK(text == content(path));
}

/// One model for each thing a stage can do: loops, dependent stores, state-modulated moduli, submodels, fields, events.
const char* const kModels[] = {"rlc",    "lever",           "wheatstone", "pendulum",  "dc_motor",
                               "bellow", "actuator_masses", "amplifier",  "pi_control"};

/// Shipped models, or one that stands beside its texts.
std::filesystem::path file_of(const std::string& name) {
  const std::filesystem::path own = kSource / "tests" / "golden" / name / (name + ".json");
  return std::filesystem::exists(own) ? own : kSource / "models" / (name + ".json");
}

}  // namespace

TEST_CASE("every stage of every golden model prints what it printed before") {
  const std::string name = GENERATE(from_range(std::begin(kModels), std::end(kModels)));
  const auto model = std::make_shared<const Model>(read_model(file_of(name).string()));
  const test::Pipeline p(model);
  const std::filesystem::path folder = kSource / "tests" / "golden" / name;
  check_golden(folder / "model.txt", show_model(*model));
  check_golden(folder / "graph.txt", show_graph(*model, p.graph));
  const UnitReport units = infer_units(*model, p.graph);
  check_golden(folder / "units.txt", show_units(*model, p.graph, units));
  check_golden(folder / "causality.txt", show_causality(*model, p.graph, p.causal));
  check_golden(folder / "equations.txt", show_equations(*model, p.system));
  check_golden(folder / "order.txt", show_order(*model, p.system, p.order));
  check_golden(folder / "program.txt", show_program(p.program));
  check_golden(folder / "check.txt", describe_causality(*model, p.graph, p.causal) +
                                         describe_loops(*model, p.system, p.order) + describe_units(*model, units));
  check_golden(folder / "state_equations.txt", equations_text(*model, p.system, p.order));
  check_golden(folder / "state_equations.tex", equations_latex(*model, p.system, p.order));
}

TEST_CASE("the same model gives the same bytes twice") {
  const std::string name = GENERATE(from_range(std::begin(kModels), std::end(kModels)));
  const auto text = [&] {
    const auto model = std::make_shared<const Model>(read_model(file_of(name).string()));
    const test::Pipeline p(model);
    return show_equations(*model, p.system) + show_order(*model, p.system, p.order) + show_program(p.program);
  };
  CHECK(text() == text());
}
