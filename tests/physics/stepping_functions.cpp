// floor, ceil, round and mod of states and of time: their jumps are events, so that what they feed is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// q = 2.9 sin(t), which grazes no whole number; y integrates @p flow.
std::string wave(const std::string& flow) {
  return R"json({ "bgsim": 1, "name": "wave",
    "elements": {
      "drive": { "kind": "Sf", "flow": "2.9*cos(t)" }, "c": { "kind": "C", "capacitance": 1 },
      "feed": { "kind": "MSf", "flow": ")json" +
         flow + R"json(" }, "y": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [ { "from": "drive", "to": "c" }, { "from": "feed", "to": "y" } ],
    "outputs": { "y": "y.q", "fed": "feed.f" },
    "scenes": { "main": { "stop": "2*pi", "samples": 9 } } })json";
}

double fed(const std::string& flow) { return column(run_text(wave(flow), with_relative(1e-9)), "y").back(); }

constexpr double kPi = std::numbers::pi;
constexpr double kError = 1e-7;  // a hundred times the relative tolerance, over some ten events

}  // namespace

TEST_CASE("round of a state switches at the halves on both sides of zero") {
  double half = 0.0;  // over 0 <= t <= pi
  for (const double level : {0.5, 1.5, 2.5}) half += kPi - 2.0 * std::asin(level / 2.9);
  CHECK(fed("round(c.q)") == Approx(0.0).margin(kError));
  CHECK(fed("max(round(c.q), 0)") == Approx(half).margin(kError));
  CHECK(fed("min(round(c.q), 0)") == Approx(-half).margin(kError));
}

TEST_CASE("floor and ceil of a state lie one apart") {
  double half = 0.0;
  for (const double level : {1.0, 2.0}) half += kPi - 2.0 * std::asin(level / 2.9);
  CHECK(fed("max(floor(c.q), 0)") == Approx(half).margin(kError));
  CHECK(fed("min(ceil(c.q), 0)") == Approx(-half).margin(kError));
  CHECK(fed("ceil(c.q) - floor(c.q)") == Approx(2.0 * kPi).margin(kError));
}

TEST_CASE("mod of a state lies between zero and its second argument") {
  // floor(q) is -1 more than -ceil of the other half wave, so that its mean is -1/2
  CHECK(fed("mod(c.q, 1)") == Approx(kPi).margin(kError));
  CHECK(fed("mod(c.q, -1)") == Approx(-kPi).margin(kError));
  CHECK(fed("mod(c.q, 1) + mod(-c.q, 1)") == Approx(2.0 * kPi).margin(kError));
}

TEST_CASE("steps of a sawtooth of time are all taken, whichever number the sawtooth begins again at") {
  // A tooth of floor(mod(3 t, 1.7)) is 0 up to 1 and 1 up to 1.7: 11 of them in 2 pi, and a rest below 1.
  CHECK(fed("floor(mod(3*t, 1.7))") == Approx(11 * 0.7 / 3.0).margin(kError));
  CHECK(fed("floor(3*mod(1.3*t, 1))") == Approx(8 / 1.3).margin(kError));
  const double rest = 0.7 * 2.0 * kPi - 3 * 1.3;  // below a half
  CHECK(fed("ceil(2*mod(0.7*t, 1.3))") == Approx((3 * (0.5 + 1.0 + 0.9) + rest) / 0.7).margin(kError));
  // 3/6 of a period of 1/1.3, and every period from there on: (k + 0.5)/1.3 < 6 for k = 0 to 7.
  const RunResult run = run_text(R"json({ "bgsim": 1, "name": "commutation",
    "signals": { "n": { "integral": "0" } },
    "elements": { "i": { "kind": "MSf", "flow": "n" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "i", "to": "c" } ],
    "events": { "turn": { "when": "floor(6*mod(1.3*t, 1)) >= 3", "set": { "n": "pre(n) + 1" } } },
    "outputs": { "n": "n" }, "scenes": { "main": { "stop": 6, "samples": 7 } } })json");
  CHECK(column(run, "n").back() == 8.0);
}

TEST_CASE("mod, round and ceil of time switch at known times") {
  // over 2 pi: 15 whole teeth of 0.4 and one of 2 pi - 6
  const double rest = 2.0 * kPi - 6.0;
  CHECK(fed("mod(t, 0.4)") == Approx(15 * 0.08 + rest * rest / 2.0).margin(kError));
  CHECK(fed("ceil(t)") == Approx(21.0 + 7.0 * rest).margin(kError));
  CHECK(fed("round(t)") == Approx(15.0 + 3.0 + 6.0 * rest).margin(kError));
  CHECK(fed("round(-t)") == Approx(-18.0 - 6.0 * rest).margin(kError));
}

