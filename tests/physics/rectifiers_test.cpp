// Circuits of exponential diodes, whose loops have one solution at each instant.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "support/circuit.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr double kSaturation = 1e-9, kThermal = 0.045;
const std::string kDiode = R"x("law": "f = 1e-9*(exp(e/0.045) - 1)")x";

double diode(double e) { return kSaturation * std::expm1(std::min(e / kThermal, 600.0)); }

const std::string kMains = R"x("effort": "17*sin(314*t)")x";

/// Zero of an increasing function.
double bisect(const std::function<double(double)>& f, double low, double high) {
  for (int i = 0; i < 100; ++i) {
    const double middle = low + (high - low) / 2;
    (f(middle) > 0.0 ? high : low) = middle;
  }
  return low + (high - low) / 2;
}

/// The charge of a smoothing capacitor by the classical Runge-Kutta method with short steps.
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

std::vector<Part> bridge_between(const std::string& a, const std::string& b) {
  return {{"d1", "R", a, "plus", kDiode},
          {"d2", "R", b, "plus", kDiode},
          {"d3", "R", "0", a, kDiode},
          {"d4", "R", "0", b, kDiode}};
}

}  // namespace

TEST_CASE("a bridge of diodes with a smoothing capacitor agrees with bisection at every instant, by all methods",
          "[long]") {
  std::vector<Part> parts = bridge_between("a", "b");
  parts.push_back({"s", "Se", "x", "b", kMains});
  parts.push_back({"rs", "R", "x", "a", resistor("0.5")});
  parts.push_back({"c", "C", "plus", "0", "\"capacitance\": 1e-3"});
  parts.push_back({"r", "R", "plus", "0", resistor("50")});
  const std::string text = circuit(parts, R"("u": "c.e")", R"("stop": 0.02, "samples": 11)");
  const auto charging = [](double t, double q) {
    const double u = q / 1e-3, source = 17.0 * std::sin(314.0 * t);
    const auto node = [u](double i) {
      return bisect([&](double a) { return diode(a - u) - diode(-a) - i; }, -5.0, u + 5.0);
    };
    const double i = bisect([&](double f) { return node(f) - node(-f) + 0.5 * f - source; }, -60.0, 60.0);
    return diode(node(i) - u) + diode(node(-i) - u) - u / 50.0;
  };
  const double expected = charge_after(0.02, 1e-4, charging) / 1e-3;
  for (const Method method : {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4, Method::radau,
                              Method::radau9, Method::radau13, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-8));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(run.report.energy.relative < 1e-5);
    // The reference's steps of 1e-4 s leave 1e-6 of the voltage: halving them changes the eighth digit.
    CHECK(std::abs(last(run, "u") - expected) < 1e-5 * expected);
  }
}

TEST_CASE("six diodes on a star of sources whose neutral floats: all methods come to one voltage, and energy is kept",
          "[long]") {
  std::vector<Part> parts{{"c", "C", "plus", "minus", "\"capacitance\": 1e-3"},
                          {"r", "R", "plus", "minus", resistor("20")}};
  for (int k = 0; k < 3; ++k) {
    const std::string i = std::to_string(k);
    parts.push_back({"s" + i, "Se", "x" + i, "neutral", R"("effort": "100*sin(314*t - )" + i + R"x(*2*pi/3)")x"});
    parts.push_back({"r" + i, "R", "x" + i, "n" + i, resistor("0.2")});
    parts.push_back({"up" + i, "R", "n" + i, "plus", kDiode});
    parts.push_back({"down" + i, "R", "minus", "n" + i, kDiode});
  }
  // Of all nodes one is the reference of the others.
  for (Part& part : parts)
    for (std::string* const node : {&part.from, &part.to})
      if (*node == "minus") *node = "0";
  const std::string text = circuit(parts, R"("u": "c.e")", R"("stop": 0.02, "samples": 11)");
  std::vector<double> ends;
  for (const Method method : {Method::bdf, Method::ida, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-8));
    REQUIRE(run.stop == StopReason::completed);
    REQUIRE(run.report.energy.done);
    CHECK(run.report.energy.relative < 1e-5);
    ends.push_back(last(run, "u"));
  }
  // Three integrators, each with some hundred tolerances of 1e-8.
  for (const double end : ends) CHECK(std::abs(end - ends.front()) < 1e-6 * ends.front());
}

