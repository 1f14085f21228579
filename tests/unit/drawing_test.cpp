// Drawings: strokes and half-arrows at any angle, faulty models, what Graphviz is asked and answers.
#include "bgsim/drawing.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "support/sketch.hpp"

using namespace bgsim;
using bgsim::test::sketch;
using Catch::Contains;

namespace {

/// The text of the group of a bond or an element.
std::string group_of(const std::string& svg, const std::string& what, const std::string& name) {
  const std::size_t begin = svg.find("data-" + what + "=\"" + name + "\"");
  REQUIRE(begin != std::string::npos);
  return svg.substr(begin, svg.find("</g>", begin) - begin);
}

/// The numbers of a path of a bond: x1 y1 x2 y2.
std::vector<double> path_of(const std::string& group, const std::string& css) {
  const std::size_t found = group.find("class=\"" + css + "\" d=\"");
  REQUIRE(found != std::string::npos);
  const std::size_t begin = group.find("d=\"", found) + 3;
  std::string text = group.substr(begin, group.find('"', begin) - begin);
  for (char& c : text)
    if (c == 'M' || c == 'L') c = ' ';
  std::istringstream numbers(text);
  std::vector<double> values;
  for (double value = 0.0; numbers >> value;) values.push_back(value);
  return values;
}

struct Line {
  double x, y, dx, dy;
  explicit Line(const std::vector<double>& p) : x(p[0]), y(p[1]), dx(p[2] - p[0]), dy(p[3] - p[1]) {}
  [[nodiscard]] double size() const { return std::hypot(dx, dy); }
};

Model model_of(const std::string& json) { return read_model_text("test.json", json); }

// Coordinates are written to a hundredth of a pixel, so a direction over 14 px is right to 1e-3.
constexpr double kWritten = 2e-3;

}  // namespace

TEST_CASE("strokes stand upright on their bond at its right end, at any angle") {
  const Model model = model_of(sketch("Se:s I:i", "s>i"));
  const DrawnCausality causality = drawn_causality(model);
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double angle = degrees * 0.017453292519943295;
    const Layout layout{{{0.0, 0.0}, {120.0 * std::cos(angle), 120.0 * std::sin(angle)}}};
    const std::string bond = group_of(drawing_svg(model, causality, layout), "bond", "b1");
    const Line line(path_of(bond, "line")), stroke(path_of(bond, "stroke")), barb(path_of(bond, "arrow"));
    INFO(degrees);
    CHECK(std::abs(line.dx * stroke.dx + line.dy * stroke.dy) / (line.size() * stroke.size()) < kWritten);
    // An effort source has its stroke at the far end, here the head; its middle is the bond's end.
    CHECK(stroke.x + stroke.dx / 2 == Approx(line.x + line.dx).margin(0.011));
    CHECK(stroke.y + stroke.dy / 2 == Approx(line.y + line.dy).margin(0.011));
    // The half-arrow has one barb, which begins at the head and goes back.
    CHECK(barb.x == Approx(line.x + line.dx).margin(0.011));
    CHECK(barb.dx * line.dx + barb.dy * line.dy < 0.0);
  }
}

TEST_CASE("the stroke of a flow source is at its own end") {
  const Model model = model_of(sketch("Sf:s C:c", "s>c"));
  const Layout layout{{{0.0, 0.0}, {100.0, 0.0}}};
  const std::string bond = group_of(drawing_svg(model, drawn_causality(model), layout), "bond", "b1");
  CHECK(Line(path_of(bond, "stroke")).x == Line(path_of(bond, "line")).x);
}

TEST_CASE("bonds side by side between the same elements are drawn apart") {
  const Model model = model_of(sketch("Se:s 0:a 1:b R:r", "s>a a>b a>b b>r"));
  const Layout layout{{{0, 0}, {100, 0}, {200, 0}, {300, 0}}};
  const std::string svg = drawing_svg(model, drawn_causality(model), layout);
  CHECK_THAT(group_of(svg, "bond", "b2"), Contains("Q"));
  CHECK(group_of(svg, "bond", "b2").substr(30) != group_of(svg, "bond", "b3").substr(30));
}

