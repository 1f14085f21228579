// What a run of a two-state model pays for: an oscillator by itself, then with one thing more at a time. Each variant
// is run in turn, many times over, and the least time of each is compared with that of plain CVODE on two lines of C++,
// within one run of this program, so that the machine's speed cancels.
//   bench_two_states [ROUNDS]      default: 200
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "two_states_plain.hpp"

namespace {

using namespace bgsim;

struct Variant {
  std::string name;
  std::string signals, outputs, scene;  ///< JSON members that differ
  std::string resistance = "0.2";
  bool audit = false;
  std::size_t branches = 0;  ///< further oscillators that no output looks at
  bool keep_all = false;
};

std::string model_json(const Variant& v) {
  std::string elements =
      R"("s": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" }, "r": { "kind": "MR", "resistance": ")" +
      v.resistance + R"(" }, "l": { "kind": "I", "inertance": 1 }, "c": { "kind": "C", "capacitance": 1 })";
  std::string bonds =
      R"({ "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" })";
  for (std::size_t i = 0; i < v.branches; ++i) {
    const std::string n = std::to_string(i);
    elements += ", \"s" + n + R"(": { "kind": "Se", "effort": 1 }, "loop)" + n + R"(": { "kind": "1" }, "r)" + n +
                R"(": { "kind": "R", "resistance": 0.2 }, "l)" + n + R"(": { "kind": "I", "inertance": 1 }, "c)" + n +
                R"(": { "kind": "C", "capacitance": 1 })";
    for (const char* to : {"r", "l", "c"}) bonds += R"(, { "from": "loop)" + n + R"(", "to": ")" + to + n + R"(" })";
    bonds += R"(, { "from": "s)" + n + R"(", "to": "loop)" + n + R"(" })";
  }
  return R"({ "bgsim": 1, "name": "two_states", "signals": {)" + v.signals + R"(}, "elements": {)" + elements +
         R"(}, "bonds": [)" + bonds + R"(], "outputs": {)" + v.outputs + R"(}, "scenes": { "run": {)" + v.scene +
         "} } }";
}

const std::string kFew = R"("stop": 200, "samples": 2, "relative": 1e-6, "absolute": 1e-9)";

std::vector<Variant> variants() {
  const std::string q = R"("q": "c.q")";
  std::vector<Variant> list;
  list.push_back({"bare: one output, two times", "", q, kFew});
  list.push_back({"2001 output times", "", q, R"("stop": 200, "samples": 2001, "relative": 1e-6, "absolute": 1e-9)"});
  list.push_back({"energy audit", "", q, kFew});
  list.back().audit = true;
  list.push_back({"one condition, never met", "", q, kFew, "if(c.q > 100, 0.3, 0.2)"});
  list.push_back({"one condition, met every swing", "", q, kFew, "if(t < 190 and c.q > 1, 0.02, 0.01)"});
  list.push_back({"20 oscillators nobody looks at", "", q, kFew});
  list.back().branches = 20;
  list.push_back({"the same with --keep-all", "", q, kFew});
  list.back().branches = 20;
  list.back().keep_all = true;
  return list;
}

/// A variant compiled, and how long its runs take.
struct Candidate {
  explicit Candidate(const Variant& v)
      : model(std::make_shared<const Model>(read_model_text("two_states.json", model_json(v)))),
        scene(Study(model).scene("", {}, {.energy_audit = v.audit, .keep_all = v.keep_all})),
        audit(v.audit) {}

  void run() {
    SimulateOptions how;
    how.energy_audit = audit;
    how.error_estimate = audit;
    const double begin = bench::cpu_seconds();
    const RunResult result = scene.simulate(how);
    seconds = std::min(seconds, bench::cpu_seconds() - begin);
    if (result.stop != StopReason::completed) {
      std::fprintf(stderr, "a run did not end: %s\n", result.failure->situation.c_str());
      std::exit(1);
    }
    steps = result.report.steps;
    events = result.report.state_events;
  }

  std::shared_ptr<const Model> model;
  Simulation scene;
  bool audit;
  double seconds = std::numeric_limits<double>::infinity();
  std::uint64_t steps = 0, events = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const std::size_t rounds = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 200;
  const std::vector<Variant> all = variants();
  std::vector<Candidate> candidates(all.begin(), all.end());
  double plain = std::numeric_limits<double>::infinity();
  bench::PlainRun last;
  for (std::size_t i = 0; i < rounds; ++i) {
    const double begin = bench::cpu_seconds();
    last = bench::plain_oscillator(200.0, 1e-6, 1e-9);
    plain = std::min(plain, bench::cpu_seconds() - begin);
    for (Candidate& candidate : candidates) candidate.run();
  }
  const double per_step = plain / static_cast<double>(last.steps);
  std::printf("%-32s %8s %8s %10s %10s %14s\n", "run", "steps", "events", "time", "to plain", "a step to plain");
  std::printf("%-32s %8lu %8d %7.3f ms %10.2f %14.2f\n", "plain CVODE", last.steps, 0, 1e3 * plain, 1.0, 1.0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Candidate& c = candidates[i];
    std::printf("%-32s %8lu %8lu %7.3f ms %10.2f %14.2f\n", all[i].name.c_str(), c.steps, c.events, 1e3 * c.seconds,
                c.seconds / plain, c.seconds / static_cast<double>(c.steps) / per_step);
  }
}
