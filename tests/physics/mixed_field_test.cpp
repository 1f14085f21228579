// Mixed fields: one energy over displacements and momenta.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A model with "from>to from>to" as bonds, over one scene of @p stop.
std::string model(const std::string& elements, const std::string& bonds, const std::string& outputs, double stop) {
  std::string list;
  std::istringstream words(bonds);
  for (std::string word; words >> word;) {
    const auto arrow = word.find('>');
    list += (list.empty() ? "" : ", ") + std::string(R"({"from": ")") + word.substr(0, arrow) + R"(", "to": ")" +
            word.substr(arrow + 1) + "\"}";
  }
  return R"({"bgsim": 1, "name": "mixed", "elements": {)" + elements + R"(}, "bonds": [)" + list +
         R"(], "outputs": {)" + outputs + R"(}, "scenes": {"run": {"stop": )" + std::to_string(stop) +
         R"(, "samples": 11}}})";
}

std::string refusal(const std::string& text, Method method) {
  SceneOverrides overrides;
  overrides.method = method;
  overrides.step = 1e-3;
  try {
    const RunResult run = run_text(text, overrides);
    if (run.failure) return run.failure->code;
  } catch (const ModelError& error) {
    return error.diagnostics.front().code;
  }
  return "not refused";
}

/// m x'' = -k x with m = 2, k = 8: cos(2 t), whatever the coupling c, which only shifts the momentum by c q.
std::string oscillator(const std::string& law, const std::string& bonds = "speed>f.x speed>f.l") {
  return model(R"("speed": {"kind": "1"}, "f": {"kind": "IC", "ports": {"x": "q", "l": "p"}, )" + law +
                   R"(, "initial": {"x.q": 1, "l.f": 0}})",
               bonds, R"("x": "f.x.q", "v": "f.l.f")", 3.0);
}

}  // namespace

TEST_CASE("A mixed field is an oscillator by itself, by its energy and by its laws, whatever its momentum is called") {
  for (const std::string law : {R"x("energy": "l.p^2/4 + 4*x.q^2")x", R"x("energy": "(l.p - 3*x.q)^2/4 + 4*x.q^2")x",
                                R"x("laws": ["x.e = 8*x.q - 1.5*(l.p - 3*x.q)", "l.f = (l.p - 3*x.q)/2"])x",
                                R"x("laws": ["x.e = 8*x.q - 3*l.f", "l.f = (l.p - 3*x.q)/2"])x"})
    for (const std::string bonds : {"speed>f.x speed>f.l", "f.x>speed speed>f.l", "f.l>speed f.x>speed"}) {
      INFO(law << ", " << bonds);
      const std::string text = oscillator(law, bonds);
      const RunResult run = run_text(text, with_relative(1e-10));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(run.report.notes.empty());
      // Some hundred steps within 1e-10 each. With one half-arrow turned round the momentum grows with the force: time
      // runs backwards, and the cosine stays.
      CHECK(last(run, "x") == Approx(std::cos(6.0)).epsilon(1e-7));
      CHECK(last(run, "v") == Approx((bonds == "f.x>speed speed>f.l" ? 2.0 : -2.0) * std::sin(6.0)).epsilon(1e-7));
      CHECK(run.report.energy.relative < 1e-8);
    }
}

TEST_CASE("Laws that come from no energy are recognised by the cross derivative between q and p") {
  const auto warned = [](const std::string& law) {
    const CompiledModel compiled = compile_text(oscillator(law));
    for (const Diagnostic& warning : compiled.study.causality().warnings)
      if (warning.code == "BG306") return true;
    return false;
  };
  CHECK_FALSE(warned(R"x("laws": ["x.e = 8*x.q - 1.5*(l.p - 3*x.q)", "l.f = (l.p - 3*x.q)/2"])x"));
  CHECK_FALSE(warned(R"x("laws": ["x.e = sin(x.q) + l.p^2*x.q", "l.f = 2*l.p*x.q^2/2 + l.p"])x"));
  CHECK(warned(R"x("laws": ["x.e = 8*x.q + 1.5*(l.p - 3*x.q)", "l.f = (l.p - 3*x.q)/2"])x"));
  CHECK(warned(R"x("laws": ["x.e = 8*x.q + l.p", "l.f = l.p/2"])x"));
}

