// Laws with a root in an algebraic loop: an orifice with a leak beside it, in series with a hose.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bgsim/sensitivity.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// Resistors in series between a source and a tank with an outlet.
std::string filled_through(const std::vector<std::string>& laws, const std::string& source = "2*sin(1.3*t)") {
  std::string elements, bonds, outputs;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const std::string name = "r" + std::to_string(i);
    elements += '"' + name + R"(": {"kind": "R", "law": ")" + laws[i] + R"("}, )";
    bonds += R"({"from": "j", "to": ")" + name + R"("}, )";
    outputs += R"(, "e)" + std::to_string(i) + R"(": ")" + name + R"(.e")";
  }
  return R"({"bgsim": 1, "name": "filled", "parameters": {"k": 2, "g": 0.5, "lift": 1}, "elements": {"j": {"kind": "1"}, )" +
         elements + R"("u": {"kind": "MSe", "effort": ")" + source +
         R"("}, "n": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1.7}, "out": {"kind": "R", "resistance": 2}},
    "bonds": [{"from": "u", "to": "j"}, )" +
         bonds + R"({"from": "j", "to": "n"}, {"from": "n", "to": "c"}, {"from": "n", "to": "out"}],
    "outputs": {"v": "c.e", "f": "r0.f", "u": "u.e")" +
         outputs + R"(}, "scenes": {"s": {"stop": 9, "samples": 61}}})";
}

constexpr Method kMethods[] = {Method::automatic, Method::bdf,  Method::adams, Method::radau,
                               Method::ida,       Method::erk5, Method::dirk5, Method::rodas5p};

double root(double x) { return std::copysign(std::sqrt(std::abs(x)), x); }

}  // namespace

TEST_CASE("a law with a root in series with a resistor is one law, however it is written") {
  struct Case {
    std::vector<const char*> laws;  ///< the same in several spellings
    const char* together;           ///< in series with f = 0.7 e
  };
  const Case cases[] = {
      // e = w |w|: 2 w + w |w|/2 = 0.7 (E - w |w|) is quadratic in w.
      {{"f = 2*sign(e)*sqrt(abs(e)) + 0.5*e", "f = if(e > 0, 2*sqrt(e) + e/2, e/2 - 2*sqrt(-e))",
        "f = 2*sqrt(max(e, 0)) - 2*sqrt(-min(e, 0)) + 0.5*e", "f = if(e < 0, -1, 1)*2*abs(e)^0.5 + 0.5*e",
        "f = k*sign(e)*sqrt(abs(e)) + g*e", "f = sign(e)*(k*sqrt(abs(e)) + g*abs(e))",
        "f = if(0 <= e, sqrt(k^2*e), -sqrt(-4*e)) + g*e"},
       "f = 2*sign(e)*(sqrt(4 + 3.36*abs(e)) - 2)/2.4 + sign(e)*((sqrt(4 + 3.36*abs(e)) - 2)/2.4)^2/2"},
      // The others by their inverse, and that of 0.7 e.
      {{"f = 2*cbrt(e)", "f = if(e > 0, 2*cbrt(e), -2*cbrt(-e))", "f = if(e > 0, k*e^(1/3), -k*(-e)^(1/3))"},
       "e = (f/2)^3 + f/0.7"},
      {{"f = if(e > 0, 2*e^0.57, -2*(-e)^0.57)", "f = 2*max(e, 0)^0.57 - 2*max(-e, 0)^0.57"},
       "e = sign(f)*abs(f/2)^(1/0.57) + f/0.7"},
      {{"f = k*sign(e - lift)*sqrt(abs(e - lift)) + k", "f = if(e > lift, k*sqrt(e - lift), -k*sqrt(lift - e)) + k",
        "f = 2 + if(e < 1, -2*sqrt(abs(1 - e)), 2*sqrt(abs(e - 1)))"},
       "e = 1 + (f/2 - 1)*abs(f/2 - 1) + f/0.7"},
      {{"f = if(e > 0, 2*sqrt(e), -0.5*sqrt(-e))", "f = 2*sqrt(max(e, 0)) - sqrt(max(-e, 0))/2",
        "f = sign(e)*sqrt(abs(e))*if(e > 0, 2, 0.5)"},
       "e = if(f > 0, f*f/4, -4*f*f) + f/0.7"},
      {{"f = 2*sqrt(max(e, 0)) + 1e-3*e", "f = if(e > 0, 2*sqrt(e), 0) + e/1000"},
       "f = if(e > 0, 2*(sqrt(4 + 1.9628*e) - 2)/1.402 + 0.001*((sqrt(4 + 1.9628*e) - 2)/1.402)^2, e*0.7/701)"},
  };
  for (const Case& one : cases) {
    const RunResult other = run_text(filled_through({one.together}), with_method(Method::automatic, 1e-9));
    REQUIRE(other.stop == StopReason::completed);
    for (const char* law : one.laws)
      for (const Method method : kMethods) {
        INFO(law << ' ' << method_name(method));
        const RunResult run = run_text(filled_through({law, "f = 0.7*e"}), with_method(method, 1e-6));
        REQUIRE(run.stop == StopReason::completed);
        for (const char* output : {"v", "f"})
          for (std::size_t k = 0; k < run.trace.times.size(); ++k)
            CHECK(std::abs(run.trace[output][k] - other.trace[output][k]) < 1e-4);  // a hundred tolerances
      }
  }
}

