// Laws with kinks that are strictly monotone, where causality asks for the variable that they are not written for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "support/circuit.hpp"
#include "support/fed_states.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr double kOn = 0.01, kOff = 1e5;

std::string law(const std::string& text) { return "\"law\": \"" + text + "\""; }

/// The same two-slope diode, written in several ways.
const std::vector<std::string> kDiodes{
    "f = if(e > 0, e/0.01, e/1e5)",       "f = if(e <= 0, 1e-5*e, 100*e)",
    "f = max(e, 0)/0.01 + min(e, 0)/1e5", "f = (1/0.01 + 1/1e5)/2*e + (1/0.01 - 1/1e5)/2*abs(e)",
    "e = if(f > 0, 0.01*f, 1e5*f)",
};

std::vector<Part> bridge(const std::string& diode) {
  return {{"d1", "R", "a", "plus", diode},
          {"d2", "R", "b", "plus", diode},
          {"d3", "R", "0", "a", diode},
          {"d4", "R", "0", "b", diode}};
}

double charge_after(double time, double step, const std::function<double(double, double)>& rate) {
  double q = 0.0;
  const int steps = static_cast<int>(std::lround(time / step));
  for (int i = 0; i < steps; ++i) {
    const double t = i * step;
    const double a = rate(t, q), b = rate(t + step / 2, q + step / 2 * a), c = rate(t + step / 2, q + step / 2 * b),
                 d = rate(t + step, q + step * c);
    q += step / 6 * (a + 2 * b + 2 * c + d);
  }
  return q;
}

/// Zero of an increasing function.
double bisect(const std::function<double(double)>& f, double low, double high) {
  for (int i = 0; i < 100; ++i) {
    const double middle = low + (high - low) / 2;
    (f(middle) > 0.0 ? high : low) = middle;
  }
  return low + (high - low) / 2;
}

}  // namespace

TEST_CASE("a bridge of two-slope diodes with a resistive load is a lattice, however its laws are written") {
  for (const std::string& diode : kDiodes) {
    INFO(diode);
    std::vector<Part> parts = bridge(law(diode));
    parts.push_back({"s", "Se", "x", "b", R"x("effort": "17*sin(314*t)")x"});
    parts.push_back({"rs", "R", "x", "a", resistor("0.5")});
    parts.push_back({"r", "R", "plus", "0", resistor("50")});
    const RunResult run = run_text(circuit(parts, R"("u": "r.e", "i": "rs.f")", R"("stop": 0.02, "samples": 41)"));
    REQUIRE(run.stop == StopReason::completed);
    const std::vector<double> u = column(run, "u"), i = column(run, "i");
    for (std::size_t k = 0; k < u.size(); ++k) {
      const double source = 17.0 * std::sin(314.0 * run.trace.times[k]);
      const double sum = 50.0 * (kOn + kOff) + 2.0 * kOn * kOff;
      const double bridge_resistance = sum / (2.0 * 50.0 + kOn + kOff);
      const double current = source / (0.5 + bridge_resistance);
      // Slopes that differ by 1e7 leave nine digits.
      CHECK(i[k] == Approx(current).margin(1e-8));
      CHECK(u[k] == Approx(std::abs(current) * bridge_resistance * 50.0 * (kOff - kOn) / sum).margin(1e-8));
    }
  }
}

TEST_CASE("a bridge of two-slope diodes with a smoothing capacitor agrees with bisection, by all methods", "[long]") {
  std::vector<Part> parts = bridge(law(kDiodes[0]));
  parts.push_back({"s", "Se", "x", "b", R"x("effort": "17*sin(314*t)")x"});
  parts.push_back({"rs", "R", "x", "a", resistor("0.5")});
  parts.push_back({"c", "C", "plus", "0", "\"capacitance\": 1e-3"});
  parts.push_back({"r", "R", "plus", "0", resistor("50")});
  const std::string text = circuit(parts, R"("u": "c.e")", R"("stop": 0.01, "samples": 11)");
  const auto diode = [](double e) { return e > 0.0 ? e / kOn : e / kOff; };
  const auto charging = [&](double t, double q) {
    const double u = q / 1e-3, source = 17.0 * std::sin(314.0 * t);
    const auto node = [&](double i) {
      return bisect([&](double a) { return diode(a - u) - diode(-a) - i; }, -30.0, u + 30.0);
    };
    const double i = bisect([&](double f) { return node(f) - node(-f) + 0.5 * f - source; }, -60.0, 60.0);
    return diode(node(i) - u) + diode(node(-i) - u) - u / 50.0;
  };
  const double expected = charge_after(0.01, 2e-5, charging) / 1e-3;
  for (const Method method : {Method::bdf, Method::adams, Method::ida, Method::erk4, Method::dirk4, Method::radau,
                              Method::radau9, Method::radau13, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-8));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(run.report.energy.relative < 1e-5);
    // The reference passes three kinks with steps of 2e-5 s, which leaves some 1e-5 of the voltage.
    CHECK(std::abs(last(run, "u") - expected) < 5e-5 * expected);
  }
}