TEST_CASE("A port of a mixed field may be in derivative causality, each by itself") {
  // H = p^2/2 + q p + q^2. The flow of l is imposed: p = f - q, so e at x is 2 q + p = q + f, and p' the effort.
  const RunResult momentum =
      run_text(model(R"x("f": {"kind": "IC", "ports": {"x": "q", "l": "p"},
      "energy": "l.p^2/2 + x.q*l.p + x.q^2", "initial": {"x.q": 1}}, "drive": {"kind": "Sf", "flow": "sin(t)"},
      "loop": {"kind": "1"}, "r": {"kind": "R", "resistance": 1})x",
                     "drive>f.l loop>f.x loop>r", R"("q": "f.x.q", "p": "f.l.p", "e": "f.l.e")", 2.0),
               with_relative(1e-10));
  REQUIRE(momentum.stop == StopReason::completed);
  // q' = -(q + sin t); the sum of the last check is a tenth of its terms.
  const double q = 0.5 * std::exp(-2.0) + 0.5 * (std::cos(2.0) - std::sin(2.0));
  CHECK(last(momentum, "q") == Approx(q).epsilon(1e-8));
  CHECK(last(momentum, "p") == Approx(std::sin(2.0) - q).epsilon(1e-8));
  CHECK(last(momentum, "e") == Approx(std::cos(2.0) + q + std::sin(2.0)).epsilon(1e-7));
  // The effort of x is imposed: 2 q + p = cos t, and f at l is p + q = (p + cos t)/2.
  const RunResult displacement = run_text(model(R"x("f": {"kind": "IC", "ports": {"x": "q", "l": "p"},
      "energy": "l.p^2/2 + x.q*l.p + x.q^2", "initial": {"l.p": 1}}, "drive": {"kind": "Se", "effort": "cos(t)"
  },
      "node": {"kind": "0"}, "r": {"kind": "R", "resistance": 1})x",
                                                "drive>f.x node>f.l node>r", R"("p": "f.l.p", "q": "f.x.q")", 2.0),
                                          with_relative(1e-10));
  // p' = -(p + cos t)/2
  const double p = 1.2 * std::exp(-1.0) - 0.2 * (std::cos(2.0) + 2.0 * std::sin(2.0));
  CHECK(last(displacement, "p") == Approx(p).epsilon(1e-8));
  CHECK(last(displacement, "q") == Approx((std::cos(2.0) - p) / 2.0).epsilon(1e-8));
}

TEST_CASE("Verlet takes an energy that is a sum over q and over p, and refuses others") {
  const std::string apart = oscillator(R"x("energy": "l.p^2/4 + 4*x.q^2")x");
  SceneOverrides verlet;
  verlet.method = Method::verlet;
  verlet.step = 1e-3;
  // Second order: the phase is off by (omega h)^2/24 of 6 rad.
  CHECK(last(run_text(apart, verlet), "x") == Approx(std::cos(6.0)).epsilon(3e-6));
  CHECK(refusal(apart, Method::verlet) == "not refused");
  CHECK(refusal(oscillator(R"x("energy": "(l.p - 3*x.q)^2/4 + 4*x.q^2")x"), Method::verlet) == "BG610");
}

TEST_CASE("Starts by velocities, at rest among them, are solved for coupled momenta") {
  const auto momenta = [](const std::string& one, const std::string& other) {
    const RunResult run = run_text(model(R"x("j": {"kind": "1"}, "k": {"kind": "1"}, "f": {"kind": "IC",
      "ports": {"a": "q", "la": "p", "b": "q", "lb": "p"},
      "energy": "(la.p^2 - 2*cos(a.q - b.q)*la.p*lb.p + 3*lb.p^2)/(2*(2 + sin(a.q - b.q)^2)) - cos(a.q)",
      "initial": {"a.q": 1, "b.q": 0.5, "la.f": )x" +
                                             one + R"x(, "lb.f": )x" + other + "}}",
                                         "j>f.a j>f.la k>f.b k>f.lb",
                                         R"("la": "f.la.p", "lb": "f.lb.p", "fa": "f.la.f", "fb": "f.lb.f")", 0.1));
    return std::array{column(run, "la").front(), column(run, "lb").front(), column(run, "fa").front(),
                      column(run, "fb").front()};
  };
  // The mass matrix is ((3, cos), (cos, 1)) with cos(1 - 0.5).
  const auto [la, lb, fa, fb] = momenta("0", "3");
  CHECK(la == Approx(3.0 * std::cos(0.5)).epsilon(1e-12));
  CHECK(lb == Approx(3.0).epsilon(1e-12));
  CHECK(fa == Approx(0.0).margin(1e-14));
  CHECK(fb == Approx(3.0).epsilon(1e-13));
  for (const double value : momenta("0", "0")) CHECK(value == 0.0);
  CHECK(momenta("\"0.1 + 0.2 - 0.3\"", "1")[1] == Approx(1.0).epsilon(1e-12));
}