TEST_CASE("a state that rests at a half is rounded away from zero") {
  const auto rounded = [](const std::string& initial) {
    return column(run_text(R"json({ "bgsim": 1, "name": "rest",
      "elements": { "s": { "kind": "Sf", "flow": 0 },
        "c": { "kind": "C", "capacitance": 1, "initial": { "q": )json" +
                           initial + R"json( } } },
      "bonds": [ { "from": "s", "to": "c" } ],
      "outputs": { "r": "round(c.q)", "u": "ceil(c.q)", "m": "mod(c.q, 0.5)" },
      "scenes": { "main": { "stop": 1, "samples": 2 } } })json"),
                  "r")
        .back();
  };
  CHECK(rounded("-0.5") == -1.0);
  CHECK(rounded("0.5") == 1.0);
  CHECK(rounded("-2.5") == -3.0);
  CHECK(rounded("2.4999999") == 2.0);
}

TEST_CASE("laws with inverse hyperbolic functions are turned round in closed form") {
  // a diode e = v log1p(f/i), asked for its flow: f = i expm1(e/v)
  const auto result = run_text(R"json({ "bgsim": 1, "name": "diode",
    "elements": { "source": { "kind": "Se", "effort": "0.3*sin(t)" },
      "d": { "kind": "R", "law": "e = 0.026*log1p(f/1e-9)" }, "r": { "kind": "R", "law": "e = asinh(f)" },
      "z": { "kind": "0" } },
    "bonds": [ { "from": "source", "to": "z" }, { "from": "z", "to": "d" }, { "from": "z", "to": "r" } ],
    "outputs": { "d": "d.f", "r": "r.f" },
    "scenes": { "main": { "stop": 6, "samples": 13 } } })json");
  CHECK(result.report.loops == 0);
  for (std::size_t i = 0; i < 13; ++i) {
    const double e = 0.3 * std::sin(0.5 * static_cast<double>(i));
    CHECK(column(result, "d")[i] == Approx(1e-9 * std::expm1(e / 0.026)).epsilon(1e-13));
    CHECK(column(result, "r")[i] == Approx(std::sinh(e)).epsilon(1e-13));
  }
}

TEST_CASE("a denominator that passes zero inside a function is reported, unless the numerator does so too") {
  // 2 - 2.9 sin(t) passes zero at t = asin(2/2.9)
  for (const std::string f :
       {"log1p(2 - c.q)", "expm1(2 - c.q)", "asinh(2 - c.q)", "atanh((2 - c.q)/9)", "log(3 - c.q)", "log10(3 - c.q)",
        "tanh(2 - c.q)", "sinh(2 - c.q)", "atan(2 - c.q)", "asin((2 - c.q)/9)"}) {
    CAPTURE(f);
    const RunResult result = run_text(wave("1/" + f));
    REQUIRE(result.failure);
    CHECK(result.failure->code == "BG613");
    CHECK_FALSE(run_text(wave("(2 - c.q)/" + (f.find("log(") == 0 || f.find("log10") == 0 ? "(2 - c.q)" : f))).failure);
  }
}

TEST_CASE("a denominator of time that passes zero ends a run only where the law has no bound") {
  const auto low_pass = [](const std::string& effort) {
    return R"j({ "bgsim": 1, "name": "low_pass", "elements": { "s": { "kind": "MSe", "effort": ")j" + effort +
           R"j(" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
    "outputs": { "x": "c.e" }, "scenes": { "main": { "stop": 2, "samples": 5 } } })j";
  };
  const auto response = [](const std::function<double(double)>& effort) {  // at t = 2, by Simpson's rule
    double sum = 0.0;
    constexpr int kParts = 200'000;
    for (int i = 0; i <= kParts; ++i) {
      const double t = 2.0 * i / kParts;
      sum += (i == 0 || i == kParts ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * effort(t) * std::exp(t - 2.0);
    }
    return sum * 2.0 / kParts / 3.0;
  };
  const struct {
    std::string effort;
    std::function<double(double)> value;
  } members[] = {
      {"if(t < 1, 1/(1.5 - t), 0)", [](double t) { return t < 1.0 ? 1.0 / (1.5 - t) : 0.0; }},
      {"if(t < 1, 1, 1/(t - 0.5)^2)", [](double t) { return t < 1.0 ? 1.0 : 1.0 / (t - 0.5) / (t - 0.5); }},
      {"if(abs(t - 1) > 0.01, sin(t - 1)/(t - 1), 1)",
       [](double t) { return std::abs(t - 1.0) > 0.01 ? std::sin(t - 1.0) / (t - 1.0) : 1.0; }},
      {"sin(t - 1)/(t - 1)", [](double t) { return t == 1.0 ? 1.0 : std::sin(t - 1.0) / (t - 1.0); }},
  };
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p}) {
    for (const auto& member : members) {
      INFO(member.effort << " by " << method_name(method));
      const RunResult result = run_text(low_pass(member.effort), with_method(method, 1e-8));
      REQUIRE(result.stop == StopReason::completed);
      // Simpson's rule is off by 1e-5 where the effort jumps, and by less than the run elsewhere.
      CHECK(std::abs(last(result, "x") - response(member.value)) < 2e-5);
    }
    for (const std::string effort : {"1/(1.5 - t)", "1/(1.5 - t)^2", "1e-8/(t - 1.5)^3", "if(t < 1.7, 1/(1.5 - t), 0)",
                                     "1/cos(t)", "t/(1 - t)", "if(c.q < 1e9, 1/(t - 1), 0)"}) {
      INFO(effort << " by " << method_name(method));
      const RunResult result = run_text(low_pass(effort), with_method(method, 1e-6));
      REQUIRE(result.failure);
      CHECK(result.failure->code == "BG613");
    }
  }
}

TEST_CASE("outside its domain a function is a fault at its time") {
  for (const auto& [law, time] : {std::pair{"acosh(3 - t)", 2.0}, {"atanh(t)", 1.0}, {"log1p(-t/2)", 2.0}}) {
    CAPTURE(law);
    const RunResult result = run_text(wave(law));
    REQUIRE(result.failure);
    CHECK(result.failure->code == "BG601");
    CHECK(result.failure->situation.find(std::string(law).substr(0, 5)) != std::string::npos);
    CHECK(result.trace.times.back() <= time);
    CHECK(result.trace.times.back() > time - kPi / 4 - 1e-9);
  }
}
