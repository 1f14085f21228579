// bgsim draw: kinds of files, faulty models, large ones.
#include <catch2/catch.hpp>
#include <cmath>
#include <regex>
#include <sstream>

#include "command.hpp"

using Catch::Contains;

namespace {

/// A ladder network: `sections` of a 1-junction with I and R and a 0-junction with C, behind one source.
std::string ladder(int sections) {
  std::ostringstream elements, bonds;
  elements << R"("s": { "kind": "Se", "effort": 1 })";
  std::string before = "s";
  for (int i = 0; i < sections; ++i) {
    const std::string n = std::to_string(i);
    elements << R"(, "line)" << n << R"(": { "kind": "1" }, "coil)" << n
             << R"(": { "kind": "I", "inertance": 1 }, "loss)" << n << R"(": { "kind": "R", "resistance": 1 }, "node)"
             << n << R"(": { "kind": "0" }, "store)" << n << R"(": { "kind": "C", "capacitance": 1 })";
    const auto bond = [&](const std::string& from, const std::string& to) {
      bonds << (i == 0 && from == "s" ? "" : ", ") << R"({ "from": ")" << from << R"(", "to": ")" << to << "\" }";
    };
    bond(before, "line" + n);
    bond("line" + n, "coil" + n);
    bond("line" + n, "loss" + n);
    bond("line" + n, "node" + n);
    bond("node" + n, "store" + n);
    before = "node" + n;
  }
  return R"({ "bgsim": 1, "name": "ladder", "elements": { )" + elements.str() + R"( }, "bonds": [ )" + bonds.str() +
         " ] }";
}

}  // namespace

TEST_CASE("a drawing is written as SVG, PNG or DOT by its file's ending, the same bytes each time") {
  const Workplace here;
  CHECK(here.bgsim("draw decay.json").code == 0);
  const std::string svg = here.read("decay.svg");
  CHECK_THAT(svg, Catch::StartsWith("<svg ") && Contains("role=\"img\"") && Contains("data-bond=\"b1\""));
  const Outcome out = here.bgsim("draw decay.json -o -");
  CHECK(out.code == 0);
  CHECK(out.out == svg);
  CHECK(here.bgsim("draw decay.json -o x.png --zoom 1").code == 0);
  CHECK(here.read("x.png").substr(1, 3) == "PNG");
  CHECK(here.bgsim("draw decay.json -o x.dot").code == 0);
  CHECK_THAT(here.read("x.dot"), Catch::StartsWith("digraph") && Contains("arrowhead="));
}

TEST_CASE("an ending that names no kind of picture is refused") {
  const Workplace here;
  const Outcome outcome = here.bgsim("draw decay.json -o x.jpg");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("ends with none of .svg, .png and .dot"));
}

TEST_CASE("a model whose causality conflicts is drawn, with its message and exit code 1") {
  const Workplace here;
  const Outcome outcome = here.bgsim("draw '" BGSIM_SOURCE_DIR "/tests/errors/BG301_two_sources.json' -o it.svg");
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("BG301") && Contains("drawn with the strokes assigned up to there"));
  CHECK_THAT(here.read("it.svg"), Contains("kind-0 faulty"));
}

TEST_CASE("without Graphviz the message says which package has it") {
  const Workplace here;
  const Outcome outcome = here.bgsim("--version", "; PATH=/nowhere '" BGSIM_COMMAND "' draw decay.json 2>.err");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err,
             Contains("dot, which lays drawings out, is not installed (Debian: apt-get install graphviz)"));
}

TEST_CASE("a ladder of 300 elements is folded into rows, and nothing in it covers anything else") {
  const Workplace here;
  here.write("ladder.json", ladder(60));
  REQUIRE(here.bgsim("draw ladder.json").code == 0);
  const std::string svg = here.read("ladder.svg");
  const std::regex letter("class=\"letter\" x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"");
  std::vector<std::pair<double, double>> at;
  for (std::sregex_iterator found(svg.begin(), svg.end(), letter), end; found != end; ++found)
    at.emplace_back(std::stod((*found)[1]), std::stod((*found)[2]));
  REQUIRE(at.size() == 301);
  double nearest = 1e9;
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      nearest = std::min(nearest, std::hypot(at[i].first - at[k].first, at[i].second - at[k].second));
  CHECK(nearest > 50.0);  // letters are 20 px high, so that a bond of 20 px and more lies between any two
  std::smatch size;
  REQUIRE(std::regex_search(svg, size, std::regex("width=\"([0-9.]+)\" height=\"([0-9.]+)\"")));
  CHECK(std::stod(size[1]) < 3.0 * std::stod(size[2]));
}
