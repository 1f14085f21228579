// Thyristors (D with fire) that wait under a forward voltage, and that stay off once their current has ended.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Two thyristors in series with a resistor and a coil, on sin(t). @param first, second  conditions.
std::string two_in_series(const std::string& first, const std::string& second) {
  return R"json({ "bgsim": 1, "name": "two",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "j": { "kind": "1" },
      "t1": { "kind": "D", "fire": ")json" +
         first + R"json(" }, "t2": { "kind": "D", "fire": ")json" + second + R"json(" },
      "r": { "kind": "R", "resistance": 1 }, "l": { "kind": "I", "inertance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "t1" }, { "from": "j", "to": "t2" },
      { "from": "j", "to": "r" }, { "from": "j", "to": "l" } ],
    "outputs": { "i": "l.f" }, "scenes": { "main": { "stop": 12.5, "samples": 126, "relative": 1e-10 } } })json";
}

RunResult run_of(const std::string& text) { return run(Study::from_text(text)); }

/// From 0 at @p begin on, in the first half wave, until it is 0 again.
double current(double t, double begin) {
  if (t < begin || t > 6.0) return 0.0;
  const auto forced = [](double at) { return (std::sin(at) - std::cos(at)) / 2.0; };
  const double i = forced(t) - forced(begin) * std::exp(begin - t);
  return t > begin + 0.5 && i < 0.0 ? 0.0 : i;
}

}  // namespace

TEST_CASE("a thyristor that waits under a forward voltage conducts when it is fired, whatever happened before") {
  // A diode beside it goes out at pi/2, where the thyristor waits under the whole voltage: a stretch begins there.
  const RunResult one = run_of(R"json({ "bgsim": 1, "name": "beside",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "j": { "kind": "1" },
      "t1": { "kind": "D", "fire": "t > 2 and t < 2.1" },
      "r": { "kind": "R", "resistance": 1 }, "l": { "kind": "I", "inertance": 1 },
      "v": { "kind": "Se", "effort": "cos(t)" }, "k": { "kind": "1" }, "d": { "kind": "D" },
      "r2": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "t1" }, { "from": "j", "to": "r" },
      { "from": "j", "to": "l" }, { "from": "v", "to": "k" }, { "from": "k", "to": "d" }, { "from": "k", "to": "r2" } ],
    "outputs": { "i": "l.f", "other": "r2.f" },
    "scenes": { "main": { "stop": 12.5, "samples": 126, "relative": 1e-10 } } })json");
  const std::vector<double> i = column(one, "i"), other = column(one, "other");
  REQUIRE(i.size() == 126);
  for (std::size_t k = 0; k < i.size(); ++k) {
    CAPTURE(one.trace.times[k]);
    CHECK(std::abs(i[k] - current(one.trace.times[k], 2.0)) < 1e-8);  // a hundred tolerances of a step
    CHECK(std::abs(other[k] - std::max(0.0, std::cos(one.trace.times[k]))) < 1e-12);
  }
}

TEST_CASE("a thyristor whose current has ended stays off until it is fired, also where another one keeps it without") {
  // In the second period t2 alone is fired: t1 went out with the first half wave.
  const RunResult one = run_of(two_in_series("t > 1 and t < 1.1", "(t > 1 and t < 1.1) or (t > 7.2 and t < 7.4)"));
  const std::vector<double> i = column(one, "i");
  REQUIRE(i.size() == 126);
  for (std::size_t k = 0; k < i.size(); ++k) {
    CAPTURE(one.trace.times[k]);
    CHECK(std::abs(i[k] - current(one.trace.times[k], 1.0)) < 1e-8);
  }
  const RunResult other = run_of(two_in_series("(t > 1 and t < 1.1) or (t > 7.2 and t < 7.4)", "t > 1 and t < 1.1"));
  CHECK(std::abs(at(other, "i", 8.0)) < 1e-8);
  const RunResult both =
      run_of(two_in_series("mod(t, 2*pi) > 1 and mod(t, 2*pi) < 1.1", "mod(t, 2*pi) > 1 and mod(t, 2*pi) < 1.1"));
  CHECK(at(both, "i", 8.0) == Approx(current(8.0 - 2.0 * M_PI, 1.0)).margin(1e-8));
}

