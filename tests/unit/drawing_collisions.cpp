// Nothing in a drawing covers anything else, by the measure of the fonts that draw it.
#include <catch2/catch.hpp>
#include <filesystem>

#include "bgsim/drawing.hpp"
#include "support/drawing_check.hpp"
#include "support/font.hpp"
#include "support/random_graph.hpp"
#include "support/reading.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"
#include "support/sketch.hpp"

using namespace bgsim;
using Catch::Contains;

namespace {

const std::string kSource = BGSIM_SOURCE_DIR;

std::string lines(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\n";
  return text;
}

bool about_strokes(const std::string& collision) {
  return collision.starts_with("the stroke of") || collision.find(" lies on ") != std::string::npos;
}

/// Position of a group's first letter, from the upper left corner of a frame.
std::pair<double, double> place_in_frame(const std::string& svg, const std::string& frame, const std::string& element) {
  const auto number = [&](std::size_t from, const std::string& name) {
    const std::size_t at = svg.find(" " + name + "=\"", from);
    return std::stod(svg.substr(at + name.size() + 3));
  };
  const std::size_t box = svg.find("<rect", svg.find("data-submodel=\"" + frame + "\""));
  const std::size_t letter = svg.find("class=\"letter\"", svg.find("data-element=\"" + element + "\""));
  REQUIRE(letter != std::string::npos);
  return {number(letter, "x") - number(box, "x"), number(letter, "y") - number(box, "y")};
}

}  // namespace

TEST_CASE("in the drawings of all models no text, letter or stroke covers another", "[long]") {
  std::size_t seen = 0;
  for (const std::string folder : {"models", "docs/notation", "tests/data/models", "tests/data/drawings"})
    for (const std::string& path : test::models_in(folder)) {
      INFO(path);
      ++seen;
      CHECK(lines(test::collisions_in(test::drawn_by_dot_from(kSource + "/" + path))) == "");
    }
  CHECK(seen > 60);
}

TEST_CASE("in drawings of random graphs no text covers another, and hardly a stroke touches a bond") {
  // What remains are strokes where two bonds join the same neighbours and a third goes round one of them: a graph in
  // a hundred.
  const std::size_t graphs = test::share_of(120);
  std::size_t with_strokes = 0;
  for (std::size_t seed = 0; seed < graphs; ++seed) {
    INFO("seed " << seed);
    std::vector<std::string> found = test::collisions_in(test::drawn_by_dot(test::random_graph(seed).json()));
    with_strokes += std::erase_if(found, about_strokes) > 0 ? 1U : 0U;
    CHECK(lines(found).empty());
  }
  CHECK(with_strokes <= 2);
}

TEST_CASE("the check of drawings sees what covers what") {
  const Model model = read_model_text(
      "test.json", test::sketch("Se:battery 1:loop R:resistor C:store", "battery>loop loop>resistor loop>store"));
  const auto draw = [&](const Layout& layout) {
    return lines(test::collisions_in(drawing_svg(model, drawn_causality(model), layout)));
  };
  CHECK(draw({{{0, 0}, {150, 0}, {300, 0}, {150, 100}}}).empty());
  CHECK_THAT(draw({{{0, 0}, {150, 0}, {300, 0}, {301, 3}}}), Contains("covers"));
  const std::string crowded = lines(test::collisions_in(
      R"(<svg viewBox="0 0 200 100"><g class="bond" data-bond="b1"><path class="line" d="M10 50L190 50"/>)"
      R"(<path class="stroke" d="M100 40L100 60"/><text class="bond-name" x="50" y="53" font-size="10")"
      R"( text-anchor="middle" textLength="40">b1</text></g><g class="bond" data-bond="b2">)"
      R"(<path class="line" d="M10 51L190 51"/><text class="bond-name" x="199" y="20" font-size="10")"
      R"( text-anchor="middle">b2</text></g></svg>)"));
  CHECK_THAT(crowded, Contains("goes through \"b1\"") && Contains("the stroke of bond b1 touches bond b2") &&
                          Contains("bond b1 lies on bond b2") && Contains("\"b2\" of bond b2 is cut") &&
                          Contains("px wide, its textLength"));
}

TEST_CASE("a text is as wide as the font's file has it") {
  std::string all;
  for (char c = ' '; c < '\x7f'; ++c) all += c;
  const test::Font sans("Liberation Sans"), italic("Liberation Sans:italic");
  // textLength of every text is checked by collisions_in(); signals are written in italics of the same width.
  for (const char c : all) {
    INFO(c);
    CHECK(italic.advance(c) == Approx(sans.advance(c)).margin(1e-9));
  }
}

TEST_CASE("both halves of the actuator are drawn alike, the one declared first above") {
  const std::string svg = test::drawn_by_dot_from(kSource + "/models/actuator.json");
  for (const std::string name : {"pump", "inlet", "orifice", "field", "wall", "damping"}) {
    INFO(name);
    const auto left = place_in_frame(svg, "left", "left." + name),
               right = place_in_frame(svg, "right", "right." + name);
    CHECK(left.first == Approx(right.first).margin(1.0));  // dot places nodes to a pixel
    CHECK(left.second == Approx(right.second).margin(1.0));
  }
  const auto height = [&](const std::string& name) { return place_in_frame(svg, "left", name).second; };
  CHECK(height("left_end") < height("right_end"));
  const double middle = (height("left_end") + height("right_end")) / 2;
  for (const std::string name : {"heave", "pitch"}) CHECK(height(name) == Approx(middle).margin(1.0));
}
