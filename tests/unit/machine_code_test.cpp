// Instructions as machine code: each value is the interpreter's, to the bit.
#include "program/machine_code.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <random>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::string kLine = "table('" BGSIM_SOURCE_DIR "/tests/extremes/data/near.csv', 'u', ";
const std::string kCurve = "table('" BGSIM_SOURCE_DIR "/models/reference/bellow.step.csv', 'x', ";

/// Two capacitors, the first of them fed by a law of time and both charges.
CompiledModel fed_by(const std::string& flow) {
  return compile_text(R"({ "bgsim": 1, "name": "fed", "parameters": { "k": 3, "T": 1.7 },
    "elements": {
      "source": { "kind": "MSf", "flow": ")" +
                      flow + R"(" }, "n": { "kind": "0" }, "a": { "kind": "C", "capacitance": 2 },
      "other": { "kind": "MSf", "flow": "1 - a.q" }, "n2": { "kind": "0" }, "b": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "source", "to": "n" }, { "from": "n", "to": "a" },
               { "from": "other", "to": "n2" }, { "from": "n2", "to": "b" } ],
    "outputs": { "a": "a.q" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })");
}

/// Sums of so many products, so that registers run out and instructions go into strips.
std::string many(int terms) {
  std::string text = "a.q";
  for (int i = 1; i <= terms; ++i) {
    const std::string n = std::to_string(i);
    text += " + (a.q - " + n + ")*(b.q + " + n + "/7)/(t + " + n + ")";
  }
  return text;
}

MachineCode::Entry code_of(MachineCode& made, const CodeList& list, MachineCode::Width width) {
  MachineCode::Entry entry = nullptr;
  for (int k = 0; k < 1000 && entry == nullptr; ++k) entry = made.of(list, width);
  return entry;
}

bool has_machine_code() {
#if defined(__x86_64__) && defined(__linux__)
  return __builtin_cpu_supports("avx") != 0;
#else
  return false;
#endif
}

bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

}  // namespace

TEST_CASE("machine code gives the interpreter's bits at one point and at four") {
  const std::vector<std::string> flows{
      "a.q*b.q - k*t",
      "-(a.q - b.q)/(k + t)",
      "abs(a.q) - abs(-b.q) + sqrt(2 + a.q)",
      "-abs(a.q*b.q)",
      "exp(-((a.q - 0.5)*20)^2) + a.q^3 + (3 + a.q)^b.q",
      "sin(30*a.q)*cos(b.q) + tanh(50*b.q) + tan(a.q)",
      "ssqrt(a.q - b.q, 1e-3) + hypot(a.q, b.q) + atan2(2 + a.q, b.q)",
      "cbrt(a.q) + log(4 + b.q) + log10(4 + a.q) + log1p(0.2*a.q^2) + expm1(b.q)",
      "asin(a.q/9) + acos(b.q/9) + atan(9*a.q) + sinh(a.q) + cosh(b.q) + asinh(a.q) + acosh(5 + a.q) + atanh(b.q/9)",
      "min(a.q, b.q) - max(t, a.q)",
      "if(a.q > 0.3 and b.q < 0.2 or not (t > 0.5), a.q^3, exp(b.q))",
      "floor(3*a.q)*a.q + mod(b.q, 0.7) + sign(b.q)*abs(a.q) + ceil(b.q) + round(a.q) + step(t - 0.5)",
      kLine + "a.q + 1)*b.q + " + kCurve + "0.25 + 0.2*b.q, spline)",
      many(12),
      many(40),
      many(200)};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  int compared = 0;
  for (const std::string& flow : flows) {
    INFO(flow.substr(0, 100));
    const CompiledModel model = fed_by(flow);
    const Program& program = model.program;
    REQUIRE(program.rates.code.size() == 1);
    const CodeList& list = program.rates.code.front();
    MachineCode made(program);
    const MachineCode::Entry one = code_of(made, list, MachineCode::Width::one);
    const MachineCode::Entry four = code_of(made, list, MachineCode::Width::four);
    const bool expected = has_machine_code() && list.size() <= 512;
    REQUIRE((one != nullptr) == expected);
    REQUIRE((four != nullptr) == expected);
    if (one == nullptr) continue;
    Evaluator evaluator(program, model.inputs.parameters);
    Branch branch = first_branch(program);
    std::vector<double> slots(evaluator.constants().begin(), evaluator.constants().end());
    std::vector<double> wide;
    for (const double slot : slots) wide.insert(wide.end(), 4, slot);
    for (int round = 0; round < 40; ++round) {  // few enough that the evaluator itself interprets
      for (double& mode : branch.modes) mode = number(random) > 0.0 ? 1.0 : 0.0;
      const std::size_t points = 1 + static_cast<std::size_t>(round % 4);
      for (std::size_t l = 0; l < points; ++l) {
        const double t = 0.5 + 0.5 * number(random);
        const std::array<double, 2> x{number(random), number(random)};
        slots[program.time_slot] = t;
        std::copy(x.begin(), x.end(), slots.begin() + program.first_state);
        std::copy(branch.modes.begin(), branch.modes.end(), slots.begin() + program.first_mode);
        for (std::size_t i = 0; i < program.first_parameter; ++i) wide[4 * i + l] = slots[i];
        one(slots.data(), 1);
        std::array<double, 2> rates{};
        if (!evaluator.rates(t, x.data(), branch, rates.data())) continue;
        for (std::size_t i = 0; i < 2; ++i) {
          ++compared;
          CHECK(same(slots[program.rates.results[i]], rates[i]));
        }
      }
      four(wide.data(), points);
      for (std::size_t l = 0; l < points; ++l) {
        const std::array<double, 2> x{wide[4 * program.first_state + l], wide[4 * (program.first_state + 1) + l]};
        std::array<double, 2> rates{};
        if (!evaluator.rates(wide[4 * program.time_slot + l], x.data(), branch, rates.data())) continue;
        for (std::size_t i = 0; i < 2; ++i) CHECK(same(wide[4 * program.rates.results[i] + l], rates[i]));
      }
    }
  }
  if (has_machine_code()) CHECK(compared > 1000);
}

TEST_CASE("rates do not change when an evaluator goes over to machine code") {
  const CompiledModel model = fed_by(kLine + "a.q + 1)*exp(b.q) - ssqrt(a.q, 1e-2)/(2 + sin(t)) + sqrt(abs(a.q*b.q))");
  Evaluator evaluator(model.program, model.inputs.parameters);
  Branch branch = first_branch(model.program);
  const std::array<double, 2> x{0.3, -0.4};
  REQUIRE(evaluator.initialize_modes(0.7, x.data(), branch));
  std::array<double, 2> first{}, later{};
  REQUIRE(evaluator.rates(0.7, x.data(), branch, first.data()));
  for (int k = 0; k < 1000; ++k) {
    REQUIRE(evaluator.rates(0.7, x.data(), branch, later.data()));
    REQUIRE(same(first[0], later[0]));
    REQUIRE(same(first[1], later[1]));
  }
  Evaluator::Points points;
  points.count = 2;
  std::array<std::array<double, 2>, 2> values{};
  for (std::size_t l = 0; l < 2; ++l) {
    points.t[l] = 0.7;
    points.x[l] = x.data();
    points.values[l] = values[l].data();
  }
  for (int k = 0; k < 1000; ++k) {
    REQUIRE(evaluator.rates(points, branch));
    REQUIRE((same(first[0], values[0][0]) && same(first[1], values[1][1])));
  }
}
