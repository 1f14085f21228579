// Passivity: what is proved, refuted, and left open.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

Passivity of(const std::string& resistor, const std::string& store = R"("capacitance": 1)",
             const std::string& signals = R"x("u": "sin(c.q)", "x": "c.q", "w": "x^2")x",
             const std::string& effort = "1") {
  const Study study = Study::from_text(model_text(R"x("parameters": { "a": 2 }, "signals": {)x" + signals + R"x(},
    "elements": { "r": { )x" + resistor + R"x( }, "c": { "kind": "C", )x" +
                                                  store + R"x( },
      "i": { "kind": "I", "inertance": 1 }, "s": { "kind": "MSe", "effort": ")x" +
                                                  effort + R"x(" }, "one": { "kind": "1" } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "c" },
      { "from": "one", "to": "i" } ], "outputs": { "f": "r.f" }, "scenes": { "s": { "stop": 1 } })x"));
  return passivity(study.model(), prepare_scene(study.model(), ""));
}

PassivityFinding resistor(const std::string& law, bool modulated = false) {
  const std::string kind = modulated ? "MR" : "R";
  return of(R"("kind": ")" + kind + R"(", "law": ")" + law + '"').resistors.at(0);
}

PassivityFinding store(const std::string& law) {
  const Passivity found = of(R"("kind": "R", "resistance": "a")", R"("law": ")" + law + '"');
  return found.stores.at(0);
}

}  // namespace

TEST_CASE("resistors whose power has one sign everywhere are proved") {
  for (const char* law : {"e = a*f", "e = 0*f", "e = a*f + 3*f^3", "e = f^3", "e = 3*f*abs(f)", "f = ssqrt(e, 1e-3)",
                          "e = 1e-300*f", "f = if(e > 0, sqrt(e), -sqrt(-e))", "f = if(e > 0, e/0.1, e/1e6)",
                          "e = sign(f)*0.3 + tanh(f)", "e = sign(f)*(0.3 + 0.2*exp(-abs(f)))", "e = f*(1 + 0.9*cos(f))",
                          "e = f - 0.5*sin(f)", "f = 1e-12*expm1(e/0.025)", "e = (1 + 0.5*sin(t))*f"}) {
    INFO(law);
    CHECK(resistor(law).proof == Proof::proved);
  }
  CHECK(resistor("e = (1.5 + u)*f", true).proof == Proof::proved);
  CHECK(resistor("e = w*f", true).proof == Proof::proved);
}

TEST_CASE("resistors that give power are refuted with an interval in which they do", "[long]") {
  const auto power = [](const PassivityFinding& found, const auto& law) {
    REQUIRE(found.proof == Proof::refuted);
    // Its ends and its middle, as far as they are finite.
    for (const double part : {1e-6, 0.5, 1.0 - 1e-6}) {
      const double to = std::isinf(found.to) ? 1e6 : found.to, from = std::isinf(found.from) ? -1e6 : found.from;
      const double x = from + part * (to - from);
      CHECK(x * law(x) < 0.0);
    }
  };
  power(resistor("e = -a*f"), [](double f) { return -2 * f; });
  power(resistor("e = f^3/3 - f"), [](double f) { return f * f * f / 3 - f; });
  power(resistor("e = f + 0.001"), [](double f) { return f + 0.001; });
  power(resistor("e = f*(1 - 1.001*exp(-(f - 1000)^2))"),
        [](double f) { return f * (1 - 1.001 * std::exp(-(f - 1000) * (f - 1000))); });
  power(resistor("e = f*(1 + 1.1*cos(f))"), [](double f) { return f * (1 + 1.1 * std::cos(f)); });
  const PassivityFinding pol = resistor("e = f^3/3 - f");
  CHECK(pol.variable == "f");
  CHECK(std::max(std::abs(pol.from), std::abs(pol.to)) == Approx(std::sqrt(3.0)).epsilon(1e-6));
}

TEST_CASE("what is not decided is not claimed", "[long]") {
  // exp(e) - 1 is rounded where e is small.
  const PassivityFinding diode = resistor("f = 1e-12*(exp(e/0.025) - 1)");
  CHECK(diode.proof == Proof::undecided);
  CHECK(diode.variable == "e");
  CHECK(std::abs(diode.to) < 1e-15);
  CHECK(resistor("e = x*f", true).proof == Proof::undecided);
  CHECK(resistor("e = (0.5 + u)*f", true).proof == Proof::undecided);
  for (const char* law :
       {"e = sin(q)", "e = q - q^3", "e = 1/q", "e = 1/(1 - q)", "e = -q", "e = 9.81", "e = -1/(1 + q^2)"}) {
    INFO(law);
    CHECK(store(law).proof == Proof::undecided);
  }
}

TEST_CASE("stores whose law turns back far away have a lower bound of energy") {
  for (const char* law : {"e = 2*q", "e = q^3 - q", "q = e + e^3", "e = q - 5*sin(q)"}) {
    INFO(law);
    CHECK(store(law).proof == Proof::proved);
  }
}