TEST_CASE("a thyristor that carries nothing when its fire ends is off, though nothing has turned its current back") {
  struct Case {
    const char* what;
    std::string source, fire, more, stop;
    double (*current)(double);
  };
  const std::string half_wave = "max(0, sin(t))";
  const Case cases[] = {
      {"a switch in series has opened before", "5", "t < 1",
       R"(, "s": { "kind": "Sw", "closed": "t < 0.5 or t > 1.5" })", "2.5",
       [](double t) { return t < 0.5 ? 5.0 : 0.0; }},
      {"the source rests at 0", "if(t < 0.5 or t > 1.5, 5, 0)", "t < 0.3", "", "2.5",
       [](double t) { return t < 0.5 ? 5.0 : 0.0; }},
      {"a half wave ends at 0", half_wave, "t > 1 and t < 2", "", "8",
       [](double t) { return t > 1.0 && t < 3.14 ? std::sin(t) : 0.0; }},
      {"a diode in series blocks", "if(t < 0.6 or t > 1.3, 5, -1)", "t < 1", R"(, "s": { "kind": "D" })", "2.5",
       [](double t) { return t < 0.6 ? 5.0 : 0.0; }},
      {"a diode in series blocks before the fire ends", "sin(t)", "mod(t, 2*pi) > 1 and mod(t, 2*pi) < 3.5",
       R"(, "s": { "kind": "D" })", "20",
       [](double t) {
         const double phase = std::fmod(t, 6.283185307179586);
         return phase > 1.0 && phase < 3.1416 ? std::sin(t) : 0.0;
       }},
      {"a resistor in series alone", "sin(t)", "mod(t, 2*pi) > 1 and mod(t, 2*pi) < 1.5", "", "20",
       [](double t) {
         const double phase = std::fmod(t, 6.283185307179586);
         return phase > 1.0 && phase < 3.1416 ? std::sin(t) : 0.0;
       }},
  };
  for (const Case& each : cases)
    for (const bool thyristor_last : {false, true}) {
      INFO(each.what << (thyristor_last ? ", the thyristor last" : ""));
      const std::string thyristor = R"("h": { "kind": "D", "fire": ")" + each.fire + "\" }";
      const std::string more = each.more.empty() ? "" : each.more.substr(2);
      const std::string elements = more.empty()     ? thyristor
                                   : thyristor_last ? more + ", " + thyristor
                                                    : thyristor + ", " + more;
      const RunResult result = run_of(
          R"({ "bgsim": 1, "name": "ends", "elements": { "v": { "kind": "Se", "effort": ")" + each.source +
          R"(" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 }, )" + elements +
          R"( }, "bonds": [ { "from": "v", "to": "j" }, { "from": "j", "to": "r" },
          { "from": "j", "to": "h" })" +
          (more.empty() ? "" : R"(, { "from": "j", "to": "s" })") +
          R"( ], "outputs": { "i": "r.f" }, "scenes": { "run": { "stop": )" + each.stop + R"(, "samples": 98 } } })");
      const std::vector<double> i = column(result, "i");
      REQUIRE(i.size() == 98);
      for (std::size_t k = 0; k < i.size(); ++k) {
        CAPTURE(result.trace.times[k]);
        // No state: rounding. No sample is within 1e-3 of an edge.
        CHECK(std::abs(i[k] - each.current(result.trace.times[k])) < 1e-12);
      }
    }
}

TEST_CASE("a thyristor that carries a current does not end because another one shorts the source") {
  // t1 carries 10 (1 - exp(-1)) when what is beside the load is closed: it cannot block, and there is nothing else.
  for (const char* const shorts :
       {R"({ "kind": "D", "fire": "t > 1 and t < 1.1" })", R"({ "kind": "Sw", "closed": "t > 1" })"}) {
    INFO(shorts);
    const RunResult result =
        Study::from_text(R"({ "bgsim": 1, "name": "shorted", "elements": { "v": { "kind": "Se", "effort": 10 },
      "w": { "kind": "1" }, "n": { "kind": "0" }, "t1": { "kind": "D", "fire": "t < 0.1" }, "t2": )" +
                         std::string(shorts) + R"(, "j": { "kind": "1" }, "l": { "kind": "I", "inertance": 1 },
      "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "v", "to": "w" }, { "from": "w", "to": "t1" }, { "from": "w", "to": "n" },
      { "from": "n", "to": "t2" }, { "from": "n", "to": "j" }, { "from": "j", "to": "l" }, { "from": "j", "to": "r" } ],
    "outputs": { "i": "l.f" }, "scenes": { "run": { "stop": 2, "samples": 5 } } })")
            .scene()
            .simulate(one_run());
    REQUIRE(result.stop == StopReason::failed);
    CHECK(result.failure->code == "BG622");
    CHECK(result.failure->situation.find("at t = 1 no sides of the diodes are possible") != std::string::npos);
    CHECK(std::abs(last(result, "i") - 10.0 * (1.0 - std::exp(-1.0))) < 1e-5);  // at 1 s; a tolerance of the range
  }
  // Beside a reverse source it gives its current to the other one at once, which takes it over.
  const RunResult commutates = run_of(R"({ "bgsim": 1, "name": "over", "elements": {
      "v": { "kind": "Se", "effort": 10 }, "w": { "kind": "1" }, "n": { "kind": "0" },
      "t1": { "kind": "D", "fire": "t < 0.1" }, "v2": { "kind": "Se", "effort": 20 }, "w2": { "kind": "1" },
      "t2": { "kind": "D", "fire": "t > 1 and t < 1.1" }, "j": { "kind": "1" },
      "l": { "kind": "I", "inertance": 1 }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "v", "to": "w" }, { "from": "w", "to": "t1" }, { "from": "w", "to": "n" },
      { "from": "v2", "to": "w2" }, { "from": "w2", "to": "t2" }, { "from": "w2", "to": "n" },
      { "from": "n", "to": "j" }, { "from": "j", "to": "l" }, { "from": "j", "to": "r" } ],
    "outputs": { "i": "l.f", "i1": "t1.f" }, "scenes": { "run": { "stop": 2, "samples": 5 } } })");
  CHECK(std::abs(last(commutates, "i") - (20.0 + (-20.0 + 10.0 * (1.0 - std::exp(-1.0))) * std::exp(-1.0))) < 2e-5);
  CHECK(last(commutates, "i1") == 0.0);
}

