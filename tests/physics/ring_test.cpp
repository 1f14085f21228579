// Rings of junctions: what their equations determine, where strokes alone do not show it.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string model(const std::string& elements, const std::string& bonds, const std::string& outputs, double stop) {
  std::string list;
  std::istringstream words(bonds);
  for (std::string word; words >> word;) {
    const auto arrow = word.find('>');
    list += (list.empty() ? "" : ", ") + std::string(R"({"from": ")") + word.substr(0, arrow) + R"(", "to": ")" +
            word.substr(arrow + 1) + "\"}";
  }
  return R"({"bgsim": 1, "name": "ring", "elements": {)" + elements + R"(}, "bonds": [)" + list + R"(], "outputs": {)" +
         outputs + R"(}, "scenes": {"run": {"stop": )" + std::to_string(stop) + R"(, "samples": 11}}})";
}

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(compile_text(text));
  } catch (const ModelError& error) {
    return error.diagnostics.front().code + ": " + error.diagnostics.front().situation;
  }
  return "not refused";
}

}  // namespace

TEST_CASE("A ring that lets no flow through leaves an inertia the flow of the source") {
  // The 1-junction "loop" has the same effort on both sides, so its resistor takes none: no flow goes round.
  const RunResult run = run_text(model(R"x("drive": {"kind": "Sf", "flow": "sin(t)"}, "loop": {"kind": "1"},
      "left": {"kind": "0"}, "right": {"kind": "0"}, "loss": {"kind": "R", "resistance": 2},
      "coil": {"kind": "I", "inertance": 3})x",
                                       "loop>left left>right right>loop loop>loss drive>left left>coil",
                                       R"("e": "coil.e", "f": "coil.f", "lost": "loss.f")", 1.0));
  REQUIRE(run.stop == StopReason::completed);
  CHECK(run.report.states == 0);
  for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
    const double t = run.trace.times[i];
    CHECK(column(run, "f")[i] == Approx(std::sin(t)).margin(1e-15));  // a formula, evaluated once
    CHECK(column(run, "e")[i] == Approx(3.0 * std::cos(t)).epsilon(1e-15));
    CHECK(column(run, "lost")[i] == 0.0);
  }
}

TEST_CASE("Terms that cancel round a ring of TF and GY tie no store to its own rate") {
  // By hand: e_c = -r f for any modulus of the TF. With a parameter and with a number as modulus.
  for (const std::string n : {"-1.54", "\"1 + 2*t\""}) {
    const RunResult run = run_text(
        model(R"("pump": {"kind": "Sf", "flow": 1}, "in": {"kind": "1"}, "one": {"kind": "1"}, "two": {"kind": "1"},
      "node": {"kind": "0"}, "gear": {"kind": "TF", "modulus": )" +
                  n + R"(}, "spin": {"kind": "GY", "modulus": -3},
      "tank": {"kind": "C", "capacitance": 2, "initial": {"q": 6}})",
              "pump>in in>node node>gear gear>two one>spin spin>two one>node two>tank", R"("q": "tank.q")", 2.0));
    REQUIRE(run.stop == StopReason::completed);
    for (const double q : column(run, "q")) CHECK(q == Approx(6.0).epsilon(1e-14));
  }
}

TEST_CASE("Two bonds side by side are as one, and what runs round between them has no value") {
  const std::string elements = R"("left": {"kind": "0"}, "right": {"kind": "0"},
      "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "r": {"kind": "R", "resistance": 2})";
  const std::string bonds = "c>left left>right right>left right>r";
  const RunResult run = run_text(model(elements, bonds, R"("q": "c.q")", 2.0), with_relative(1e-10));
  REQUIRE(run.stop == StopReason::completed);
  CHECK(last(run, "q") == Approx(std::exp(-1.0)).epsilon(1e-8));  // some tens of steps within 1e-10 each
  CHECK(refusal(model(elements, bonds, R"("q": "c.q", "round": "b2.f")", 2.0)) ==
        "BG411: nothing determines b2.f: it runs round the ring of junctions at \"left\"");
  // A modulus within the ring asks, too.
  CHECK(refusal(model(elements + R"(, "gear": {"kind": "MTF", "modulus": "1 + b2.f"}, "end": {"kind": "0"},
      "s": {"kind": "R", "resistance": 1})",
                      bonds + " right>gear gear>end end>s", R"("q": "c.q")", 2.0)) ==
        "BG411: nothing determines b2.f: it runs round the ring of junctions at \"left\"");
}