TEST_CASE("a field given by an energy has that as its bound, and a modulated store has none") {
  const auto field = [](const std::string& energy) {
    const Study study = Study::from_text(model_text(R"x("signals": { "u": "sin(t)" },
      "elements": { "x": { "kind": "CC", "ports": ["a", "b"], "energy": ")x" +
                                                    energy + R"x(" }, "r": { "kind": "R", "resistance": 1 },
        "one": { "kind": "1" } },
      "bonds": [ { "from": "x.a", "to": "one" }, { "from": "x.b", "to": "one" }, { "from": "one", "to": "r" } ],
      "outputs": { "f": "r.f" }, "scenes": { "s": { "stop": 1 } })x"));
    return passivity(study.model(), prepare_scene(study.model(), "")).stores.at(0).proof;
  };
  CHECK(field("a.q^2 + (a.q - b.q)^2/2") == Proof::proved);
  CHECK(field("a.q^2 + b.q^4 - 3") == Proof::proved);
  CHECK(field("a.q^2 - b.q^2") == Proof::undecided);
  CHECK(field("a.q^2 + (2 + u)*b.q^2") == Proof::undecided);
}

TEST_CASE("a contact is proved if its gap stands and what it hits alone does not gain") {
  const auto stop = [](const std::string& keys) {
    const Study study =
        Study::from_text(model_text(R"x("parameters": { "width": 0.3 }, "signals": { "room": "width/3" },
      "elements": { "mass": { "kind": "I", "inertance": 1 },
      "wall": { "kind": "contact", )x" +
                                    keys + R"x( }, "move": { "kind": "1" } },
      "bonds": [ { "from": "move", "to": "mass" }, { "from": "move", "to": "wall" } ],
      "outputs": { "v": "mass.f" }, "scenes": { "s": { "stop": 1 } })x"));
    return passivity(study.model(), prepare_scene(study.model(), "")).others.at(0).proof;
  };
  CHECK(stop(R"("gap": 1)") == Proof::proved);
  CHECK(stop(R"("gap": "2*width")") == Proof::proved);  // of a parameter
  CHECK(stop(R"("gap": "room")") == Proof::proved);     // of a signal of parameters
  CHECK(stop(R"("gap": 1, "restitution": 0.5)") == Proof::proved);
  CHECK(stop(R"x("gap": "1 + 0.1*sin(t)")x") == Proof::undecided);
}

TEST_CASE("a model is passive if all of it is proved and no source is driven by its states") {
  const std::string r = R"("kind": "R", "resistance": "a")";
  const Passivity free = of(r);
  CHECK(free.holds());
  CHECK(free.sources == std::vector<std::string>{"s"});
  const Passivity driven = of(r, R"("capacitance": 1)", R"("u": "t + 1", "v": "-3*i.f + u")", "v");
  CHECK(driven.driven == std::vector<std::string>{"s"});
  CHECK(!driven.holds());
  const Passivity timed = of(r, R"("capacitance": 1)", R"x("u": "sin(t)")x", "2*u");
  CHECK(timed.holds());
  CHECK(!of(R"("kind": "R", "resistance": "-a")").holds());
}

namespace {

PassivityFinding field(const std::string& one, const std::string& two,
                       const std::string& signals = R"x("w": "c.q^2")x") {
  const Study study =
      Study::from_text(model_text(R"x("parameters": { "a": 2, "g": 1 }, "signals": {)x" + signals + R"x(},
    "elements": { "r": { "kind": "RR", "ports": ["l", "m"], "laws": [")x" +
                                  one + R"x(", ")x" + two + R"x("] },
      "c": { "kind": "C", "capacitance": 1 }, "d": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "c", "to": "r.l" }, { "from": "d", "to": "r.m" } ], "outputs": { "q": "c.q" },
    "scenes": { "s": { "stop": 1 } })x"));
  return passivity(study.model(), prepare_scene(study.model(), "")).resistors.at(0);
}

}  // namespace

TEST_CASE("resistive fields: linear ones by their matrix, exactly") {
  // A conductance between two ports has an eigenvalue of 0; 0.1 + 0.2 is not 0.3.
  CHECK(field("l.f = g*(l.e - m.e)", "m.f = g*(m.e - l.e)").proof == Proof::proved);
  CHECK(field("l.f = 0.1*(l.e - m.e)", "m.f = 0.1*(m.e - l.e)").proof == Proof::proved);
  CHECK(field("l.f = a*m.e", "m.f = -a*l.e").proof == Proof::proved);  // a gyrator
  CHECK(field("l.f = a*l.e + 3*m.e", "m.f = -2*l.e + 0.125*m.e").proof ==
        Proof::proved);                                                     // symmetric part [2 .5; .5 .125]
  CHECK(field("l.f = a*l.e", "m.e = l.f + a*m.f").proof == Proof::proved);  // 2 l.e^2 + 2 l.e m.f + 2 m.f^2
  const PassivityFinding wrong = field("l.f = a*l.e + 3*m.e", "m.f = -2*l.e + 0.1249*m.e");
  CHECK(wrong.proof == Proof::refuted);
  CHECK_THAT(wrong.reason, Catch::Contains("the sum of e f is negative at l.e = "));
  CHECK(field("l.f = g*l.e", "m.f = l.e").proof == Proof::refuted);
}

TEST_CASE("resistive fields: others by boxes of all their variables", "[long]") {
  CHECK(field("l.f = l.e^3", "m.f = sign(m.e)").proof == Proof::proved);
  CHECK(field("l.f = l.e*(1 + m.e^2)", "m.f = m.e*exp(l.e)").proof == Proof::proved);
  CHECK(field("l.f = l.e*m.e^2", "m.f = -l.e^2*m.e").proof == Proof::undecided);  // 0 throughout, but not term by term
  CHECK(field("l.f = (1 + w)*l.e", "m.f = w*m.e*abs(l.e)").proof == Proof::proved);
  CHECK(field("l.f = l.e^3", "m.f = -m.e^3").proof == Proof::refuted);
  // A transistor: whatever drives its base, the collector may give.
  const PassivityFinding transistor = field("l.f = 1e-8*expm1(l.e/0.026)", "m.f = 1e-6*expm1(l.e/0.026)");
  CHECK(transistor.proof == Proof::refuted);
  CHECK_THAT(transistor.reason, Catch::Contains("the sum of e f is negative at l.e = "));
}
