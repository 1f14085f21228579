// Instructions in strips: the same bits as one by one.
#include "program/strips.hpp"

#include <bit>
#include <catch2/catch.hpp>

#include "bgsim/evaluator.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A line of sections with a cubic spring each, all by one "repeat".
std::string line(int sections, const std::string& law) {
  return R"json({ "bgsim": 1, "name": "line", "parameters": { "k": 3, "m": 0.7 },
    "elements": { "wall": { "kind": "Sf", "flow": "0.1*sin(3*t)" },
      "n": { "kind": "0", "repeat": )json" +
         std::to_string(sections) + R"json( }, "v": { "kind": "1", "repeat": )json" + std::to_string(sections) +
         R"json( }, "s": { "kind": "C", "law": ")json" + law + R"json(", "repeat": )json" + std::to_string(sections) +
         R"json( }, "mass": { "kind": "I", "inertance": "m", "repeat": )json" + std::to_string(sections) + R"json( } },
    "bonds": [ { "from": "wall", "to": "n[1]" }, { "from": "n[i]", "to": "s[i]" }, { "from": "n[i]", "to": "v[i]" },
      { "from": "v[i]", "to": "mass[i]" }, { "from": "v[i]", "to": "n[i+1]" } ],
    "outputs": { "p": "mass[1].p" }, "scenes": { "main": { "stop": 1, "samples": 11 } } })json";
}

}  // namespace

TEST_CASE("strips give the same bits as instructions one by one") {
  for (const std::string law : {"e = k*q + 4*q^3", "e = q/k - abs(q)*q", "e = sinh(q) + q^2/k"}) {
    const CompiledModel model = compile_text(line(40, law));
    const Program& program = model.program;
    std::size_t in_rows = 0;
    for (const CodeList& code : program.rates.code) {
      std::uint32_t next = 0;
      for (const Strip& strip : code.strips) {
        CHECK(strip.first == next);
        next += strip.count;
        if (strip.kind == Strip::Kind::in_rows) ++in_rows;
      }
      CHECK(next == code.size());
    }
    CHECK(in_rows >= 2);
    const std::size_t n = program.state_names.size();
    std::vector<double> x(n), rates(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = 0.3 - 0.01 * static_cast<double>(i * i % 71);
    Evaluator evaluator(program, model.inputs.parameters);
    Branch branch = first_branch(program);
    REQUIRE(evaluator.rates(0.25, x.data(), branch, rates.data()));
    std::vector<double> slots(evaluator.constants().begin(), evaluator.constants().end());
    slots[program.time_slot] = 0.25;
    std::copy(x.begin(), x.end(), slots.begin() + program.first_state);
    for (const CodeList& code : program.rates.code)
      for (const Instruction& i : code) slots[i.out] = apply(i.op, slots[i.a], slots[i.b], slots[i.c]);
    for (std::size_t i = 0; i < n; ++i)
      CHECK(std::bit_cast<std::uint64_t>(slots[program.rates.results[i]]) == std::bit_cast<std::uint64_t>(rates[i]));
  }
}

TEST_CASE("strips keep what depends on each other apart") {
  // s3 = s0 + s1, s4 = s1 + s2, ... in rows; then a sum of the first two, which needs both.
  std::vector<Instruction> code;
  std::vector<std::uint32_t> depths;
  for (std::uint32_t i = 0; i < 12; ++i) code.push_back({Op::add, 20 + i, i, i + 1, 0}), depths.push_back(1);
  code.push_back({Op::add, 32, 20, 21, 0}), depths.push_back(2);
  const std::vector<Strip> strips = strips_of(code, depths);
  REQUIRE(strips.size() == 2);
  CHECK(strips[0].kind == Strip::Kind::in_rows);
  CHECK(strips[0].count == 12);
  CHECK(strips[0].a_step == 1);
  CHECK(strips[0].b_step == 1);
  CHECK(strips[1].kind == Strip::Kind::mixed);
  // Nothing is known of what depends on what: one by one.
  CHECK(strips_of(code, {}).size() == 1);
}