TEST_CASE("Where strokes choose the right states, what runs round within the ring is left out all the same") {
  // "float" is bonded to "line" twice in opposite directions: its effort cancels, whatever it is.
  const RunResult run = run_text(
      model(R"("float": {"kind": "0"}, "line": {"kind": "1"}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
      "r": {"kind": "R", "resistance": 1})",
            "float>line line>float c>line line>r", R"("q": "c.q")", 1.0),
      with_relative(1e-10));
  REQUIRE(run.stop == StopReason::completed);
  CHECK(last(run, "q") == Approx(std::exp(-1.0)).epsilon(1e-8));
}

TEST_CASE("Rings beside each other, and rings with sources, have the solutions of their equations by hand") {
  // Two pairs of bonds one after the other: 1/(RC) = 1/2 + 1/3.
  CHECK(last(run_text(model(R"("x": {"kind": "0"}, "y": {"kind": "0"}, "z": {"kind": "0"},
      "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "r": {"kind": "R", "resistance": 2},
      "s": {"kind": "R", "resistance": 3})",
                            "x>y x>y y>z z>y x>c y>r z>s", R"("q": "c.q")", 1.0),
                      with_relative(1e-10)),
             "q") == Approx(std::exp(-5.0 / 6.0)).epsilon(1e-8));
  // GY of 2 there and 3 back: 1 - l - 2 r + 3 r = 0 and 2 l - 3 l - 4 r = 0.
  const RunResult gyrators =
      run_text(model(R"("l": {"kind": "1"}, "r": {"kind": "1"},
      "there": {"kind": "GY", "modulus": 2}, "back": {"kind": "GY", "modulus": 3}, "s": {"kind": "Se", "effort": 1},
      "one": {"kind": "R", "resistance": 1}, "four": {"kind": "R", "resistance": 4})",
                     "s>l l>one l>there there>r r>back back>l r>four", R"("l": "l.f", "r": "r.f")", 1.0));
  CHECK(last(gyrators, "l") == Approx(0.8).epsilon(1e-14));
  CHECK(last(gyrators, "r") == Approx(-0.2).epsilon(1e-14));
  // MTF whose moduli are each other's inverse in every state: q' = -q/(1 + q)^2, so ln q + 2 q + q^2/2 falls by 1.
  const RunResult inverse = run_text(model(R"x("x": {"kind": "0"}, "y": {"kind": "0"},
      "up": {"kind": "MTF", "modulus": "1 + c.q"}, "down": {"kind": "MTF", "modulus": "1/(1 + c.q)"},
      "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "r": {"kind": "R", "resistance": 1})x",
                                           "x>up up>y y>down down>x x>c y>r", R"("q": "c.q")", 1.0),
                                     with_relative(1e-10));
  const double q = last(inverse, "q");
  CHECK(std::log(q) + 2.0 * q + q * q / 2.0 == Approx(1.5).epsilon(1e-8));
  // Moduli that never multiply to 1 leave no effort: the coil keeps its flow.
  const RunResult shut = run_text(model(R"("x": {"kind": "0"}, "y": {"kind": "0"}, "up": {"kind": "TF", "modulus": 2},
      "down": {"kind": "TF", "modulus": 3}, "s": {"kind": "Sf", "flow": 1}, "r": {"kind": "R", "resistance": 1},
      "l": {"kind": "I", "inertance": 1, "initial": {"p": 0.5}})",
                                        "x>up up>y y>down down>x s>x y>r y>l", R"("e": "r.e", "p": "l.p")", 1.0));
  CHECK(last(shut, "e") == 0.0);
  CHECK(last(shut, "p") == 0.5);
  // Equal gears side by side repeat a constraint: m + 4 M = 13 against 4 b.
  CHECK(last(run_text(model(R"("x": {"kind": "1"}, "y": {"kind": "1"}, "one": {"kind": "TF", "modulus": 2},
      "two": {"kind": "TF", "modulus": 2}, "m": {"kind": "I", "inertance": 1, "initial": {"p": 1}},
      "M": {"kind": "I", "inertance": 3}, "b": {"kind": "R", "resistance": 1})",
                            "m>x x>one one>y x>two two>y y>M y>b", R"("f": "m.f")", 1.0),
                      with_relative(1e-10)),
             "f") == Approx(std::exp(-4.0 / 13.0)).epsilon(1e-8));
}

