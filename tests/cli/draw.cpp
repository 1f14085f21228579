// bgsim draw: kinds of files, faulty models, large ones.
#include <array>
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

/// A binary tree of junctions with a store at each, packets of the soft actuator at its 2^depth leaves.
std::string tree(int depth) {
  std::ostringstream elements, bonds;
  elements << R"("root": { "kind": "1" }, "body": { "kind": "I", "inertance": 1 })";
  bonds << R"({ "from": "root", "to": "body" })";
  std::vector<std::string> level{"root"};
  for (int deep = 1; deep <= depth; ++deep) {
    std::vector<std::string> next;
    for (const std::string& above : level)
      for (const char side : {'a', 'b'}) {
        const std::string name = above + side;
        const std::string from = deep == depth ? name + ".body" : name;
        bonds << R"(, { "from": ")" << from << R"(", "to": ")" << above << "\" }";
        elements << ", \"" << name << R"(": { "kind": ")"
                 << (deep == depth   ? "packet"
                     : deep % 2 == 1 ? "0"
                                     : "1")
                 << "\" }";
        if (deep == depth) continue;
        elements << ", \"of_" << name
                 << (deep % 2 == 1 ? R"(": { "kind": "C", "capacitance": 1 })"
                                   : R"(": { "kind": "I", "inertance": 1 })");
        bonds << R"(, { "from": ")" << name << R"(", "to": "of_)" << name << "\" }";
        next.push_back(name);
      }
    level = next;
  }
  return R"({ "bgsim": 1, "name": "tree", "types": { "packet": ")" BGSIM_SOURCE_DIR
         R"(/models/packet.json" }, "elements": { )" +
         elements.str() + R"( }, "bonds": [ )" + bonds.str() + " ] }";
}

/// Where the letters of a drawing stand, and its size.
struct Drawn {
  std::vector<std::pair<double, double>> letters;
  double nearest = 1e9, width = 0.0, height = 0.0;

  explicit Drawn(const std::string& svg) {
    const std::regex letter("class=\"letter\" x=\"([-0-9.]+)\" y=\"([-0-9.]+)\"");
    for (std::sregex_iterator found(svg.begin(), svg.end(), letter), end; found != end; ++found)
      letters.emplace_back(std::stod((*found)[1]), std::stod((*found)[2]));
    for (std::size_t i = 0; i < letters.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        nearest =
            std::min(nearest, std::hypot(letters[i].first - letters[k].first, letters[i].second - letters[k].second));
    std::smatch size;
    REQUIRE(std::regex_search(svg, size, std::regex("width=\"([0-9.]+)\" height=\"([0-9.]+)\"")));
    width = std::stod(size[1]);
    height = std::stod(size[2]);
  }
};

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
  const Outcome outcome = here.bgsim("--version", "; PATH=/nowhere '" + bgsim_path() + "' draw decay.json 2>.err");
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err,
             Contains("dot, which lays drawings out, is not installed (Debian: apt-get install graphviz)"));
}

TEST_CASE("a PNG without the font it is laid out for says so, and an SVG keeps every text as wide as laid out") {
  const Workplace here;
  const Outcome with = here.bgsim("draw decay.json -o with.png");
  CHECK(with.code == 0);
  CHECK(with.err.empty());
  // A machine that has no fonts but one other family.
  here.write("fonts.conf",
             "<?xml version=\"1.0\"?><!DOCTYPE fontconfig SYSTEM \"fonts.dtd\"><fontconfig>"
             "<dir>/usr/share/fonts/truetype/dejavu</dir><cachedir>" +
                 here.folder() + "/cache</cachedir></fontconfig>");
  const Outcome without = here.bgsim("--version", "; FONTCONFIG_FILE=\"$PWD/fonts.conf\" '" + bgsim_path() +
                                                      "' draw decay.json -o without.png 2>.err");
  CHECK(without.code == 0);
  CHECK_THAT(without.err, Contains("note: the PNG is drawn with the font") && Contains("fonts-liberation"));
  REQUIRE(here.bgsim("draw decay.json").code == 0);
  const std::string svg = here.read("decay.svg");
  const std::regex name("<text class=\"halo name\"[^>]*>"),
      fitted("<text class=\"halo name\"[^>]* textLength=\"[0-9.]+\"[^>]*>");
  const auto count = [&](const std::regex& what) {
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), what), std::sregex_iterator());
  };
  CHECK(count(name) > 0);
  CHECK(count(fitted) == count(name));
}

TEST_CASE("a ladder of 300 elements is folded into rows, and nothing in it covers anything else") {
  const Workplace here;
  here.write("ladder.json", ladder(60));
  REQUIRE(here.bgsim("draw ladder.json").code == 0);
  const Drawn drawn(here.read("ladder.svg"));
  CHECK(drawn.letters.size() == 301);
  CHECK(drawn.nearest > 50.0);  // letters are 20 px high, so that a bond of 20 px and more lies between any two
  CHECK(drawn.width < 3.0 * drawn.height);
}

TEST_CASE("a tree with 32 submodels is drawn from its middle to both sides, frames beside each other") {
  const Workplace here;
  here.write("tree.json", tree(5));
  REQUIRE(here.bgsim("draw tree.json --allow-outside").code == 0);
  const std::string svg = here.read("tree.svg");
  const Drawn drawn(svg);
  CHECK(drawn.letters.size() == 2 + 2 * 30 + 6 * 32);
  CHECK(drawn.nearest > 50.0);
  CHECK(drawn.height < 2.0 * drawn.width);
  const std::regex frame("<rect x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" width=\"([0-9.]+)\" height=\"([0-9.]+)\" rx=\"8\"/>");
  std::vector<std::array<double, 4>> frames;
  for (std::sregex_iterator found(svg.begin(), svg.end(), frame), end; found != end; ++found)
    frames.push_back({std::stod((*found)[1]), std::stod((*found)[2]), std::stod((*found)[3]), std::stod((*found)[4])});
  CHECK(frames.size() == 32);
  std::size_t overlapping = 0;
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const auto &a = frames[i], &b = frames[k];
      const bool apart = a[0] + a[2] < b[0] || b[0] + b[2] < a[0] || a[1] + a[3] < b[1] || b[1] + b[3] < a[1];
      overlapping += apart ? 0U : 1U;
    }
  CHECK(overlapping == 0);
}
