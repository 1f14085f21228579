// The start: moduli that are zero there, and given initial values that only rounding parts.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// "bonds" from a list of FROM>TO.
std::string bonds_text(const std::string& bonds) {
  std::string list;
  std::istringstream words(bonds);
  for (std::string word; words >> word;) {
    const auto arrow = word.find('>');
    list += (list.empty() ? "" : ", ") + std::string(R"({"from": ")") + word.substr(0, arrow) + R"(", "to": ")" +
            word.substr(arrow + 1) + "\"}";
  }
  return R"("bonds": [)" + list + "]";
}

std::string failure(const std::string& text) {
  try {
    const RunResult run = run_text(text);
    return run.failure ? "run: " + run.failure->code + " " + run.failure->situation : "completed";
  } catch (const ModelError& error) {
    return error.diagnostics.front().code + " " + error.diagnostics.front().situation;
  }
}

}  // namespace

TEST_CASE("Moduli that are zero at the start are not divided by") {
  // A bob on a rod, held level: x = 1, y = 0. The rod's constraint x vx + y vy = 0 gives vx from vy, not the other way.
  const auto bob = [](const std::string& first, const std::string& second) {
    const std::string inertia = R"(": {"kind": "I", "inertance": 1}, )";
    return R"({"bgsim": 1, "name": "bob", "elements": {"m)" + first + inertia + "\"m" + second + inertia +
           R"("vx": {"kind": "1"}, "vy": {"kind": "1"}, "x": {"kind": "C", "law": "e = 0*q", "initial": {"q": 1}},
      "y": {"kind": "C", "law": "e = 0*q"}, "weight": {"kind": "Se", "effort": -9.81},
      "ax": {"kind": "MTF", "modulus": "x.q"}, "ay": {"kind": "MTF", "modulus": "y.q"}, "rod": {"kind": "0"},
      "rigid": {"kind": "Sf", "flow": 0}},)" +
           bonds_text("vx>mx vx>x vy>my vy>y weight>vy vx>ax ax>rod vy>ay ay>rod rod>rigid") +
           R"(, "outputs": {"x": "x.q", "y": "y.q", "energy": "(mx.f^2 + my.f^2)/2 + 9.81*y.q"},
      "scenes": {"run": {"stop": 0.4, "samples": 11}}})";
  };
  for (const auto& [first, second] : {std::pair("x", "y"), std::pair("y", "x")}) {
    const RunResult run = run_text(bob(first, second), with_relative(1e-9));
    REQUIRE(run.stop == StopReason::completed);
    // some hundred steps within 1e-9 each
    CHECK(std::hypot(last(run, "x"), last(run, "y")) == Approx(1.0).epsilon(1e-7));
    CHECK(last(run, "energy") == Approx(0.0).margin(1e-6));
    CHECK(last(run, "y") < -0.6);
  }
}

TEST_CASE("The car axis finds its independent masses by itself") {
  // Mazzia, Magherini: Test Set for Initial Value Problem Solvers, release 2.4: an index-3 problem. Two masses on
  // springs, a rod between them and a rod to the left wheel; both rods' constraints on the level of velocities. The
  // rods stand so that some choices of two independent masses divide by 0.
  const std::string text = R"x({"bgsim": 1, "name": "car_axis",
    "parameters": {"L0": 0.5, "r": 0.1, "w": 10, "g": 1, "k": "10*0.01^2/2"},
    "signals": {"yb": "r*sin(w*t)", "xb": "sqrt(1 - yb^2)", "xl": "Xl.q", "yl": "Yl.q", "xr": "Xr.q", "yr": "Yr.q",
      "Ll": "sqrt(xl^2 + yl^2)", "Lr": "sqrt((xr - xb)^2 + (yr - yb)^2)"},
    "elements": {"vxl": {"kind": "1"}, "vyl": {"kind": "1"}, "vxr": {"kind": "1"}, "vyr": {"kind": "1"},
      "hinge": {"kind": "0"}, "rod": {"kind": "0"}, "rigid": {"kind": "Sf", "flow": 0},
      "Mxl": {"kind": "I", "inertance": "k", "initial": {"p": "-0.5*k"}}, "Myl": {"kind": "I", "inertance": "k"},
      "Mxr": {"kind": "I", "inertance": "k", "initial": {"p": "-0.5*k"}}, "Myr": {"kind": "I", "inertance": "k"},
      "Xl": {"kind": "C", "law": "e = 0*q"}, "Yl": {"kind": "C", "law": "e = 0*q", "initial": {"q": 0.5}},
      "Xr": {"kind": "C", "law": "e = 0*q", "initial": {"q": 1}},
      "Yr": {"kind": "C", "law": "e = 0*q", "initial": {"q": 0.5}},
      "Fxl": {"kind": "MSe", "effort": "(L0 - Ll)*xl/Ll"}, "Fyl": {"kind": "MSe", "effort": "(L0 - Ll)*yl/Ll - k*g"},
      "Fxr": {"kind": "MSe", "effort": "(L0 - Lr)*(xr - xb)/Lr"},
      "Fyr": {"kind": "MSe", "effort": "(L0 - Lr)*(yr - yb)/Lr - k*g"},
      "h1": {"kind": "MTF", "modulus": "xb"}, "h2": {"kind": "MTF", "modulus": "yb"},
      "wheel": {"kind": "MSf", "flow": "-(der(xb)*xl + der(yb)*yl)"},
      "r1": {"kind": "MTF", "modulus": "xl - xr"}, "r2": {"kind": "MTF", "modulus": "yl - yr"},
      "r3": {"kind": "MTF", "modulus": "xr - xl"}, "r4": {"kind": "MTF", "modulus": "yr - yl"}},)x" +
                           bonds_text(
                               "Fxl>vxl vxl>Mxl vxl>Xl Fyl>vyl vyl>Myl vyl>Yl Fxr>vxr vxr>Mxr vxr>Xr Fyr>vyr vyr>Myr "
                               "vyr>Yr vxl>h1 h1>hinge vyl>h2 h2>hinge hinge>wheel vxl>r1 r1>rod vyl>r2 r2>rod vxr>r3 "
                               "r3>rod vyr>r4 r4>rod rod>rigid") +
                           R"(, "outputs": {"xl": "xl", "yl": "yl", "xr": "xr", "yr": "yr"},
    "scenes": {"run": {"stop": 3, "samples": 11}}})";
  const RunResult run = run_text(text, with_relative(1e-9));
  REQUIRE(run.stop == StopReason::completed);
  // The published digits at t = 3. The constraints drift by the sum of some thousand steps' errors.
  CHECK(last(run, "xl") == Approx(0.04934557842755629).epsilon(1e-5));
  CHECK(last(run, "yl") == Approx(0.4969894602303324).epsilon(1e-5));
  CHECK(last(run, "xr") == Approx(1.041742524885400).epsilon(1e-5));
  CHECK(last(run, "yr") == Approx(0.3739110272652214).epsilon(1e-5));
}