TEST_CASE("dependent stores, free choices and what causes them are marked and in the legend") {
  const Model model = model_of(sketch("Se:s 1:a I:i I:j", "s>a a>i a>j"));
  const Layout layout{{{0, 0}, {100, 0}, {100, 70}, {100, -70}}};
  const std::string svg = drawing_svg(model, drawn_causality(model), layout);
  CHECK_THAT(svg, Contains("class=\"bond dependent\" id=\"bg-bond-b3\""));
  CHECK_THAT(svg, Contains("class=\"element kind-I dependent\" id=\"bg-element-j\""));
  CHECK_THAT(svg, Contains("derivative causality: a dependent store"));
  CHECK_THAT(svg, !Contains("an algebraic loop"));
}

TEST_CASE("the legend says whether laws or conditions read a signal") {
  const auto legend = [](const std::string& effort, const std::string& closed) {
    const Model model = model_of(R"({"bgsim": 1, "name": "s", "elements": {"s": {"kind": "MSe", "effort": ")" + effort +
                                 R"("}, "a": {"kind": "1"}, "c": {"kind": "C", "capacitance": 1}, "r": {"kind": "R",
      "resistance": 1}, "w": {"kind": "Sw", "closed": ")" +
                                 closed + R"("}}, "bonds": [{"from": "s", "to": "a"}, {"from": "a", "to": "c"},
      {"from": "a", "to": "r"}, {"from": "a", "to": "w"}], "outputs": {"q": "c.q"}})");
    const Layout layout{{{0, 0}, {100, 0}, {100, 70}, {100, -70}, {200, 0}}};
    return drawing_svg(model, drawn_causality(model), layout);
  };
  CHECK_THAT(legend("1", "c.q < 3"), Contains("signal: a condition reads this"));
  CHECK_THAT(legend("2 - c.e", "t < 3"), Contains("signal: a law reads this"));
  CHECK_THAT(legend("2 - c.e", "c.q < 3"), Contains("signal: a law or condition reads this"));
}

TEST_CASE("a model whose causality conflicts is drawn with the strokes assigned so far and its fault marked") {
  const Model model = model_of(sketch("Se:s Se:u 0:bus 1:m R:r", "s>bus u>bus bus>m m>r"));
  const DrawnCausality drawn = drawn_causality(model);
  REQUIRE(drawn.problems.size() == 1);
  CHECK(drawn.problems.front().code == "BG301");
  CHECK(drawn.faulty == std::vector{ElementId(std::size_t{2})});
  CHECK(drawn.strokes[0] == BondEnd::head);
  CHECK(drawn.strokes[1] == BondEnd::head);
  CHECK_FALSE(drawn.strokes[3]);
  const Layout layout{{{0, 0}, {0, 100}, {100, 0}, {200, 0}, {300, 0}}};
  const std::string svg = drawing_svg(model, drawn, layout);
  CHECK_THAT(svg, Contains("class=\"bond unassigned\" id=\"bg-bond-b4\""));
  CHECK_THAT(svg, Contains("class=\"element kind-0 faulty\" id=\"bg-element-bus\""));
  CHECK_THAT(svg, Contains("BG301: two bonds set the effort"));
}

TEST_CASE("a conflict that only choices lead to shows the strokes up to it") {
  // A ring through a gyrator: with either stroke the other junction receives its effort twice, or never. The ring takes
  // no flow, so the source has no way out.
  const Model model = model_of(sketch("Sf:s GY:g 0:a 0:b TF:n", "s>a a>g g>b a>n n>b"));
  const DrawnCausality drawn = drawn_causality(model);
  REQUIRE(drawn.problems.size() == 1);
  CHECK(drawn.faulty.size() == 1);
  CHECK(std::count_if(drawn.strokes.begin(), drawn.strokes.end(), [](auto& s) { return s.has_value(); }) > 0);
}

TEST_CASE("a graph that cannot be built is drawn without strokes, its wrongly bonded elements marked") {
  const Model model = model_of(sketch("Se:s 1:a TF:n R:lost", "s>a a>n"));
  const DrawnCausality drawn = drawn_causality(model);
  CHECK(drawn.problems.size() == 2);
  CHECK(drawn.faulty == std::vector{ElementId(std::size_t{2}), ElementId(std::size_t{3})});
  CHECK_FALSE(drawn.strokes[0]);
}