TEST_CASE("a thyristor that has ended on the side on which it conducts leaves that by no rounding") {
  // Seven of eight thyristors between a source and a load of 6 and 2 mH: two half waves forwards, two backwards, in
  // four periods. Where the current ends all of them are off, one of them without an effort of its own.
  struct Valve {
    std::string name, from, to;
    std::vector<double> starts;
  };
  const double first = 0.002212998228016705, omega = 314.1592653589793;
  const std::vector<Valve> valves{{"t1p", "n2", "n3", {0.0, 0.02}},  {"t3p", "", "n3", {0.01, 0.03}},
                                  {"t4p", "n4", "", {0.0, 0.02}},    {"t1n", "n2", "n4", {0.04, 0.06}},
                                  {"t2n", "n3", "n2", {0.05, 0.07}}, {"t3n", "", "n4", {0.05, 0.07}},
                                  {"t4n", "n3", "", {0.04, 0.06}}};
  std::ostringstream elements, bonds;
  elements.precision(17);
  for (const Valve& valve : valves) {
    elements << ", \"j" << valve.name << R"(": { "kind": "1" }, ")" << valve.name << R"(": { "kind": "D", "fire": ")";
    for (const double start : valve.starts)
      elements << (start == valve.starts.front() ? "" : " or ") << "(t >= " << first + start << " and mod(t - "
               << first + start << ", 0.08) < 0.00096)";
    elements << "\" }";
    bonds << R"(, { "from": "j)" << valve.name << R"(", "to": ")" << valve.name << "\" }";
    if (!valve.from.empty()) bonds << R"(, { "from": ")" << valve.from << R"(", "to": "j)" << valve.name << "\" }";
    if (!valve.to.empty()) bonds << R"(, { "from": "j)" << valve.name << R"(", "to": ")" << valve.to << "\" }";
  }
  const std::string text =
      R"j({ "bgsim": 1, "name": "cycloconverter", "elements": {
      "n2": { "kind": "0" }, "n3": { "kind": "0" }, "n4": { "kind": "0" }, "n5": { "kind": "0" },
      "vs": { "kind": "Se", "effort": "100*sin(314.1592653589793*t)"
}, "j_ls": { "kind": "1" },
      "ls": { "kind": "I", "inertance": 5e-5 }, "j_r": { "kind": "1" }, "r": { "kind": "R", "resistance": 6 },
      "j_ll": { "kind": "1" }, "ll": { "kind": "I", "inertance": 0.002 }, "rg": { "kind": "R", "resistance": 1e4 })j" +
      elements.str() + R"( },
    "bonds": [ { "from": "vs", "to": "j_ls" }, { "from": "j_ls", "to": "ls" }, { "from": "j_ls", "to": "n2" },
      { "from": "n3", "to": "j_r" }, { "from": "j_r", "to": "r" }, { "from": "j_r", "to": "n5" },
      { "from": "n5", "to": "j_ll" }, { "from": "j_ll", "to": "ll" }, { "from": "j_ll", "to": "n4" },
      { "from": "n4", "to": "rg" })" +
      bonds.str() + R"( ], "outputs": { "i": "ll.f" }, "scenes": { "run": { "stop": 0.158024, "samples": 302 } } })";
  const double inductance = 0.00205, angle = std::atan2(omega * inductance, 6.0);
  const double peak = 100.0 / std::hypot(omega * inductance, 6.0);
  const auto half_wave = [&](double since) {  // of the firing, in a half wave that begins a time `first` before it
    const double i = peak * (std::sin(omega * (first + since) - angle) -
                             std::sin(omega * first - angle) * std::exp(-6.0 / inductance * since));
    return since < 0.0 || (since > 0.004 && i < 0.0) || since > 0.0095 ? 0.0 : i;
  };
  for (const Method method : {Method::automatic, Method::bdf, Method::radau}) {
    INFO(method_name(method));
    const RunResult run = Study::from_text(text).scene({}, with_method(method, 1e-7)).simulate(one_run());
    REQUIRE(run.stop == StopReason::completed);
    const std::vector<double> i = column(run, "i");
    for (std::size_t k = 0; k < i.size(); ++k) {
      double known = 0.0;
      for (const double period : {0.0, 0.08}) {
        for (const double start : {0.0, 0.02}) known += half_wave(run.trace.times[k] - first - period - start);
        for (const double start : {0.04, 0.05, 0.06, 0.07})
          known -= half_wave(run.trace.times[k] - first - period - start);
      }
      CAPTURE(run.trace.times[k]);
      CHECK(std::abs(i[k] - known) < 2e-3);  // of 17: what rg draws through ls
    }
  }
}