TEST_CASE("Moduli that are each other's inverse for any value of a parameter make no contradiction") {
  const auto two_gears = [](const std::string& one, const std::string& other) {
    std::string text = model(R"("left": {"kind": "0"}, "right": {"kind": "0"},
      "up": {"kind": "TF", "modulus": ")" +
                                 one + R"("}, "down": {"kind": "TF", "modulus": ")" + other +
                                 R"("}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
      "r": {"kind": "R", "resistance": 1})",
                             "left>up up>right right>down down>left left>c right>r", R"("q": "c.q")", 1.0);
    return text.insert(1, R"("parameters": {"n": 2, "m": 0.5}, )");
  };
  // The resistor is seen through the gear: r n^2 = 4.
  const RunResult run = run_text(two_gears("n", "1/n"), with_relative(1e-10));
  REQUIRE(run.stop == StopReason::completed);
  CHECK(last(run, "q") == Approx(std::exp(-0.25)).epsilon(1e-8));
  CHECK(last(run_text(two_gears("2", "1/2"), with_relative(1e-10)), "q") == Approx(std::exp(-0.25)).epsilon(1e-8));
}

TEST_CASE("A ring that determines what a source gives is refused with both") {
  CHECK(
      refusal(model(R"("source": {"kind": "Se", "effort": 1}, "left": {"kind": "1"}, "right": {"kind": "1"},
      "one": {"kind": "GY", "modulus": 1}, "two": {"kind": "GY", "modulus": 1})",
                    "source>left left>one one>right right>two two>left", R"("f": "source.f")", 1.0)) ==
      "BG411: the ring through \"one\", \"two\" leaves no effort but 0 to \"source\", which gives that effort itself");
}

TEST_CASE("Coils that form a cutset lose one current, also where only a ring of junctions shows it") {
  // The bridge of the ring modulator without its parasitic capacitances: four nodes, four coils from two taps, four
  // resistors in place of the diodes. The nodes' balances add up to I3 + I4 + I5 + I6 = 0.
  std::string elements = R"x("drive": {"kind": "Se", "effort": "sin(t)"}, "tap": {"kind": "0"}, "middle": {"kind": "0"},
      "load": {"kind": "R", "resistance": 1}, "hold": {"kind": "C", "capacitance": 1})x";
  std::string bonds = "drive>tap middle>load middle>hold";
  for (const char k : {'3', '4', '5', '6'}) {
    const std::string n(1, k);
    elements += R"(, "u)" + n + R"(": {"kind": "0"}, "coil)" + n + R"(": {"kind": "1"}, "L)" + n +
                R"(": {"kind": "I", "inertance": )" + std::to_string(k - '0') + "}";
    bonds += " coil" + n + ">L" + n;
    bonds +=
        k == '3' || k == '5' ? " tap>coil" + n + " coil" + n + ">u" + n : " u" + n + ">coil" + n + " coil" + n + ">tap";
  }
  const std::vector<std::vector<std::string>> ways{{"u3>d1", "d1>u5", "d1>middle"},
                                                   {"u6>d2", "d2>u4", "d2>middle"},
                                                   {"u4>d3", "u5>d3", "middle>d3"},
                                                   {"middle>d4", "d4>u3", "d4>u6"}};
  for (std::size_t d = 0; d < ways.size(); ++d) {
    const std::string n = std::to_string(d + 1);
    elements += R"(, "d)" + n + R"(": {"kind": "1"}, "D)" + n + R"(": {"kind": "R", "law": "f = e + 0.1*e^3"})";
    bonds += " d" + n + ">D" + n;
    for (const std::string& way : ways[d]) bonds += " " + way;
  }
  const CompiledModel compiled =
      compile_text(model(elements, bonds, R"("sum": "L3.f + L5.f - L4.f - L6.f", "f": "L3.f", "u": "hold.e")", 3.0));
  CHECK(compiled.program.dependent.size() == 1);
  const RunResult run = compiled.run();
  REQUIRE(run.stop == StopReason::completed);
  CHECK(std::abs(last(run, "f")) > 1e-3);
  CHECK(run.report.energy.relative < 1e-5);  // the tolerance is 1e-6
}
