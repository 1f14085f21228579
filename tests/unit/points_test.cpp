// Several points at once give what each gives by itself.
#include <bit>
#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A C fed by a flow that may depend on its own charge a.q and on that of another C, b.q; the flow is an output.
CompiledModel fed_by(const std::string& flow) {
  return compile_text(R"({ "bgsim": 1, "name": "fed", "parameters": { "k": 3 }, "elements": {
      "source": { "kind": "MSf", "flow": ")" +
                      flow + R"(" }, "n": { "kind": "0" }, "a": { "kind": "C", "capacitance": 2 },
      "other": { "kind": "MSf", "flow": "1 - a.q" }, "n2": { "kind": "0" }, "b": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "source", "to": "n" }, { "from": "n", "to": "a" },
               { "from": "other", "to": "n2" }, { "from": "n2", "to": "b" } ],
    "outputs": { "a": "a.q", "f": "source.f" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })");
}

struct Filled {
  std::array<std::array<double, 2>, Evaluator::Points::kMost> x{}, values{};
  Evaluator::Points points;
  explicit Filled(std::size_t count) {
    points.count = count;
    for (std::size_t k = 0; k < count; ++k) {
      points.x[k] = x[k].data();
      points.values[k] = values[k].data();
    }
  }
};

}  // namespace

TEST_CASE("several points at once have the rates and outputs of each, to the bit") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-0.9, 0.9);
  for (const char* flow :
       {"a.q*b.q - k*t", "exp(-((a.q - 0.5)*20)^2)", "sin(30*a.q)*cos(b.q) + tanh(50*b.q)", "ssqrt(a.q - b.q, 1e-3)",
        "sqrt(abs(a.q)) + cbrt(4 + b.q)", "min(a.q, b.q) - max(t, a.q)", "hypot(a.q, b.q) + atan2(2 + a.q*0.1, b.q)",
        "if(a.q > 0.3, a.q^3, exp(b.q))", "(3 + a.q)^b.q + log1p(0.2*a.q^2)", "floor(3*a.q)*a.q + mod(b.q, 0.7)",
        "-a.q/(b.q*b.q)", "sign(b.q)*abs(a.q)^1.5"}) {
    INFO(flow);
    const CompiledModel model = fed_by(flow);
    Evaluator evaluator(model.program, model.inputs.parameters);
    Branch branch = first_branch(model.program);
    for (std::size_t count = 1; count <= Evaluator::Points::kMost; ++count)
      for (int repeat = 0; repeat < 20; ++repeat) {
        Filled all(count);
        for (std::size_t k = 0; k < count; ++k) {
          all.x[k] = {number(random), number(random)};
          all.points.t[k] = number(random);
        }
        // Modes are the branch's, on whichever side of their borders the points are.
        REQUIRE(evaluator.initialize_modes(all.points.t[0], all.points.x[0], branch));
        for (const bool outputs : {false, true}) {
          REQUIRE((outputs ? evaluator.outputs(all.points, branch) : evaluator.rates(all.points, branch)));
          for (std::size_t k = 0; k < count; ++k) {
            std::array<double, 2> one{};
            const double t = all.points.t[k];
            REQUIRE((outputs ? evaluator.outputs(t, all.points.x[k], branch, one.data())
                             : evaluator.rates(t, all.points.x[k], branch, one.data())));
            for (const std::size_t i : {0U, 1U})
              CHECK(std::bit_cast<std::uint64_t>(all.values[k][i]) == std::bit_cast<std::uint64_t>(one[i]));
          }
        }
      }
  }
}

TEST_CASE("points are to be taken one by one where one has no value, or loops are to be solved") {
  const CompiledModel root = fed_by("sqrt(a.q)");
  Evaluator evaluator(root.program, root.inputs.parameters);
  const Branch branch = first_branch(root.program);
  Filled two(2);
  two.x = {{{0.25, 0.0}, {0.5, 0.0}}};
  CHECK(evaluator.rates(two.points, branch));
  two.x[1][0] = -0.5;
  CHECK_FALSE(evaluator.rates(two.points, branch));

  const CompiledModel loop = compile_text(R"({ "bgsim": 1, "name": "loop", "elements": {
      "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "r": { "kind": "R", "law": "e = f + f^3" },
      "r2": { "kind": "R", "law": "f = e" }, "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "r2" },
      { "from": "j", "to": "n" }, { "from": "n", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })");
  REQUIRE_FALSE(loop.program.blocks.empty());
  Evaluator solving(loop.program, loop.inputs.parameters);
  Filled one(1);
  CHECK_FALSE(solving.rates(one.points, first_branch(loop.program)));
}