TEST_CASE("a bridge of two-slope diodes starts at rest, where all of them are at their kinks") {
  // Before the source has moved, which of them conduct is decided by numbers of 1e-320: they went back and forth, and
  // the run ended with BG604. No order of magnitude was known beside which these are nothing.
  const std::string diode = law("f = if(e > 0, e/0.111355, e/12060.9)");
  std::vector<Part> parts = bridge(diode);
  parts.push_back({"s", "Se", "x", "b", R"x("effort": "41.9619*sin(2.30347*t)")x"});
  parts.push_back({"rs", "R", "x", "a", resistor("0.801631")});
  parts.push_back({"c", "C", "plus", "0", "\"capacitance\": 0.0280766"});
  parts.push_back({"r", "R", "plus", "0", resistor("277.113")});
  const std::string text = circuit(parts, R"("u": "c.e", "i": "rs.f")", R"("stop": 3, "samples": 31)");
  const RunResult exact = run_text(text, with_method(Method::radau, 1e-10));
  REQUIRE(exact.stop == StopReason::completed);
  for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::radau, Method::dirk4}) {
    INFO(method_name(method));
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < 2; ++k) {
      const auto [least, most] = std::minmax_element(exact.trace.columns[k].begin(), exact.trace.columns[k].end());
      const double part = largest_difference(run.trace.columns[k], exact.trace.columns[k]) / (*most - *least);
      CHECK((part < 1e-4 || !run.report.notes.empty()));
      CHECK(part < 1e-3);
    }
  }
}

TEST_CASE("a turbulent pipe, written by its flow, empties a vessel as the closed form says") {
  const std::string text =
      R"x({ "bgsim": 1, "name": "vessels", "parameters": { "K": 4 }, "elements": {
            "a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "b": { "kind": "C", "capacitance": 2 },
            "line": { "kind": "1" }, "pipe": { "kind": "R", "law": "e = K*f*abs(f)" } },
            "bonds": [ { "from": "line", "to": "a" }, { "from": "line", "to": "b" }, { "from": "line", "to": "pipe" } ],
            "outputs": { "p": { "value": "a.e + b.e" } }, "scenes": { "run": { "stop": 2.4, "samples": 25 } } })x";
  for (const Method method : {Method::bdf, Method::adams, Method::ida, Method::erk4, Method::dirk4, Method::radau,
                              Method::radau9, Method::radau13, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-8));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      const double root = 1.0 - 0.375 * run.trace.times[k];
      CHECK(column(run, "p")[k] == Approx(root * root).margin(1e-6));  // some hundred tolerances of 1e-8
    }
  }
}

TEST_CASE("a damper that is harder in one direction may give its effort or its flow") {
  // Its law by effort would fix the flow of the mass; the equations would be of higher index.
  const auto model = [](const std::string& damper) {
    return R"x({ "bgsim": 1, "name": "damped", "parameters": { "b_out": 2, "b_in": 5 }, "elements": {
                 "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } },
                 "k": { "kind": "C", "capacitance": 0.01 }, "b": { "kind": "R", "law": ")x" +
           damper + R"x(" } },
                 "bonds": [ { "from": "j", "to": "m" }, { "from": "j", "to": "k" }, { "from": "j", "to": "b" } ],
                 "outputs": { "x": "k.q", "v": "m.f" }, "scenes": { "run": { "stop": 2, "samples": 201 } } })x";
  };
  const RunResult flow = run_text(model("f = if(e > 0, e/b_out, e/b_in)"), with_relative(1e-8));
  const RunResult effort = run_text(model("e = if(f > 0, b_out*f, b_in*f)"), with_relative(1e-8));
  REQUIRE(flow.stop == StopReason::completed);
  CHECK(flow.report.state_events == effort.report.state_events);
  // Two runs with some hundred tolerances of 1e-8.
  CHECK(largest_difference(flow, effort) < 1e-6);
}