TEST_CASE("What is given at the start holds, in any order of the file, and other stores follow") {
  // Three inertias on gears of 2 and 3, one of which starts with a momentum: 1 + 4 + 36 against a damping of 36.
  const std::vector<std::string> inertias{R"("one": {"kind": "I", "inertance": 1})",
                                          R"("two": {"kind": "I", "inertance": 1})",
                                          R"("three": {"kind": "I", "inertance": 1})"};
  const std::string rest = R"("a": {"kind": "1"}, "b": {"kind": "1"}, "c": {"kind": "1"},
      "ab": {"kind": "TF", "modulus": 2}, "bc": {"kind": "TF", "modulus": 3}, "r": {"kind": "R", "resistance": 1}},)";
  std::vector<std::size_t> order{0, 1, 2};
  do {
    for (const bool by_scene : {false, true}) {
      std::string text = R"({"bgsim": 1, "name": "gears", "elements": {)";
      for (const std::size_t i : order) {
        std::string inertia = inertias[i];
        if (i == 0 && !by_scene) inertia.insert(inertia.size() - 1, R"(, "initial": {"p": 1})");
        text += inertia + ", ";
      }
      text += rest + bonds_text("a>ab ab>b b>bc bc>c a>one b>two c>three c>r") +
              R"(, "outputs": {"f": "one.f"}, "scenes": {"run": {"stop": 1)" +
              (by_scene ? R"(, "initial": {"one.f": 1}}}})" : "}}}");
      INFO(text);
      const RunResult run = run_text(text, with_relative(1e-9));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(last(run, "f") == Approx(std::exp(-36.0 / 41.0)).epsilon(1e-7));
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("What roundings leave of a difference contradicts nothing at the start") {
  const auto two = [](const std::string& one, const std::string& other) {
    return R"({"bgsim": 1, "name": "two", "parameters": {"a": 0.1, "b": 0.2, "c": 0.3, "v": "0.1 + 0.2 - 0.3",
    "w": "a + b - c"}, "elements": {"n": {"kind": "0"},
    "one": {"kind": "C", "capacitance": 1, "initial": {"q": )" +
           one + R"(}}, "other": {"kind": "C", "capacitance": 2, "initial": {"q": )" + other + R"(}},
    "fill": {"kind": "Sf", "flow": 3}}, "bonds": [{"from": "n", "to": "one"}, {"from": "n", "to": "other"},
    {"from": "fill", "to": "n"}], "outputs": {"u": "one.e"}, "scenes": {"run": {"stop": 2}}})";
  };
  for (const auto& [one, other] : {std::pair("0", R"("2*v")"), std::pair("0", R"("2*w")"), std::pair(R"("w")", "0"),
                                   std::pair(R"("v")", R"("2*w")")}) {
    INFO(one << " and " << other);
    CHECK(failure(two(one, other)) == "completed");
  }
  // The same given as voltages, from which the charges follow by the laws.
  const auto as_voltages = [&](const std::string& one, const std::string& other) {
    std::string text = two(one, other);
    for (auto at = text.find("\"q\""); at != std::string::npos; at = text.find("\"q\"")) text[at + 1] = 'e';
    return failure(text);
  };
  CHECK(as_voltages("0", R"("w")") == "completed");
  CHECK(as_voltages(R"("v")", "0") == "completed");
  CHECK(as_voltages("0.3", R"("a + b")") == "completed");
  CHECK(as_voltages("0", "1e-16").substr(0, 5) == "BG405");
  CHECK(as_voltages(R"("w")", R"("w + 1e-14")").substr(0, 5) == "BG405");
  CHECK(failure(two("0", "1e-16")).substr(0, 5) == "BG405");
  CHECK(failure(two("0", R"("2*w + 1e-14")")).substr(0, 5) == "BG405");
}
