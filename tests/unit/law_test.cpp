// The way of a law through the stages: decided with the strokes, its data shared, its derivative written once.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>

#include "bgsim/bgsim.hpp"
#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// "q = ...": what the law of an element's first port is solved for, in the model's names.
std::string solved(const Stages& stages, const std::string& element) {
  const PortLaw& law = stages.causal.laws[stages.graph.port(stages.element(element), 0).index()];
  const auto name = [&](SymbolId symbol) { return symbol_name(stages.model, symbol); };
  const std::string wanted(1, letter(law.solved.wanted));
  if (law.solved.use == LawUse::implicit) return wanted + ": implicit";
  return wanted + " = " + to_text(stages.causal.pool, law.solved.solution, name);
}

std::string conjugate(const Stages& stages, const std::string& element) {
  const PortLaw& law = stages.causal.laws[stages.graph.port(stages.element(element), 0).index()];
  const auto name = [&](SymbolId symbol) { return symbol_name(stages.model, symbol); };
  return law.conjugate.valid() ? to_text(stages.causal.pool, law.conjugate, name) : "none";
}

/// The right side of an unknown's equation, before any other is put into it.
ExprId equation_of(const EquationSystem& system, const std::string& name) {
  for (const Equation& equation : system.equations)
    if (system.symbols[equation.unknown.index()].name == name) return equation.expression;
  FAIL("no equation for " << name);
  return {};
}

std::string text_of(const EquationSystem& system, ExprId expression) {
  return to_text(system.pool, expression, [&](SymbolId s) { return system.symbols[s.index()].name; });
}

std::size_t operators(const ExprPool& pool, ExprId root) {
  std::size_t count = 0;
  for (const ExprId e : reachable(pool, std::array{root})) count += arity(pool[e].op) > 0 ? 1U : 0U;
  return count;
}

}  // namespace

TEST_CASE("the causal graph carries each law solved for what its port gives") {
  CHECK(solved(Stages(sketch("Se:s 1:j R:x=5 C:c=2", "s>j j>x j>c")), "x") == "f = x.e/5");
  CHECK(solved(Stages(sketch("Se:s 1:j R:x=5 C:c=2", "s>j j>x j>c")), "c") == "e = c.q/2");
  CHECK(solved(Stages(sketch("Se:s 1:j R:x=5 I:i=2", "s>j j>x j>i")), "x") == "e = 5*x.f");
  CHECK(solved(Stages(sketch("Se:s 1:j R:x=5 I:i=2", "s>j j>x j>i")), "i") == "f = i.p/2");
  CHECK(solved(Stages(sketch("Sf:s=3 R:x", "s>x")), "s") == "f = 3");
}

TEST_CASE("in derivative causality a store gives what it holds, and keeps its law the other way round") {
  const Stages linear(sketch("Se:s C:c=5", "s>c"));
  CHECK(solved(linear, "c") == "q = 5*c.e");
  CHECK(conjugate(linear, "c") == "c.q/5");
  const Stages cubic(sketch("Se:s", "s>c", R"("c": { "kind": "C", "law": "q = 2*e^3" })"));
  CHECK(solved(cubic, "c") == "q = 2*c.e^3");
  CHECK(conjugate(cubic, "c") == "cbrt(c.q/2)");
  const Stages implicit(sketch("Se:s", "s>c", R"("c": { "kind": "C", "law": "q = e + e^3" })"));
  CHECK(conjugate(implicit, "c") == "none");
}

TEST_CASE("a law without a closed form is used implicitly, and its equation is the law") {
  const auto with = [](const std::string& law) {
    return Stages(sketch("Se:s=2", "s>r", R"("r": { "kind": "R", "law": ")" + law + "\" }"));
  };
  CHECK(solved(with("e = 4*f^3"), "r") == "f = cbrt(r.e/4)");
  CHECK(solved(with("f = e^3"), "r") == "f = r.e^3");
  const Stages stages = with("e = f + f^3");
  CHECK(solved(stages, "r") == "f: implicit");
  const EquationSystem system = derive_equations(stages.model, stages.graph, stages.causal);
  CHECK(text_of(system, equation_of(system, "r.f")) == "r.e - (r.f + r.f^3)");
}

TEST_CASE("a flow counted against the half-arrow is negated where the law is written for the bond") {
  const Stages stages(sketch("Se:s=2 0:j", "s>j r>j", R"("r": { "kind": "R", "law": "e = 4*f^3" })"));
  CHECK(solved(stages, "r") == "f = cbrt(r.e/4)");
  const EquationSystem system = derive_equations(stages.model, stages.graph, stages.causal);
  CHECK(text_of(system, equation_of(system, "b2.f")) == "-cbrt(r.e/4)");
}

TEST_CASE("the pools of all stages share their measured data") {
  const Study study(BGSIM_SOURCE_DIR "/tests/errors/BG608_outside_the_data.json");
  const Simulation scene = study.scene();
  const auto& data = study.model().pool.tables();
  REQUIRE(data.size() == 1);
  const std::map<std::string, const ExprPool*> pools{{"causality", &study.causality().pool},
                                                     {"equations", &study.equations().pool},
                                                     {"order", &study.order().pool},
                                                     {"program", &scene.program().pool}};
  for (const auto& [stage, pool] : pools) {
    INFO(stage);
    REQUIRE(pool->tables().size() == 1);
    CHECK(pool->tables().front() == data.front());
  }
  const Model again = study.model();
  CHECK(again.pool.tables().front() == data.front());
}

TEST_CASE("the derivative of an energy is the same in the program and in what is printed") {
  const Study study(BGSIM_SOURCE_DIR "/models/bellow.json");
  const EquationSystem& system = study.equations();
  const ExprId pressure = equation_of(system, "packet.field.air.e");
  CHECK(text_of(system, pressure) == "(packet.field.air.q - packet.field.wall.q*packet.A)/packet.C2");
  CHECK(operators(system.pool, pressure) == 3);
  const std::string printed = equations_text(study.model(), system, study.order());
  CHECK(printed.find("P2    = (packet.field.air.q - packet.A*packet.field.wall.q)/packet.C2\n") != std::string::npos);
  // The force at the wall holds the same quotient: it is computed once for both.
  const ExprId force = equation_of(system, "packet.field.wall.e");
  const std::vector<ExprId> parts = reachable(system.pool, std::array{force});
  CHECK(std::find(parts.begin(), parts.end(), pressure) != parts.end());
}
