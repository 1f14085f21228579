// What derivation writes for each kind of element, equation by equation.
#include <algorithm>
#include <catch2/catch.hpp>

#include "bgsim/bgsim.hpp"
#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Derived : Stages {
  explicit Derived(const std::string& elements, const std::string& bonds, const std::string& more = {})
      : Stages(sketch(elements, bonds, more)), system(derive_equations(model, graph, causal)) {}

  [[nodiscard]] std::string text(ExprId expression) const {
    return to_text(system.pool, expression, [this](SymbolId s) { return system.symbols[s.index()].name; });
  }
  /// The right side of an unknown's equation, or of a state's rate.
  [[nodiscard]] std::string of(const std::string& name) const {
    for (const Equation& equation : system.equations)
      if (system.symbols[equation.unknown.index()].name == name)
        return (equation.implicit ? "0 = " : "") + text(equation.expression);
    for (const State& state : system.states)
      if (state.name == name) return text(state.rate);
    return "no equation";
  }
  [[nodiscard]] const EnergyPart* energy(const std::string& name) const {
    const auto found = std::find_if(system.energy.begin(), system.energy.end(),
                                    [&](const EnergyPart& part) { return part.element == element(name); });
    return found == system.energy.end() ? nullptr : &*found;
  }

  EquationSystem system;
};

}  // namespace

TEST_CASE("a source sets its variable and supplies the power of its bond") {
  const Derived effort("Se:s=2 R:r=5", "s>r");
  CHECK(effort.of("r.e") == "2");
  CHECK(effort.of("r.f") == "r.e/5");
  REQUIRE(effort.energy("s") != nullptr);
  CHECK(effort.energy("s")->role == EnergyPart::Role::source);
  CHECK(effort.text(effort.energy("s")->power) == "r.f*r.e");
  CHECK(effort.energy("r")->role == EnergyPart::Role::dissipator);
  const Derived flow("Sf:s=2 R:r=5", "r>s");
  CHECK(flow.of("s.f") == "2");
  CHECK(flow.of("s.e") == "-5*s.f");
  CHECK(flow.text(flow.energy("s")->power) == "-s.f*s.e");
}

TEST_CASE("a detector keeps the other variable of its bond at zero and has no part in the energy") {
  const Derived effort("Se:s 0:j R:r De:d", "s>j j>r j>d");
  CHECK(effort.of("d.f") == "0");
  CHECK(effort.of("d.e") == "s.e");
  CHECK(effort.energy("d") == nullptr);
  const Derived flow("Se:s 1:j R:r Df:d", "s>j j>r j>d");
  CHECK(flow.of("d.e") == "0");
  CHECK(flow.of("d.f") == "r.f");
}

TEST_CASE("a TF multiplies in one causality and divides in the other") {
  const Derived from_effort("Se:s TF:n=3 R:r", "s>n n>r");
  CHECK(from_effort.of("r.e") == "s.e/3");
  CHECK(from_effort.of("s.f") == "r.f/3");
  const Derived from_flow("Sf:s TF:n=3 R:r", "s>n n>r");
  CHECK(from_flow.of("s.e") == "3*r.e");
  CHECK(from_flow.of("r.f") == "3*s.f");
}

TEST_CASE("a GY relates efforts to the flows of its other port") {
  const Derived from_effort("Se:s GY:g=3 R:r", "s>g g>r");
  CHECK(from_effort.of("r.f") == "s.e/3");
  CHECK(from_effort.of("s.f") == "r.e/3");
  const Derived from_flow("Sf:s GY:g=3 R:r", "s>g g>r");
  CHECK(from_flow.of("s.e") == "3*r.f");
  CHECK(from_flow.of("r.e") == "3*s.f");
}

TEST_CASE("a junction shares what one bond sets and balances the rest there, by half-arrows") {
  const Derived series("Se:s 1:j R:r I:i", "s>j j>r i>j");
  CHECK(series.of("s.f") == "b3.f");
  CHECK(series.of("r.f") == "b3.f");
  CHECK(series.of("i.e") == "r.e - s.e");
  const Derived parallel("Sf:s 0:j R:r C:c", "s>j j>r j>c");
  CHECK(parallel.of("s.e") == "c.e");
  CHECK(parallel.of("r.e") == "c.e");
  CHECK(parallel.of("c.f") == "s.f - r.f");
}

TEST_CASE("a store in integral causality is a state, in derivative causality the derivative of what it holds") {
  const Derived integral("Sf:s=2 C:c=5", "s>c");
  CHECK(integral.of("c.e") == "c.q/5");
  CHECK(integral.of("c.q") == "c.f");
  CHECK(integral.text(integral.energy("c")->energy) == "c.q/10*c.q");
  CHECK(integral.text(integral.energy("c")->conjugates.front()) == "c.q/5");
  const Derived derivative("Se:s=2 C:c=5", "s>c");
  CHECK(derivative.system.states.empty());
  REQUIRE(derivative.system.dependent.size() == 1);
  CHECK(derivative.of("c.q") == "5*c.e");
  CHECK(derivative.of("c.f") == "der(c.q)");
  CHECK(derivative.of("der(c.q)") == "5*der(c.e)");
  CHECK(derivative.of("der(c.e)") == "0");
}

TEST_CASE("the derivative of an implicit law divides by its slope") {
  const Derived d("Se:s=2", "s>c", R"("c": { "kind": "C", "law": "e = q + q^3" })");
  CHECK(d.of("c.q") == "0 = c.e - (c.q + c.q^3)");
  CHECK(d.of("c.f") == "der(c.q)");
  CHECK(d.of("der(c.q)") == "-der(c.e)/(-3*c.q^2 - 1)");
}
