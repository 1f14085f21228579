// "repeat": elements, submodels and bonds many times.
#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/study.hpp"
#include "read/name_indices.hpp"
#include "support/reading.hpp"

using namespace bgsim;

namespace {

constexpr const char* kLadder = R"x(
  "parameters": { "R": 2, "C": 0.5 },
  "elements": {
    "source": { "kind": "Se", "effort": 10 },
    "joint": { "kind": "1", "repeat": 4 },
    "r": { "kind": "R", "repeat": 4, "resistance": "R*i" },
    "node": { "kind": "0", "repeat": 4 },
    "c": { "kind": "C", "repeat": 4, "capacitance": "C/(5 - i)", "initial": { "e": "i^2" } }
  },
  "bonds": [
    { "from": "source", "to": "joint[1]" },
    { "from": "joint[i]", "to": "r[i]" },
    { "from": "joint[i]", "to": "node[i]" },
    { "from": "node[i]", "to": "c[i]" },
    { "from": "node[i]", "to": "joint[i+1]", "name": "link" }
  ],
  "outputs": { "u": "c[4].e", "f": "link[2].f", "first": "r[1].e" },
  "scenes": { "run": { "stop": 2, "samples": 21 } })x";

/// @p text for every number from 1 to @p last: '#' is the number, '+' the next one.
std::string for_each(int last, const std::string& text) {
  std::string all;
  for (int i = 1; i <= last; ++i)
    for (const char c : text)
      if (c == '#' || c == '+')
        all += std::to_string(c == '#' ? i : i + 1);
      else
        all += c;
  return all;
}

