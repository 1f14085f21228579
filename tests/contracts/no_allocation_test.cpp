// The hot loop allocates nothing: operator new is counted while a system with loops, conditions and tables of powers is
// evaluated again and again.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#include "support/run.hpp"

namespace {
std::size_t allocations = 0;
}

// Not inlined: GCC would see free() meet a built-in operator new, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
// std::stable_sort asks this way; what one form gives the other takes back.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace bgsim;
using namespace bgsim::test;

TEST_CASE("evaluating rates, Jacobian, slopes by time, outputs, guards and powers allocates nothing") {
  const CompiledModel compiled = compile_text(R"json({ "bgsim": 1, "name": "busy",
    "elements": {
      "source": { "kind": "Se", "effort": "sin(t) + step(t - 0.5)" }, "loop": { "kind": "1" },
      "diode": { "kind": "R", "law": "f = 1e-3*(exp(e) - 1)" }, "r": { "kind": "R", "resistance": 2 },
      "node": { "kind": "0" }, "c": { "kind": "C", "law": "e = if(q > 0, 3*q, q)" },
      "branch": { "kind": "1" }, "l": { "kind": "I", "inertance": 1 },
      "coulomb": { "kind": "R", "law": "e = 0.1*sign(f) + f" }
    },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "diode" }, { "from": "loop", "to": "r" },
      { "from": "loop", "to": "node" }, { "from": "node", "to": "c" }, { "from": "node", "to": "branch" },
      { "from": "branch", "to": "l" }, { "from": "branch", "to": "coulomb" } ],
    "outputs": { "q": "c.q", "i": "diode.f", "v": "coulomb.e" },
    "scenes": { "main": { "stop": 1, "samples": 3 } } })json");
  REQUIRE(!compiled.program.blocks.empty());
  Evaluator evaluator(compiled.program, compiled.inputs.parameters);
  std::vector<double> x{0.1, 0.2}, rates(2), outputs(3), guards(evaluator.guard_count()),
      powers(evaluator.energy_parts()), jacobian(compiled.program.jacobian_pattern.row.size());
  REQUIRE(evaluator.states() == 2);
  Branch branch = first_branch(compiled.program);
  REQUIRE(evaluator.initialize_modes(0.0, x.data(), branch));

  std::vector<double> by_time(2);
  bool good = evaluator.time_slopes(0.0, x.data(), branch, by_time.data());  // makes its code
  const std::size_t before = allocations;
  for (int i = 0; i < 1000; ++i) {
    const double t = 1e-3 * i;
    x[0] = 0.1 + 0.2 * t;
    x[1] = 0.2 - 0.1 * t;
    good = good && evaluator.rates(t, x.data(), branch, rates.data()) &&
           evaluator.jacobian(t, x.data(), branch, jacobian.data()) &&
           evaluator.time_slopes(t, x.data(), branch, by_time.data()) &&
           evaluator.outputs(t, x.data(), branch, outputs.data()) &&
           evaluator.guards(t, x.data(), branch, guards.data()) && evaluator.powers(t, x.data(), branch, powers.data());
  }
  const std::size_t made = allocations - before;
  CHECK(good);
  CHECK(made == 0);
}

TEST_CASE("a longer run allocates no more than a short one, but for its trace") {
  const std::string text = R"json({ "bgsim": 1, "name": "oscillator",
    "elements": { "loop": { "kind": "1" }, "l": { "kind": "I", "inertance": 1 },
      "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "r": { "kind": "R", "resistance": 0.01 } },
    "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" }, { "from": "loop", "to": "r" } ],
    "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 10, "samples": 2 } } })json";
  const Method method = GENERATE(Method::automatic, Method::radau9, Method::radau13, Method::rodas5p);
  CAPTURE(method_name(method));
  CompiledModel model = compile_text(text, with_method(method));
  const auto count = [&model](double stop) {
    model.inputs.stop = stop;
    model.inputs.output_times = {0.0, stop};
    const std::size_t before = allocations;
    const RunResult result = model.run();
    REQUIRE(result.stop == StopReason::completed);
    return std::pair(allocations - before, result.report.steps);
  };
  const auto [few, short_run] = count(10.0);
  const auto [many, long_run] = count(1000.0);
  CHECK(long_run > 10 * short_run);
  // the scales of the states are estimated again at 20, 160, 1280, ... steps
  CHECK(many < few + 200);
}
