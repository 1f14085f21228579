// Limits of a run in steps and wall time, by clocks that the tests set.
#include <catch2/catch.hpp>
#include <iomanip>
#include <sstream>

#include "run/clock.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A mass on a spring, @p frequency rad per unit of time, damped by @p damping per unit of time.
std::string oscillator(double frequency, double damping, double stop, int samples = 11) {
  const auto number = [](double value) {
    std::ostringstream text;
    text << std::setprecision(17) << value;
    return text.str();
  };
  const std::string part = number(1.0 / frequency);
  const bool damped = damping > 0.0;
  return R"({ "bgsim": 1, "name": "oscillator", "elements": { "loop": { "kind": "1" },
      "mass": { "kind": "I", "inertance": )" +
         part + R"(, "initial": { "p": 1 } }, "spring": { "kind": "C", "capacitance": )" + part + " }" +
         (damped ? R"(, "damper": { "kind": "R", "resistance": )" + number(2.0 * damping / frequency) + " }" : "") +
         R"( }, "bonds": [ { "from": "loop", "to": "mass" }, { "from": "loop", "to": "spring" })" +
         (damped ? R"(, { "from": "loop", "to": "damper" })" : "") +
         R"( ], "outputs": { "q": "spring.q" }, "scenes": { "main": { "stop": )" + number(stop) +
         ", \"samples\": " + std::to_string(samples) + " } } }";
}

/// Goes on by @p tick at each look. One of 0.01 s to 0.05 s, or more, makes each evaluation a look (RunClock::look).
struct CountedClock {
  double tick;
  std::shared_ptr<std::uint64_t> looks = std::make_shared<std::uint64_t>(0);
  double operator()() const { return tick * static_cast<double>(++*looks); }
};

/// A run by @p clock.
RunResult run_by(const CountedClock& clock, const std::string& text, const SimulateOptions& options,
                 const SceneOverrides& overrides = {}) {
  const CompiledModel model = compile_text(text, overrides);
  return simulate(model.program, model.inputs, options, clock);
}

bool has_code(const RunResult& result, const std::string& code) {
  return result.failure && result.failure->code == code;
}

}  // namespace

TEST_CASE("a limit of time ends every method, also within a step") {
  for (const Method method :
       {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::erk2, Method::erk3, Method::erk4,
        Method::erk5, Method::erk6, Method::erk8, Method::dirk2, Method::dirk3, Method::dirk4, Method::dirk5,
        Method::euler, Method::rk4, Method::implicit_euler, Method::verlet}) {
    INFO(method_name(method));
    SceneOverrides overrides = with_method(method);
    if (facts_of(method).fixed_step()) overrides.step = 1e-3;
    const CountedClock clock{1.0};
    SimulateOptions options;
    options.time_limit = 500.0;
    const RunResult result = run_by(clock, oscillator(1.0, 0.0, 1e6), options, overrides);
    CHECK(result.stop == StopReason::failed);
    CHECK(has_code(result, "BG618"));
    // Each look is one evaluation. A step that has begun is not finished, whatever its stages are; to try it again some
    // dozens of times, as ARKODE does, costs nothing where each evaluation fails at once.
    CHECK(*clock.looks < 700);
    CHECK(result.rows >= 1);
    CHECK(result.report.reached < 1e6);
  }
}

TEST_CASE("a limit of time ends a model without states, and leaves one alone that is done before") {
  SimulateOptions options;
  options.time_limit = 300.0;
  options.energy_audit = false;
  const std::string grid = R"({ "bgsim": 1, "name": "grid",
    "elements": { "s": { "kind": "Se", "effort": "t" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "f": "r.f" }, "scenes": { "main": { "stop": 1, "samples": SAMPLES } } })";
  const auto with_samples = [&](const std::string& samples) {
    std::string text = grid;
    return text.replace(text.find("SAMPLES"), 7, samples);
  };
  const RunResult ended = run_by(CountedClock{1.0}, with_samples("100000"), options);
  CHECK(has_code(ended, "BG618"));
  CHECK(ended.rows < 320);
  CHECK(run_by(CountedClock{1.0}, with_samples("5"), options).stop == StopReason::completed);
}