TEST_CASE("a string of two-slope diodes that change in one instant is one diode with the sums of their resistances") {
  const auto model = [](const std::string& string) {
    return R"x({ "bgsim": 1, "name": "string", "elements": { "s": { "kind": "Se", "effort": "17*sin(314*t)" },
                 "in": { "kind": "1" }, "rs": { "kind": "R", "resistance": 0.5 }, "out": { "kind": "0" },
                 "r": { "kind": "R", "resistance": 50 }, "c": { "kind": "C", "capacitance": 1e-3 },)x" +
           string + R"x( { "from": "s", "to": "in" }, { "from": "in", "to": "rs" }, { "from": "in", "to": "out" },
                 { "from": "out", "to": "r" }, { "from": "out", "to": "c" } ],
                 "outputs": { "u": "c.e" }, "scenes": { "run": { "stop": 0.06, "samples": 301 } } })x";
  };
  const RunResult two = run_text(
      model(
          R"x("d": { "kind": "R", "law": "f = if(e > 0, e/0.01, e/1e5)" }, "g": { "kind": "R", "law": "f = if(e > 0, e/0.01, e/2e5)" } },
                "bonds": [ { "from": "in", "to": "d" }, { "from": "in", "to": "g" },)x"),
      with_relative(1e-8));
  const RunResult one = run_text(model(R"x("d": { "kind": "R", "law": "e = if(f > 0, 0.02*f, 3e5*f)" } },
                "bonds": [ { "from": "in", "to": "d" },)x"),
                                 with_relative(1e-8));
  REQUIRE(two.stop == StopReason::completed);
  REQUIRE(one.stop == StopReason::completed);
  // 13 V, with two runs of some hundred tolerances of 1e-8.
  CHECK(largest_difference(two, one) < 2e-5);
}

TEST_CASE("a law with kinks is solved for the parameters of its run, or refused") {
  const std::string text = R"x({ "bgsim": 1, "name": "series", "parameters": { "ron": 2, "roff": 50 }, "elements": {
        "current": { "kind": "Sf", "flow": "cos(t)" }, "loop": { "kind": "1" },
        "d": { "kind": "R", "law": "f = if(e > 0, e/ron, e/roff)" } },
        "bonds": [ { "from": "current", "to": "loop" }, { "from": "loop", "to": "d" } ],
        "outputs": { "u": "d.e" }, "scenes": { "run": { "stop": 3, "samples": 11 } } })x";
  for (const double ron : {2.0, 60.0}) {
    const RunResult run = run_text(text, with_parameters({"ron=" + std::to_string(ron)}));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      const double f = std::cos(run.trace.times[k]);
      CHECK(column(run, "u")[k] == Approx(f > 0.0 ? ron * f : 50.0 * f).epsilon(1e-12));  // a product and a quotient
    }
  }
  CHECK_THROWS_WITH(run_text(text, with_parameters({"roff=-50"})), Catch::Contains("BG305"));
  CHECK_THROWS_WITH(run_text(text, with_parameters({"ron=-2", "roff=-50"})), Catch::Contains("BG305"));
}

TEST_CASE("a tank that empties by sqrt(max(q, 0)), which has no slope there, stays empty") {
  const std::string text = fed_states({{"x", "1", "-sqrt(max(x.q, 0))"}}, "\"stop\": 4, \"samples\": 41");
  for (const Method method :
       {Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      const double left = std::max(0.0, 1.0 - run.trace.times[k] / 2.0);
      // Some tens of steps at 1e-6.
      CHECK(std::abs(run.trace.columns[0][k] - left * left) < 1e-4);
    }
  }
}

TEST_CASE("a pipe of a thousand laws that are solved for their flows is read, and is a pipe", "[long]") {
  // Looking for jumps in what depends on all of the pipe took minutes. Filled slowly, from rest: e = 1e-3 f + 1e-5 f
  // |f| at each section, and the flow into section k is what the sections behind it take up.
  const std::string text = R"x({"bgsim": 1, "name": "pipe", "elements": {
      "q": {"kind": "Se", "effort": "t"}, "n": {"kind": "0", "repeat": 1000},
      "c": {"kind": "C", "repeat": 1000, "capacitance": 1e-3}, "j": {"kind": "1", "repeat": 1000},
      "r": {"kind": "R", "repeat": 1000, "law": "e = 1e-3*f + 1e-5*f*abs(f)"}},
    "bonds": [{"from": "q", "to": "j[1]"}, {"from": "n[i]", "to": "c[i]"}, {"from": "n[i]", "to": "j[i+1]"},
              {"from": "j[i]", "to": "n[i]"}, {"from": "j[i]", "to": "r[i]"}],
    "outputs": {"f": "r[1].f", "e": "r[1].e", "drop": "c[1].e - c[2].e", "f2": "r[2].f"},
    "scenes": {"s": {"stop": 1e-5, "samples": 3}}})x";
  const Study study = Study::from_text(text);
  CHECK(study.causality().dependent.empty());
  CHECK(study.equations().states.size() == 1000);
  std::string shorter = text;
  for (std::size_t at = 0; (at = shorter.find("1000", at)) != std::string::npos;) shorter.replace(at, 4, "200");
  const RunResult run = Study::from_text(shorter).scene("s").simulate(SimulateOptions{});
  REQUIRE(run.stop == StopReason::completed);
  // Flows of 5e-318 that the wave has not reached were solutions that end: 3700 steps.
  CHECK(run.report.steps < 400);
  const double f = run.trace["f"].back(), f2 = run.trace["f2"].back();
  CHECK(f > 0.0);
  // The loops' own resolution.
  CHECK(run.trace["e"].back() == Approx(1e-3 * f + 1e-5 * f * std::abs(f)).epsilon(1e-9));
  CHECK(run.trace["drop"].back() == Approx(1e-3 * f2 + 1e-5 * f2 * std::abs(f2)).epsilon(1e-9));
}