TEST_CASE("a diode that charges a capacitor from an ideal source passes no peak by a wrong scale") {
  const std::string text = circuit({{"s", "Se", "a", "0", kMains},
                                    {"d", "R", "a", "plus", kDiode},
                                    {"r", "R", "plus", "0", resistor("50")},
                                    {"c", "C", "plus", "0", "\"capacitance\": 1e-3"}},
                                   R"("u": "c.e")", R"("stop": 0.1, "samples": 101)");
  const auto charging = [](double t, double q) {
    return diode(17.0 * std::sin(314.0 * t) - q / 1e-3) - q / 1e-3 / 50.0;
  };
  const double expected = charge_after(0.1, 2e-6, charging) / 1e-3;
  for (const Method method : {Method::bdf, Method::erk5, Method::dirk4, Method::radau, Method::ida}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    // A hundred tolerances of 1e-6: five peaks, each of which adds the error of its start.
    CHECK(std::abs(last(run, "u") - expected) < 1e-4 * expected);
  }
}

TEST_CASE("voltage multipliers lose no time of conduction, by stiff and explicit methods", "[long]") {
  // Diodes and capacitors at an ideal source: a diode conducts for a hundredth of a period, and at its peak a predicted
  // scale without the slope there would be 1e141 V.
  const auto stages = [](int count) {
    std::vector<Part> parts{{"s", "Se", "a0", "0", kMains},
                            {"load", "R", "b" + std::to_string(count), "0", resistor("5e3")}};
    std::string low = "0";
    for (int i = 1; i <= count; ++i) {
      const std::string n = std::to_string(i), pushed = "a" + n, stored = "b" + n;
      parts.push_back({"ca" + n, "C", "a" + std::to_string(i - 1), pushed, "\"capacitance\": 1e-4"});
      parts.push_back({"cb" + n, "C", stored, low, "\"capacitance\": 1e-4"});
      parts.push_back({"da" + n, "R", low, pushed, kDiode});
      parts.push_back({"db" + n, "R", pushed, stored, kDiode});
      low = stored;
    }
    return circuit(parts, "\"u\": \"load.e\"", R"("stop": 0.3, "samples": 301)");
  };
  for (const int count : {1, 2}) {
    const std::string text = stages(count);
    const RunResult exact = run_text(text, with_method(Method::erk6, 1e-9));
    REQUIRE(exact.stop == StopReason::completed);
    // At 1e-6 the methods are off by 3e-5 of the output; a lost peak would be 5e-3.
    for (const Method method :
         {Method::bdf, Method::ida, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
      INFO(count << " stages, " << facts_of(method).name);
      const RunResult run = run_text(text, with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(largest_difference(exact, run) < 2e-4);
    }
  }
}

TEST_CASE("diodes without stores: a bridge on a resistor, a string, a clipper, a bridge on a coil", "[long]") {
  const std::string scene = R"("stop": 0.02, "samples": 41)";
  std::vector<Part> bridge = bridge_between("a", "b");
  bridge.push_back({"s", "Se", "a", "b", kMains});
  bridge.push_back({"r", "R", "plus", "0", resistor("50")});
  const RunResult rectified = run_text(circuit(bridge, R"("u": "r.e")", scene));
  REQUIRE(rectified.stop == StopReason::completed);
  for (std::size_t k = 0; k < rectified.trace.times.size(); ++k) {
    const double source = std::abs(17.0 * std::sin(314.0 * rectified.trace.times[k]));
    // The same current through load and two diodes, but for what leaks back through the others: 2e-9 A of 50 ohm.
    const double i =
        bisect([&](double f) { return 50.0 * f + 2.0 * kThermal * std::log1p(f / kSaturation) - source; }, 0.0, 1.0);
    CHECK(std::abs(rectified.trace["u"][k] - 50.0 * i) < 3e-7);
  }

  std::vector<Part> string{{"s", "Se", "x", "0", kMains}, {"rs", "R", "x", "n0", resistor("100")}};
  for (int k = 0; k < 10; ++k)
    string.push_back(
        {"d" + std::to_string(k), "R", "n" + std::to_string(k), k < 9 ? "n" + std::to_string(k + 1) : "0", kDiode});
  const RunResult ten = run_text(circuit(string, R"("u": "n0.e", "i": "rs.f")", scene));
  REQUIRE(ten.stop == StopReason::completed);
  for (std::size_t k = 0; k < ten.trace.times.size(); ++k) {
    const double source = 17.0 * std::sin(314.0 * ten.trace.times[k]);
    const double u = bisect([&](double v) { return v + 100.0 * diode(v / 10.0) - source; }, -20.0, 20.0);
    CHECK(std::abs(ten.trace["u"][k] - u) < 1e-9 * std::max(1.0, std::abs(u)));  // exact but for rounding
  }

  std::vector<Part> coil = bridge_between("a", "b");
  coil.push_back({"s", "Se", "x", "b", kMains});
  coil.push_back({"rs", "R", "x", "a", resistor("0.5")});
  coil.push_back({"l", "I", "plus", "q", "\"inertance\": 0.05"});
  coil.push_back({"r", "R", "q", "0", resistor("50")});
  std::vector<double> ends;
  for (const Method method : {Method::bdf, Method::erk5}) {
    const RunResult run = run_text(circuit(coil, R"("i": "l.f")", scene), with_method(method, 1e-8));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(run.report.energy.relative < 1e-6);
    ends.push_back(last(run, "i"));
  }
  CHECK(std::abs(ends[0] - ends[1]) < 1e-6 * std::abs(ends[1]));  // a hundred tolerances
}

TEST_CASE("a loop that starts at zero comes to a solution as exact as its laws are") {
  const std::string text = circuit({{"a", "R", "n", "m", R"x("law": "e = 0.026*log(1 + f/1e-3)")x"},
                                    {"b", "R", "m", "0", resistor("0.5")},
                                    {"c", "C", "n", "0", "\"capacitance\": 1"},
                                    {"s", "Se", "y", "0", R"x("effort": "sin(t)")x"},
                                    {"rs", "R", "y", "n", resistor("1")}},
                                   R"("u": "c.e", "i": "a.f")", R"("stop": 1, "samples": 11)");
  const RunResult run = run_text(text, with_method(Method::bdf, 1e-8));
  REQUIRE(run.stop == StopReason::completed);
  for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
    const double u = run.trace["u"][k], i = run.trace["i"][k];
    CHECK(std::abs(0.026 * std::log1p(i / 1e-3) + 0.5 * i - u) < 1e-12);
  }
}

TEST_CASE("grids of diodes and resistors, to a thousand branches, balance the currents of their laws at every node",
          "[long]") {
  for (const int side : {6, 12, 23}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(side));
    std::uniform_real_distribution<double> part(0.0, 1.0);
    struct Branch {
      std::size_t from, to;
      double ohms;  // 0: a diode
    };
    const auto count = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    const auto node = [count](std::size_t i) { return i == 0 ? "a" : i + 1 == count ? "0" : "n" + std::to_string(i); };
    std::vector<Branch> branches;
    std::vector<Part> parts{{"s", "Se", "a", "0", R"x("effort": "5*sin(6283*t)")x"}};
    const auto branch = [&](std::size_t from, std::size_t to, bool diode_here) {
      if (diode_here && part(random) < 0.5) std::swap(from, to);
      const double ohms = diode_here ? 0.0 : std::round(std::pow(10.0, 1.0 + 3.0 * part(random)));
      const std::string law =
          diode_here ? std::string(R"x("law": "f = 1e-12*(exp(e/0.026) - 1)")x") : resistor(std::to_string(ohms));
      parts.push_back({"b" + std::to_string(branches.size()), "R", node(from), node(to), law});
      branches.push_back({from, to, ohms});
    };
    for (std::size_t i = 0; i < count; ++i) {
      const auto width = static_cast<std::size_t>(side);
      if ((i + 1) % width != 0) branch(i, i + 1, part(random) < 0.6);
      if (i + width < count) branch(i, i + width, part(random) < 0.6);
    }
    std::string outputs;
    for (std::size_t i = 0; i + 1 < count; ++i)
      outputs += (i == 0 ? "\"" : ", \"") + node(i) + "\": \"" + node(i) + ".e\"";
    SimulateOptions only_trace;  // the audit evaluates the network hundreds of times
    only_trace.energy_audit = false;
    const RunResult run = run_text(circuit(parts, outputs, R"("stop": 1e-3, "samples": 5)"), {}, only_trace);
    INFO(side << " x " << side << ", " << branches.size() << " branches");
    REQUIRE(run.stop == StopReason::completed);
    double most = 0.0, worst = 0.0;
    for (std::size_t row = 0; row < run.trace.times.size(); ++row) {
      std::vector<double> balance(count, 0.0);
      const auto potential = [&](std::size_t i) { return i + 1 == count ? 0.0 : run.trace.columns[i][row]; };
      for (const Branch& b : branches) {
        const double e = potential(b.from) - potential(b.to);
        const double f = b.ohms == 0.0 ? 1e-12 * std::expm1(e / 0.026) : e / b.ohms;
        balance[b.from] -= f;
        balance[b.to] += f;
        most = std::max(most, std::abs(f));
      }
      for (std::size_t i = 1; i + 1 < count; ++i) worst = std::max(worst, std::abs(balance[i]));
    }
    // Variables are found to 1e-13 of the largest that they have been, and a diode's current changes by e in 26 mV.
    INFO("worst balance " << worst << " of " << most);
    CHECK(worst <= 1e-9 * most);
  }
}