TEST_CASE("The double pendulum moves as four masses on transformers do") {
  // Angular velocities are the independent ones; x1 = l1 sin a, x2 = x1 + l2 sin b, and y likewise.
  const std::string text = R"x({"bgsim": 1, "name": "masses", "parameters": {"m1": 2, "m2": 1, "l1": 1, "l2": 0.7},
    "elements": {"wa": {"kind": "1"}, "wb": {"kind": "1"}, "x2": {"kind": "0"}, "y2": {"kind": "0"},
      "a": {"kind": "C", "law": "e = (m1 + m2)*9.81*l1*sin(q)", "initial": {"q": 1}},
      "b": {"kind": "C", "law": "e = m2*9.81*l2*sin(q)", "initial": {"q": 0.5}},
      "ax": {"kind": "MTF", "modulus": "l1*cos(a.q)"}, "ay": {"kind": "MTF", "modulus": "l1*sin(a.q)"},
      "bx": {"kind": "MTF", "modulus": "l2*cos(b.q)"}, "by": {"kind": "MTF", "modulus": "l2*sin(b.q)"},
      "jx": {"kind": "1"}, "jy": {"kind": "1"},
      "m1x": {"kind": "I", "inertance": "m1"}, "m1y": {"kind": "I", "inertance": "m1"},
      "m2x": {"kind": "I", "inertance": "m2", "initial": {"f": "0.7*cos(0.5)"}},
      "m2y": {"kind": "I", "inertance": "m2", "initial": {"f": "0.7*sin(0.5)"}}},)x" +
                           std::string(R"x("bonds": [
      {"from": "wa", "to": "a"}, {"from": "wb", "to": "b"}, {"from": "wa", "to": "ax"}, {"from": "wa", "to": "ay"},
      {"from": "wb", "to": "bx"}, {"from": "wb", "to": "by"}, {"from": "ax", "to": "jx"}, {"from": "ay", "to": "jy"},
      {"from": "jx", "to": "m1x"}, {"from": "jy", "to": "m1y"}, {"from": "jx", "to": "x2"}, {"from": "bx", "to": "x2"},
      {"from": "jy", "to": "y2"}, {"from": "by", "to": "y2"}, {"from": "x2", "to": "m2x"}, {"from": "y2", "to": "m2y"}],
    "outputs": {"a": "a.q", "b": "b.q", "omega_a": "wa.f", "omega_b": "wb.f"},
    "scenes": {"run": {"stop": 0.25, "samples": 11}}})x");
  const RunResult masses = run_text(text, with_relative(1e-10));
  REQUIRE(masses.stop == StopReason::completed);
  const Study study = study_of("models/double_pendulum.json");
  Model shorter = study.model();
  ReadOptions options;
  options.stop = "0.25";
  options.samples = 11;
  const RunResult field =
      compile_model(std::make_shared<const Model>(read_model(BGSIM_SOURCE_DIR "/models/double_pendulum.json", options)))
          .run();
  // Some hundred steps within 1e-10 on each side.
  for (const std::string name : {"a", "b", "omega_a", "omega_b"})
    CHECK(last(field, name) == Approx(last(masses, name)).epsilon(1e-7));
}

TEST_CASE("The plate of the transducer stays up to the pull-in voltage, and not above it") {
  const auto resting = [](double part) {
    SceneOverrides overrides;
    overrides.set = {"part=" + std::to_string(part)};
    overrides.relative = 1e-8;
    ReadOptions options;
    options.stop = "0.1";
    options.samples = 2;
    const auto read = std::make_shared<const Model>(read_model(BGSIM_SOURCE_DIR "/models/transducer.json", options));
    const RunResult run = compile_model(read, overrides).run();
    REQUIRE(run.stop == StopReason::completed);
    return last(run, "x") / 1e-5;
  };
  // In units of the gap: x (1 - x)^2 = 4/27 part^2 at rest, and no solution below 1 for part > 1.
  for (const double part : {0.3, 0.9, 0.998}) {
    const double x = resting(part);
    CHECK(x < 1.0 / 3.0);
    CHECK(x * (1.0 - x) * (1.0 - x) == Approx(4.0 / 27.0 * part * part).epsilon(1e-6));
  }
  CHECK(resting(1.002) > 0.69);
}