TEST_CASE("a pipe's law is one law, whether its powers are added or in a product, by parts or with signs") {
  // K f + |f|^0.75 f and its like, alone on a store and in series with a resistor, from rest and through it.
  struct Case {
    std::vector<std::string> laws;  ///< the same; the first is a sum
  };
  const Case cases[] = {
      {{"0.3*f + f*abs(f)^0.75", "f*(0.3 + abs(f)^0.75)", "sign(f)*(0.3*abs(f) + abs(f)^1.75)",
        "if(f > 0, 0.3*f + f^1.75, 0.3*f - (-f)^1.75)", "if(f >= 0, 1, -1)*(0.3*abs(f) + abs(f)^1.75)",
        "f*(1.3 + abs(f)^0.75) - f"}},
      {{"0.3*f + f*abs(f)", "sign(f)*(0.3*abs(f) + f^2)", "if(f > 0, 0.3*f + f^2, 0.3*f - f^2)",
        "f*(0.3 + sqrt(f^2))"}},
      {{"0.3*f + f*abs(f)^(2/3)", "f*(0.3 + cbrt(f^2))", "0.3*f + f*(f^2)^(1/3)"}},
      {{"0.3*f + f*abs(f)^g", "f*(0.3 + abs(f)^g)"}},
      {{"0.3*f + 0.3*f*abs(f)^0.25 + f*abs(f)^0.5 + f*abs(f)^0.75", "f*(0.3 + abs(f)^0.5)*(1 + abs(f)^0.25)"}}};
  for (const Case& each : cases)
    for (const bool alone : {true, false}) {
      const auto laws = [&](const std::string& law) {
        return alone ? std::vector<std::string>{"e = " + law} : std::vector<std::string>{"e = " + law, "e = 0.4*f"};
      };
      const RunResult exact = run_text(filled_through(laws(each.laws.front())), with_method(Method::radau, 1e-10));
      REQUIRE(exact.stop == StopReason::completed);
      for (const std::string& law : each.laws)
        for (const Method method : {Method::automatic, Method::bdf, Method::ida, Method::rodas5p}) {
          INFO(law << (alone ? " alone, " : " in series, ") << facts_of(method).name);
          const RunResult run = run_text(filled_through(laws(law)), with_method(method, 1e-8));
          REQUIRE(run.stop == StopReason::completed);
          for (const std::string& note : run.report.notes) CHECK_THAT(note, !Contains("other solutions exist"));
          // A flow is the square of what it is known by at rest, where laws have a slope of 0.3: a hundred tolerances.
          for (const char* name : {"v", "f"})
            for (std::size_t i = 0; i < exact.trace.times.size(); ++i)
              REQUIRE(run.trace[name][i] == Approx(exact.trace[name][i]).margin(1e-6));
        }
    }
}