TEST_CASE("signals are drawn from what a law reads, through named signals, and not from the element itself") {
  const Model model = model_of(R"({ "bgsim": 1, "name": "n",
    "signals": { "u": "2*c.q" },
    "elements": { "s": { "kind": "MSe", "effort": "u" }, "a": { "kind": "1" }, "c": { "kind": "C", "capacitance": 1 },
                  "r": { "kind": "MR", "law": "e = f*b1.f" } },
    "bonds": [ { "from": "s", "to": "a" }, { "from": "a", "to": "c" }, { "from": "a", "to": "r" } ] })");
  const Layout layout{{{0, 0}, {100, 0}, {100, 70}, {200, 0}}};
  const std::string svg = drawing_svg(model, drawn_causality(model), layout);
  CHECK_THAT(svg, Contains("<title>s reads c.q through u</title>"));
  CHECK_THAT(svg, Contains("<title>r reads b1.f</title>"));
  CHECK_THAT(svg, !Contains("r reads r"));
}

TEST_CASE("texts of a model are escaped, ids take the prefix, and effort and flow stand in place of the bond's name") {
  Model model = model_of(sketch("Se:s R:r", "s>r"));
  model.about = "a < b & \"c\"\x01";
  const Layout layout{{{0, 0}, {100, 0}}};
  const std::string svg = drawing_svg(model, drawn_causality(model), layout, {.effort_flow = true, .id_prefix = "x-"});
  CHECK_THAT(svg, Contains("a &lt; b &amp; &quot;c&quot;\\x01</desc>"));
  CHECK_THAT(svg, Contains("id=\"x-bond-b1\""));
  CHECK_THAT(svg, Contains(">e<tspan") && Contains(">f<tspan") && !Contains("bond-name\""));
}

TEST_CASE("what hangs on a junction is part of its node, and is above and below it") {
  const Model model = model_of(sketch("Se:s 1:a I:i R:r C:c", "s>a a>i a>r a>c"));
  const std::string request = layout_request(model);
  CHECK_THAT(request,
             Contains("n0 [") && Contains("n1 [") && !Contains("n2 [") && Contains("n3 [") && !Contains("n4 ["));
  const Layout layout = read_layout(model,
                                    "graph 1 5 3\nnode n0 1 1 1 1 x solid rect black white\nnode n1 2 1 1 1 x\n"
                                    "node n3 3 1 1 1 x\nstop\n");
  CHECK(layout.elements[2].x == layout.elements[1].x);
  CHECK(layout.elements[2].y < layout.elements[1].y);
  CHECK(layout.elements[4].y > layout.elements[1].y);
  CHECK_THROWS_AS(read_layout(model, "graph 1 5 3\nnode n0 1 1 1 1\nstop\n"), std::invalid_argument);
  CHECK_THROWS_AS(read_layout(model, "graph 1 5 3\nnode n9 1 1 1 1\nstop\n"), std::invalid_argument);
}

TEST_CASE("parts that nothing joins stand one below the other in the model's order") {
  const Model model = model_of(sketch("Se:s R:r Sf:u C:c", "s>r u>c"));
  const Layout layout = read_layout(model,
                                    "graph 1 4 4\nnode n0 1 1 1 1\nnode n1 3 1 1 1\nnode n2 1 3 1 1\n"
                                    "node n3 3 3 1 1\nstop\n");
  CHECK(layout.elements[0].y < layout.elements[2].y);
  CHECK(layout.elements[0].y == layout.elements[1].y);
  CHECK(layout.elements[2].y == layout.elements[3].y);
}

TEST_CASE("where nothing else goes on to the right of a junction, one of what hangs there does") {
  const Model model = model_of(sketch("Se:s 1:a R:r C:c", "s>a a>r a>c"));
  CHECK_THAT(layout_request(model), Contains("n2 [") && !Contains("n3 ["));
  const Model chain = model_of(sketch("Se:s 1:a R:r C:c 0:b I:i", "s>a a>r a>c a>b b>i"));
  CHECK_THAT(layout_request(chain), !Contains("n2 [") && !Contains("n3 ["));
}
