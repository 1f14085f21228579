// Hundreds and a thousand ideal diodes: side by side, as clamps along a ladder, and as a bank of rectifiers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr double kPi = std::numbers::pi;

struct Text {
  std::string elements, bonds, outputs;

  void element(const std::string& name, const std::string& body) {
    elements += (elements.empty() ? "\"" : ", \"") + name + "\": {" + body + "}";
  }
  void bond(const std::string& from, const std::string& to) {
    bonds += (bonds.empty() ? R"({"from": ")" : R"(, {"from": ")") + from + R"(", "to": ")" + to + "\"}";
  }
  void output(const std::string& name, const std::string& value) {
    outputs += (outputs.empty() ? "\"" : ", \"") + name + R"(": ")" + value + "\"";
  }
  [[nodiscard]] RunResult run(const std::string& scene) const {
    SimulateOptions options = untimed();
    options.second_run = false;
    const std::string text = R"({"bgsim": 1, "name": "many", "elements": {)" + elements + R"(}, "bonds": [)" + bonds +
                             R"(], "outputs": {)" + outputs + R"(}, "scenes": {"run": {)" + scene + "}}}";
    RunResult result = Study::from_text(text).scene().simulate(options);
    INFO((result.failure ? result.failure->situation : ""));
    REQUIRE(result.stop == StopReason::completed);
    return result;
  }
};

/// All let go, and take over again, in the same instants.
/// @param changes  of the mode before the end: one at each pi
void side_by_side(int count, int changes) {
  Text text;
  text.element("source", R"x("kind": "Se", "effort": "sin(t)")x");
  text.element("loop", R"("kind": "1")");
  text.element("r", R"("kind": "R", "resistance": 2)");
  text.element("node", R"("kind": "0")");
  text.bond("source", "loop");
  text.bond("loop", "r");
  text.bond("loop", "node");
  for (int i = 0; i < count; ++i) {
    text.element("d" + std::to_string(i), R"("kind": "D")");
    text.bond("node", "d" + std::to_string(i));
  }
  text.output("i", "r.f");
  const RunResult result = text.run("\"stop\": " + std::to_string(3.5 + 3 * (changes - 1)) + R"(, "samples": 101)");
  const std::vector<double> current = column(result, "i");
  for (std::size_t k = 0; k < current.size(); ++k)
    CHECK(current[k] == Approx(std::max(0.0, std::sin(result.trace.times[k]) / 2.0)).margin(1e-12));
  CHECK(result.report.mode_changes == static_cast<std::uint64_t>(changes));
}

/// Of a network of passive parts there is one solution: the one in which each clamp keeps 0 <= f, e <= 0, f e = 0.
void ladder(int count, double stop) {
  Text text;
  const auto name = [](const char* kind, int i) { return kind + std::to_string(i); };
  const double n = count;
  text.element("source", R"x("kind": "Se", "effort": "2*sin(t)")x");
  std::string before = "source";
  for (int i = 0; i < count; ++i) {
    text.element(name("j", i), R"("kind": "1")");
    text.element(name("r", i), R"("kind": "R", "resistance": )" + std::to_string(1.0 / n));
    text.element(name("n", i), R"("kind": "0")");
    text.element(name("c", i), R"("kind": "C", "capacitance": )" + std::to_string(1.0 / n));
    text.element(name("k", i), R"("kind": "1")");
    text.element(name("d", i), R"("kind": "D")");
    text.element(name("rk", i), R"("kind": "R", "resistance": )" + std::to_string(0.01 * n));
    text.element(name("s", i), R"("kind": "Se", "effort": )" + std::to_string(1.0 + 0.5 * i / n));
    text.bond(before, name("j", i));
    text.bond(name("j", i), name("r", i));
    text.bond(name("j", i), name("n", i));
    text.bond(name("n", i), name("c", i));
    text.bond(name("n", i), name("k", i));
    for (const char* kind : {"d", "rk", "s"}) text.bond(name("k", i), name(kind, i));
    text.output(name("e", i), name("d", i) + ".e");
    text.output(name("f", i), name("d", i) + ".f");
    before = name("n", i);
  }
  const RunResult result = text.run("\"stop\": " + std::to_string(stop) + R"(, "samples": 11, "relative": 1e-7)");
  std::size_t conducting = 0;
  for (int i = 0; i < count; ++i) {
    const std::vector<double> e = column(result, name("e", i)), f = column(result, name("f", i));
    for (std::size_t k = 0; k < e.size(); ++k) {
      // Efforts and flows of 1: what an event is located to.
      CHECK(f[k] >= -1e-9);
      CHECK(e[k] <= 1e-9);
      CHECK(std::min(std::abs(e[k]), std::abs(f[k])) <= 1e-9);
      if (f[k] > 1e-6) ++conducting;
    }
  }
  CHECK(conducting > 0);
  CHECK(result.report.energy.relative < 1e-5);  // a hundred tolerances: each change of a side begins with order 1
}

/// Rectifiers with a resistor of 1 and a coil of 1, which do not touch each other, at `phases` phases.
void bank(int count, int phases) {
  Text text;
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    text.element("s" + number, R"x("kind": "Se", "effort": "sin(t + )x" + std::to_string(0.1 * (i % phases)) + ")\"");
    text.element("j" + number, R"("kind": "1")");
    text.element("d" + number, R"("kind": "D")");
    text.element("r" + number, R"("kind": "R", "resistance": 1)");
    text.element("l" + number, R"("kind": "I", "inertance": 1)");
    text.bond("s" + number, "j" + number);
    for (const char* kind : {"d", "r", "l"}) text.bond("j" + number, kind + number);
    text.output("i" + number, "l" + number + ".f");
  }
  const RunResult result = text.run(R"("stop": 5.2, "samples": 14)");
  for (int i = 0; i < count; ++i) {
    const double phase = std::stod(std::to_string(0.1 * (i % phases)));
    const std::vector<double> current = column(result, "i" + std::to_string(i));
    bool ended = false;
    for (std::size_t k = 0; k < current.size(); ++k) {
      const double t = result.trace.times[k];
      // i' + i = sin(t + phase) from 0; once it has come back to 0 it stays there until the next half wave.
      const double free = (std::sin(t + phase - kPi / 4) - std::sin(phase - kPi / 4) * std::exp(-t)) / std::sqrt(2.0);
      ended = ended || free < 0.0;
      CHECK(current[k] == Approx(ended ? 0.0 : free).margin(1e-5));  // ten tolerances
    }
    CHECK(ended);
  }
  CHECK(result.report.mode_changes == static_cast<std::uint64_t>(phases));
}

}  // namespace

TEST_CASE("a hundred ideal diodes side by side, as clamps of a ladder and in a bank of rectifiers", "[long]") {
  side_by_side(100, 3);
  ladder(100, 1.0);
  bank(100, 4);
}

TEST_CASE("a thousand ideal diodes side by side", "[long]") { side_by_side(1000, 1); }
TEST_CASE("a thousand ideal diodes as clamps of a ladder", "[long]") { ladder(1000, 0.545); }
TEST_CASE("a thousand ideal diodes in a bank of rectifiers", "[long]") { bank(1000, 2); }