/// The same, written out.
std::string written_out() {
  return R"x("parameters": { "R": 2, "C": 0.5 }, "elements": { "source": { "kind": "Se", "effort": 10 })x" +
         for_each(4, R"x(, "joint#": { "kind": "1" })x") +
         for_each(4, R"x(, "r#": { "kind": "R", "resistance": "R*#" })x") +
         for_each(4, R"x(, "node#": { "kind": "0" })x") +
         for_each(4, R"x(, "c#": { "kind": "C", "capacitance": "C/(5 - #)", "initial": { "e": "#^2" } })x") +
         R"x( }, "bonds": [ { "from": "source", "to": "joint1" })x" +
         for_each(4, R"x(, { "from": "joint#", "to": "r#" })x") +
         for_each(4, R"x(, { "from": "joint#", "to": "node#" })x") +
         for_each(4, R"x(, { "from": "node#", "to": "c#" })x") +
         for_each(3, R"x(, { "from": "node#", "to": "joint+", "name": "link#" })x") +
         R"x( ], "outputs": { "u": "c4.e", "f": "link2.f", "first": "r1.e" },
         "scenes": { "run": { "stop": 2, "samples": 21 } })x";
}

RunResult run(const std::string& body) { return Study::from_text(test::model_text(body)).scene().simulate(); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a repeated element is what it would be, written out: the same trace, bit for bit") {
  const RunResult repeated = run(kLadder), plain = run(written_out());
  REQUIRE(repeated.trace.names == plain.trace.names);
  REQUIRE(repeated.trace.columns.size() == plain.trace.columns.size());
  CHECK(repeated.trace.columns == plain.trace.columns);
}

TEST_CASE("copies and their bonds have the numbers in their names") {
  const Model model = test::read(kLadder);
  CHECK(model.elements.size() == 17);
  CHECK(model.bonds.size() == 16);
  CHECK(model.elements[4].name == "joint[4]");
  CHECK(model.bonds[1].name == "b2[1]");
  CHECK(model.bonds.back().name == "link[3]");
}

TEST_CASE("rows and columns have two indices, and bonds say where they end") {
  // Two rows and three columns of stores, joined along the rows; what column j holds starts at 10 i + j.
  const Model model = test::read(R"x(
    "elements": {
      "node": { "kind": "0", "repeat": [2, 3] },
      "c": { "kind": "C", "repeat": [2, 3], "capacitance": 1, "initial": { "q": "10*i + j" } },
      "along": { "kind": "1", "repeat": [2, 2] }, "r": { "kind": "R", "repeat": [2, 2], "resistance": 1 }
    },
    "bonds": [
      { "from": "node[i][j]", "to": "c[i][j]" },
      { "from": "node[i][j]", "to": "along[i][j]", "repeat": [[1, 2], [1, 2]] },
      { "from": "along[i][j]", "to": "node[i][j+1]", "repeat": [[1, 2], [1, 2]] },
      { "from": "along[i][j]", "to": "r[i][j]" }
    ])x");
  CHECK(model.elements.size() == 20);
  CHECK(model.bonds.size() == 18);
  CHECK(model.bonds[5].name == "b1[2][3]");
  CHECK(model.elements[model.bonds[5].to.element.index()].name == "c[2][3]");
  CHECK(model.elements[model.bonds[10].to.element.index()].name == "node[1][2]");
}

TEST_CASE("indices are sums of multiples of i, j, k and a whole number") {
  IndexValues at;
  at.value = {3, 5, 7};
  at.used = {true, true, true};
  const auto value = [&](const char* text) { return read_index(text)->at(at); };
  CHECK(value("4") == 4);
  CHECK(value(" i + 1") == 4);
  CHECK(value("2*i-1") == 5);
  CHECK(value("17 - i") == 14);
  CHECK(value("i+2*j-k") == 6);
  for (const char* text : {"", "n", "i*i", "i+", "+i", "1.5", "2i", "i 1", "i/2", "-i", "(i)", "1234567890"}) {
    INFO(text);
    CHECK_FALSE(read_index(text));
  }
  CHECK(indices_put_in("cell[i+1][2*j].out", at) == "cell[4][10].out");
  CHECK(indices_put_in("cell.out", at) == "cell.out");
  at.used[1] = false;
  CHECK_FALSE(indices_put_in("cell[j].out", at));
}

TEST_CASE("one copy, and names of single copies, everywhere") {
  const Study study = Study::from_text(test::model_text(kLadder));
  const double before = study.scene().simulate().trace.columns[0].back();
  SceneOverrides overrides;
  overrides.set.emplace_back("c[3].q=0");
  CHECK(study.scene("", overrides).simulate().trace.columns[0].front() == 16.0);  // c[4].e starts at 4^2
  CHECK(study.scene("", overrides).simulate().trace.columns[0].back() < before);
  CHECK(
      test::fault(
          R"x("elements": { "j": { "kind": "1", "repeat": 1 }, "r": { "kind": "R", "resistance": "i" , "repeat": 1 } },
                        "bonds": [ { "from": "j[i]", "to": "r[i]" } ])x") == "none");
}

TEST_CASE("what is at fault in repeated elements is said once") {
  CHECK(test::codes(replaced(kLadder, R"("resistance": "R*i")", R"("resistance": "R*x")")) == "BG121 ");
  CHECK(test::codes(replaced(kLadder, R"("to": "joint[i+1]")", R"("to": "joint[i+1].port")")) == "BG131 ");
  CHECK(test::codes(replaced(kLadder, R"("to": "r[i]")", R"("to": "r[i+9]")")) == "BG139 ");
  CHECK(test::codes(replaced(kLadder, R"("to": "r[i]")", R"("to": "r[i")")) == "BG139 ");
  CHECK(test::codes(replaced(kLadder, R"("to": "r[i]")", R"("to": "r[i][1]")")) == "BG130 ");
  CHECK(test::codes(replaced(kLadder, R"("u": "c[4].e")", R"("u": "c[5].e")")) == "BG121 ");
  CHECK(test::codes(replaced(kLadder, R"("u": "c[4].e")", R"("u": "source[1].e")")) == "BG121 ");
  CHECK(test::codes(replaced(kLadder, R"("R": 2,)", R"("R": 2, "i": 3,)")) == "BG116 ");
  CHECK(test::codes(replaced(kLadder, R"("from": "source",)", R"("from": "source", "repeat": [1, 4],)")) == "BG139 ");
  CHECK(test::codes(replaced(kLadder, R"("repeat": 4)", R"("repeat": 100000000)")) == "BG137 ");
  CHECK(test::codes(replaced(kLadder, R"("repeat": 4)", R"("repeat": [])")).starts_with("BG139 "));
  CHECK(test::codes(replaced(kLadder, R"("repeat": 4)", R"("repeat": -1)")).starts_with("BG139 "));
}

TEST_CASE("repeated switches and the side that each is on") {
  const std::string body = R"x(
    "elements": {
      "source": { "kind": "Se", "effort": 1 }, "bus": { "kind": "0" }, "branch": { "kind": "1", "repeat": 3 },
      "sw": { "kind": "Sw", "repeat": 3, "closed": "t >= i" },
      "r": { "kind": "MR", "repeat": 3, "resistance": "if(mode('sw[i]'), i, 7)" }
    },
    "bonds": [ { "from": "source", "to": "bus" }, { "from": "bus", "to": "branch[i]" },
               { "from": "branch[i]", "to": "sw[i]" }, { "from": "branch[i]", "to": "r[i]" } ],
    "outputs": { "all": "source.f", "second": "if(mode('sw[2]'), 1, 0)" },
    "scenes": { "run": { "stop": 4, "samples": 9 } })x";
  const RunResult result = run(body);
  REQUIRE(result.trace.columns.size() == 2);
  // Conductances 1, 1/2, 1/3 come in at t = 1, 2, 3; samples every 0.5, between them.
  const std::vector<double> at{0.5, 1.5, 2.5, 3.5}, total{0.0, 1.0, 1.5, 1.5 + 1.0 / 3.0};
  for (std::size_t k = 0; k < at.size(); ++k) {
    INFO(at[k]);
    // The laws of resistors are solved for a flow each: two roundings.
    CHECK(std::abs(result.trace.columns[0][2 * k + 1]) == Approx(total[k]).epsilon(1e-14).margin(0.0));
    CHECK(result.trace.columns[1][2 * k + 1] == (at[k] > 2.0 ? 1.0 : 0.0));
  }
  CHECK(test::codes(replaced(body, "mode('sw[i]')", "mode('sw[i+1]')")) == "BG121 ");
  CHECK(test::codes(replaced(body, "mode('sw[i]')", "mode('sw')")) == "BG121 ");
}