TEST_CASE("a valve in series with a root and a resistor opens and shuts as one law does") {
  // As above, for E > 0 alone: 2 w = 0.7 (E - w^2), and with a leak. At the start nothing moves yet; with the law by
  // parts the valve never opened.
  const auto valve = [](const char* law) {
    std::string text = filled_through({law, "f = 0.7*e"});
    for (const auto& [before, added] : {std::pair(R"("u": {"kind")", R"("d": {"kind": "D"}, )"),
                                        std::pair(R"({"from": "u")", R"({"from": "j", "to": "d"}, )")})
      text.insert(text.find(before), added);
    return text;
  };
  const std::pair<std::vector<const char*>, const char*> cases[] = {
      {{"f = 2*sign(e)*sqrt(abs(e))", "f = if(e > 0, 2*sqrt(e), -2*sqrt(-e))", "f = if(e > 0, 2*sqrt(e), -sqrt(-e))",
        "f = 2*sqrt(max(e, 0)) - 2*sqrt(max(-e, 0))", "f = if(e >= 0, 1, -1)*2*sqrt(abs(e))"},
       "f = 2*(sqrt(4 + 1.96*max(e, 0)) - 2)/1.4"},
      {{"f = 2*sign(e)*sqrt(abs(e)) + e/2", "f = if(e > 0, 2*sqrt(e) + e/2, e/2 - 2*sqrt(-e))",
        "f = 2*sqrt(max(e, 0)) + 0.5*e"},
       "f = 2*(sqrt(4 + 3.36*max(e, 0)) - 2)/2.4 + ((sqrt(4 + 3.36*max(e, 0)) - 2)/2.4)^2/2"},
  };
  for (const auto& [laws, together] : cases) {
    const RunResult other = run_text(filled_through({together}), with_method(Method::automatic, 1e-9));
    REQUIRE(other.stop == StopReason::completed);
    for (const char* law : laws)
      for (const Method method :
           {Method::automatic, Method::bdf, Method::erk5, Method::dirk5, Method::rodas5p, Method::ida}) {
        INFO(law << ' ' << method_name(method));
        const RunResult run = Study::from_text(valve(law)).scene("s", with_method(method)).simulate(one_run());
        REQUIRE(run.stop == StopReason::completed);
        for (std::size_t k = 0; k < run.trace.times.size(); ++k)
          CHECK(std::abs(run.trace["v"][k] - other.trace["v"][k]) < 1e-4);  // a hundred tolerances
      }
  }
}

TEST_CASE("roots in series and beside each other keep their laws at every instant") {
  // Both have an infinite slope at rest, so that nothing is left there that a loop could be solved by but the roots.
  const auto orifice = [](double a, double b) {
    return "f = " + std::to_string(a) + "*sign(e)*sqrt(abs(e)) + " + std::to_string(b) + "*e";
  };
  for (const double b : {0.5, 0.01, 0.0}) {
    const Study study = Study::from_text(filled_through({orifice(2, 0.5), orifice(1.3, 0.2), orifice(0.7, b)}));
    for (const Method method : kMethods) {
      INFO(b << ' ' << method_name(method));
      const RunResult run = study.scene("s", with_method(method)).simulate(one_run());
      REQUIRE(run.stop == StopReason::completed);
      CHECK(std::abs(run.report.energy.relative) < 1e-4);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
        const auto value = [&](const char* name) { return run.trace[name][k]; };
        const double f = value("f");
        // The loops' own resolution, and IDA knows their variables to its tolerance only.
        const double within = method == Method::ida ? 1e-4 : 1e-9;
        CHECK(std::abs(value("e0") + value("e1") + value("e2") + value("v") - value("u")) < within);
        CHECK(std::abs(2 * root(value("e0")) + 0.5 * value("e0") - f) < within);
        CHECK(std::abs(1.3 * root(value("e1")) + 0.2 * value("e1") - f) < within);
        CHECK(std::abs(0.7 * root(value("e2")) + b * value("e2") - f) < within);
      }
    }
  }
}