TEST_CASE("a model without states is ended among known times, too, however many are between two rows") {
  const std::string pulses = R"json({ "bgsim": 1, "name": "pulses",
    "elements": { "s": { "kind": "MSe", "effort": "if(mod(1e9*t, 1) < 0.5, 1, 0)" },
                  "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "s", "to": "r" } ],
    "outputs": { "f": "r.f" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })json";
  for (const bool audit : {true, false}) {
    SimulateOptions options;
    options.energy_audit = audit;
    options.time_limit = 300.0;
    const CountedClock clock{1.0};
    const RunResult ended = run_by(clock, pulses, options);
    CHECK(has_code(ended, "BG618"));
    CHECK(*clock.looks < 320);  // the limit, and what is in hand then
    CHECK(ended.report.reached > 0.0);
    CHECK(ended.report.reached < 1e-6);
    int asked = 0;
    options.progress = [&](double) { return ++asked < 10; };
    CHECK(run_by(CountedClock{0.02}, pulses, options).stop == StopReason::interrupted);
  }
}

TEST_CASE("a limit of time is named as it was given where switches divide a run") {
  SimulateOptions options;
  options.time_limit = 0.05;  // of a run with 2e7 changes of the mode
  const RunResult ended = Study::from_text(R"({ "bgsim": 1, "name": "chopper", "elements": {
    "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "sw": { "kind": "Sw", "closed": "mod(t, 1) < 0.5" },
    "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "sw" }, { "from": "j", "to": "r" },
               { "from": "j", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 1e7, "samples": 11 } } })")
                              .scene("main")
                              .simulate(options);
  REQUIRE(has_code(ended, "BG618"));
  CHECK(ended.failure->situation.find("the limit of 0.05 s of wall time") == 0);
}

TEST_CASE("limits of time and interruptions hold where modes follow each other without a step") {
  // Three masses fall onto each other and the ground: ever more impacts within one instant.
  const std::string text = R"({ "bgsim": 1, "name": "stack", "elements": {
      "b0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1.5 }, "g0": { "kind": "Se", "effort": -15 },
      "b1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1.6 }, "g1": { "kind": "Se", "effort": -16 },
      "b2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 0.9 }, "g2": { "kind": "Se", "effort": -9 },
      "h0": { "kind": "0" }, "c0": { "kind": "contact", "gap": 0, "restitution": 0.3, "initial": { "q": -0.68 } },
      "h1": { "kind": "0" }, "c1": { "kind": "contact", "gap": 0, "restitution": 0, "initial": { "q": -0.76 } },
      "l0": { "kind": "1" }, "tf": { "kind": "TF", "modulus": -1 },
      "ground": { "kind": "contact", "gap": 0, "restitution": 0, "initial": { "q": -0.11 } } },
    "bonds": [ { "from": "b0", "to": "m0" }, { "from": "g0", "to": "b0" }, { "from": "b1", "to": "m1" },
      { "from": "g1", "to": "b1" }, { "from": "b2", "to": "m2" }, { "from": "g2", "to": "b2" },
      { "from": "b0", "to": "h0" }, { "from": "h0", "to": "b1" }, { "from": "h0", "to": "c0" },
      { "from": "b1", "to": "h1" }, { "from": "h1", "to": "b2" }, { "from": "h1", "to": "c1" },
      { "from": "b0", "to": "tf" }, { "from": "tf", "to": "l0" }, { "from": "l0", "to": "ground" } ],
    "outputs": { "v": "m0.f" }, "scenes": { "run": { "stop": 4, "samples": 11, "impacts": "sequential" } } })";
  SimulateOptions limited = untimed();
  limited.time_limit = 0.3;  // of some ten seconds, until the run is ended by its pace (BG617)
  const RunResult ended = Study::from_text(text).scene().simulate(limited);
  REQUIRE(has_code(ended, "BG618"));
  CHECK(ended.failure->situation.find("the limit of 0.3 s of wall time") == 0);
  SimulateOptions asking = untimed();
  int asked = 0;
  asking.progress = [&](double) { return ++asked < 10; };
  const RunResult interrupted = Study::from_text(text).scene().simulate(asking);
  CHECK(interrupted.stop == StopReason::interrupted);
  CHECK(has_code(interrupted, "BG606"));
}

TEST_CASE("a run whose pace is steady and hopeless is reported, then ended, and names what is fast") {
  std::vector<Diagnostic> remarks;
  SimulateOptions options;
  options.remark = [&](const Diagnostic& remark) { remarks.push_back(remark); };
  const RunResult result = run_by(CountedClock{0.02}, oscillator(1e9, 0.0, 1e4), options);
  REQUIRE(has_code(result, "BG617"));
  REQUIRE(remarks.size() == 1);
  CHECK(remarks[0].code == "BG616");
  for (const Diagnostic& said : {remarks[0], *result.failure}) {
    REQUIRE(said.notes.size() == 1);
    CHECK(said.notes[0].text.find("time constant of 1e-09") != std::string::npos);
    CHECK(said.notes[0].text.find("spring.q") != std::string::npos);
  }
  CHECK(result.rows >= 1);
}

TEST_CASE("a limit of time, or none at all, takes the place of the judgement by pace") {
  SimulateOptions options;
  options.max_steps = 5000;
  options.longest_run = 0.0;
  CHECK(has_code(run_by(CountedClock{0.02}, oscillator(1e9, 0.0, 1e4), options), "BG607"));
  options.longest_run = 86400.0;
  options.time_limit = 1e6;
  CHECK(has_code(run_by(CountedClock{0.02}, oscillator(1e9, 0.0, 1e4), options), "BG607"));
}

TEST_CASE("a run that rings at first is not ended if the ringing dies out") {
  // 1e6 rad/s over a scene of 1e6 s: hopeless, but for a damping that makes it be over after 0.01 s.
  SimulateOptions options;
  const RunResult damped = run_by(CountedClock{0.02}, oscillator(1e6, 2000.0, 1e6), options);
  CHECK(damped.stop == StopReason::completed);
  CHECK(has_code(run_by(CountedClock{0.02}, oscillator(1e6, 0.0, 1e6), options), "BG617"));
}

TEST_CASE("the clock does not show in the numbers") {
  const std::string text = oscillator(1.0, 0.0, 1000.0, 101);
  int remarks = 0;
  SimulateOptions slow;
  slow.longest_run = 0.0;
  slow.remark = [&](const Diagnostic&) { ++remarks; };
  const RunResult a = run_text(text), b = run_by(CountedClock{1.0}, text, slow);
  REQUIRE(b.stop == StopReason::completed);
  CHECK(remarks == 1);
  CHECK(a.trace.columns == b.trace.columns);
}

TEST_CASE("rows go to a sink as they come, and what the sink throws ends the run") {
  const std::string text = oscillator(1.0, 0.0, 10.0, 101);
  const RunResult kept = run_text(text);
  std::vector<double> times;
  std::vector<std::vector<double>> columns(kept.trace.columns.size());
  SimulateOptions options;
  options.rows = [&](double t, std::span<const double> row) {
    times.push_back(t);
    REQUIRE(row.size() == columns.size());
    for (std::size_t i = 0; i < row.size(); ++i) columns[i].push_back(row[i]);
  };
  const RunResult streamed = run_text(text, {}, options);
  CHECK(times == kept.trace.times);
  CHECK(columns == kept.trace.columns);
  CHECK(streamed.rows == 101);
  CHECK(streamed.trace.times.empty());
  CHECK(streamed.trace.names == kept.trace.names);
  options.rows = [](double t, std::span<const double>) {
    if (t > 5.0) throw std::runtime_error("full");
  };
  CHECK_THROWS_WITH(run_text(text, {}, options), "full");
}