TEST_CASE("a power that is a parameter is the law of its value, in one study for all of them", "[long]") {
  // With m for the power of the effort, 1/m that of the flow; beside others of each kind.
  const std::vector<const char*> laws = {
      "f = k*sign(e)*abs(e)^m",          "e = sign(f)*abs(f/k)^(1/m)",         "f = k*e*abs(e)^(m - 1)",
      "f = if(e > 0, k*e^m, -k*(-e)^m)", "f = k*(max(e, 0)^m - max(-e, 0)^m)", "e = f*abs(f)^(1/m - 1)/k^(1/m)"};
  const auto with_power = [](const std::vector<std::string>& series) {
    std::string text = filled_through(series);
    return text.insert(text.find("\"k\": 2"), R"("m": 0.7, )");
  };
  for (const char* other : {"f = 0.7*e", "e = 0.4*f*abs(f)", "f = 1.3*sign(e)*sqrt(abs(e)) + 0.4*e"})
    for (const char* law : laws) {
      const Study study = Study::from_text(with_power({law, other}));
      for (const double n : {0.35, 0.5, 1.0, 1.6, 2.0}) {
        const double inverse = 1.0 / n;
        const std::string written =
            inverse >= 1.0 ? "e = f*abs(f)^" + std::to_string(inverse - 1.0) + "/2^" + std::to_string(inverse)
                           : "f = 2*e*abs(e)^" + std::to_string(n - 1.0);
        const RunResult by_number = run_text(filled_through({written, other}), with_method(Method::automatic, 1e-8));
        REQUIRE(by_number.stop == StopReason::completed);
        for (const Method method : {Method::automatic, Method::bdf, Method::dirk5}) {
          CAPTURE(law, other, n, method_name(method));
          const RunResult run = study.scene("s", with_method(method, 1e-7)).with("m", n).simulate(one_run());
          REQUIRE(run.stop == StopReason::completed);
          for (std::size_t k = 0; k < run.trace.times.size(); ++k)
            CHECK(std::abs(run.trace["v"][k] - by_number.trace["v"][k]) <
                  1e-4);  // from which on a run has to note its errors
        }
      }
    }
}

TEST_CASE("a power that is a parameter has derivatives by it, in loops, too") {
  const SceneOverrides tight = with_method(Method::automatic, 1e-9);
  for (const char* m : {"0.35", "0.6", "1.6", "2.3"}) {
    CAPTURE(m);
    std::string text = filled_through({"f = k*sign(e)*abs(e)^m", "e = 0.4*f*abs(f) + 0.1*f"}, "1.2 + sin(1.3*t)");
    const Study study = Study::from_text(text.insert(text.find("\"k\": 2"), "\"m\": " + std::string(m) + ", "));
    const SensitivityTable table = sensitivities(study, "", tight, {"m", "k"}, SensitivityNorm::final),
                           other = difference_sensitivities(study, "", tight, {"m", "k"}, SensitivityNorm::final);
    for (std::size_t p = 0; p < 2; ++p) {
      const OutputSensitivity &one = table.of[0][p], &two = other.of[0][p];
      CHECK(std::abs(one.derivative - two.derivative) <= 2.0 * (one.error + two.error));  // what both are known to
      CHECK(one.error < 1e-5 * std::abs(one.derivative));
    }
  }
}

TEST_CASE("a power that is a parameter may be 0, which is dry friction") {
  // The mass slides to a stand: v = 2 - t up to t = 2, then nothing moves it. (No loop: the law stays as it is
  // written.)
  const Study study = Study::from_text(R"x({"bgsim": 1, "name": "brake", "parameters": {"n": 0.5}, "elements": {
      "m": {"kind": "I", "inertance": 1, "initial": {"f": 2}}, "j": {"kind": "1"},
      "r": {"kind": "R", "law": "e = sign(f)*abs(f)^n"}},
    "bonds": [{"from": "j", "to": "m"}, {"from": "j", "to": "r"}],
    "outputs": {"v": "m.f"}, "scenes": {"s": {"stop": 4, "samples": 41}}})x");
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5}) {
    CAPTURE(method_name(method));
    const RunResult run = study.scene("s", with_method(method)).with("n", 0.0).simulate(one_run());
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k)
      CHECK(std::abs(run.trace["v"][k] - std::max(0.0, 2.0 - run.trace.times[k])) < 1e-5);  // some tolerances
  }
}

TEST_CASE("a root of what is below 0 is an error beside a loop, too") {
  const RunResult run = run_text(filled_through({"f = 2*sqrt(e) + 0.5*e", "f = 0.7*e"}));
  REQUIRE(run.stop == StopReason::failed);
  CHECK(run.report.reached < 3.0);  // the source turns back at 2.4, the flow before
  REQUIRE(run.failure);
  CHECK_THAT(run.failure->situation, Contains("r0"));
}
