#include "model/constitutive.hpp"

#include <catch2/catch.hpp>

#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Laws {
  explicit Laws(const std::string& elements, const std::string& members = {})
      : model(read_model_text("sketch.json", sketch(elements, "", members))), pool(model.pool) {}

  LawUse use(Gives gives, std::size_t port = 0, std::size_t element = 0) const {
    return law_use(model, ElementId(element), port, gives);
  }
  std::string law(std::size_t port = 0, std::size_t element = 0) {
    const Law law = port_laws(model, pool, ElementId(element))[port];
    const auto name = [&](SymbolId symbol) { return symbol_name(model, symbol); };
    return name(port_variable(model.elements[element], law.port, law.variable)) + " = " +
           to_text(pool, law.right, name);
  }

  Model model;
  ExprPool pool;
};

constexpr Gives kEffort = Gives::effort;
constexpr Gives kFlow = Gives::flow;

std::string one_port(const std::string& kind, const std::string& law) {
  return R"("x": {"kind": ")" + kind + R"(", "law": ")" + law + "\"}";
}

}  // namespace

TEST_CASE("Linear keys are written out as laws") {
  CHECK(Laws("R:x=5").law() == "x.e = 5*x.f");
  CHECK(Laws("C:x=5").law() == "x.e = x.q/5");
  CHECK(Laws("I:x=5").law() == "x.f = x.p/5");
  CHECK(Laws("Se:x=5").law() == "x.e = 5");
  CHECK(Laws("Sf:x=5").law() == "x.f = 5");
}

TEST_CASE("Linear R, C and I are usable both ways, sources in their own only") {
  struct Row {
    const char* kind;
    LawUse effort, flow;
  };
  const Row row =
      GENERATE(Row{"R:x", LawUse::as_written, LawUse::inverted}, Row{"C:x", LawUse::as_written, LawUse::inverted},
               Row{"I:x", LawUse::inverted, LawUse::as_written}, Row{"Se:x", LawUse::as_written, LawUse::impossible},
               Row{"Sf:x", LawUse::impossible, LawUse::as_written});
  INFO(row.kind);
  CHECK(Laws(row.kind).use(kEffort) == row.effort);
  CHECK(Laws(row.kind).use(kFlow) == row.flow);
}

TEST_CASE("A resistance that is the number 0 gives its effort only") {
  CHECK(Laws("R:x=0").use(kEffort) == LawUse::as_written);
  CHECK(Laws("R:x=0").use(kFlow) == LawUse::impossible);
}

TEST_CASE("A nonlinear law serves as written, inverted, implicitly or not at all") {
  struct Row {
    const char *kind, *law;
    LawUse effort, flow;
  };
  const Row row = GENERATE(
      // closed-form inverses
      Row{"R", "e = 2*f + 1", LawUse::as_written, LawUse::inverted},
      Row{"R", "e = f^3", LawUse::as_written, LawUse::inverted},
      Row{"R", "f = exp(e) - 1", LawUse::inverted, LawUse::as_written},
      Row{"R", "e = f*abs(f)", LawUse::as_written, LawUse::inverted},
      Row{"R", "f = sign(e)*abs(e)^0.6", LawUse::inverted, LawUse::as_written},
      // smooth, without a closed form
      Row{"R", "e = f + f^3", LawUse::as_written, LawUse::implicit},
      Row{"R", "f = e*exp(e)", LawUse::implicit, LawUse::as_written},
      // jumps and kinks
      Row{"R", "e = sign(f)", LawUse::as_written, LawUse::impossible},
      Row{"R", "f = max(e, 0)", LawUse::impossible, LawUse::as_written},
      Row{"R", "f = if(e > 0, e, e/1000)", LawUse::impossible, LawUse::as_written},
      Row{"R", "e = floor(f)", LawUse::as_written, LawUse::impossible},
      // a kink in another variable is no hindrance
      Row{"R", "e = (2 + sin(t) + abs(sin(t)))*(f + f^3)", LawUse::as_written, LawUse::implicit},
      // the variable does not occur
      Row{"R", "e = 5", LawUse::as_written, LawUse::impossible},
      // stores: effort of a C and flow of an I are integral causality
      Row{"C", "e = q^3", LawUse::as_written, LawUse::inverted},
      Row{"C", "e = q + q^3", LawUse::as_written, LawUse::implicit},
      Row{"C", "q = tanh(e)", LawUse::inverted, LawUse::as_written},
      Row{"C", "e = max(q, 0)", LawUse::as_written, LawUse::impossible},
      Row{"I", "f = p/sqrt(1 + p^2)", LawUse::implicit, LawUse::as_written},
      Row{"I", "p = 2*f", LawUse::as_written, LawUse::inverted});
  INFO(row.kind << ": " << row.law);
  const Laws laws("", one_port(row.kind, row.law));
  CHECK(laws.use(kEffort) == row.effort);
  CHECK(laws.use(kFlow) == row.flow);
}

TEST_CASE("The regularised orifice gives its flow as written and its effort some way") {
  const Laws laws("", one_port("R", "f = 0.8*ssqrt(e, 1e-3)"));
  CHECK(laws.use(kFlow) == LawUse::as_written);
  CHECK(laws.use(kEffort) != LawUse::impossible);
}

TEST_CASE("A modulated resistance that depends on its own flow is a law of its own") {
  const Laws laws("", R"("x": {"kind": "MR", "resistance": "1 + x.f^2"})");
  CHECK(laws.use(kEffort) == LawUse::as_written);
  CHECK(laws.use(kFlow) == LawUse::implicit);
}

TEST_CASE("A field's laws are the derivatives of its energy") {
  // The moving-plate capacitor (BondGraphTools, test_create_PH_2): e0 = q0/(C + q1), e1 = -q0^2/(2 (C + q1)^2).
  Laws laws("", R"json("x": {"kind": "CC", "ports": ["a", "b"], "energy": "a.q^2/(2*3 + 2*b.q)"})json");
  const Model& model = laws.model;
  std::vector<double> values(model.symbols.size());
  const double q0 = 0.7, q1 = 0.4;
  values[port_variable(model.elements[0], 0, Variable::displacement).index()] = q0;
  values[port_variable(model.elements[0], 1, Variable::displacement).index()] = q1;
  const auto port = port_laws(model, laws.pool, ElementId(0));
  // Rounding only: a handful of operations.
  CHECK(evaluate(laws.pool, port[0].right, values) == Approx(q0 / (3 + q1)).epsilon(1e-14));
  CHECK(evaluate(laws.pool, port[1].right, values) == Approx(-q0 * q0 / (2 * (3 + q1) * (3 + q1))).epsilon(1e-14));
}

TEST_CASE("A field whose law does not contain the port's own displacement cannot be turned round there") {
  const Laws laws("", R"("x": {"kind": "CC", "ports": ["a", "b"], "energy": "a.q*b.q + b.q^2"})");
  CHECK(laws.use(kEffort, 0) == LawUse::as_written);
  CHECK(laws.use(kFlow, 0) == LawUse::impossible);
  CHECK(laws.use(kFlow, 1) == LawUse::inverted);
}

TEST_CASE("Laws of a field stand at their ports' positions, in whatever order they are written") {
  Laws laws("", R"("x": {"kind": "RR", "ports": ["a", "b"], "laws": ["b.f = b.e", "a.e = 2*a.f"]})");
  CHECK(laws.law(0) == "x.a.e = 2*x.a.f");
  CHECK(laws.law(1) == "x.b.f = x.b.e");
}

namespace {

Reciprocity reciprocity_of(const std::string& laws, const std::string& kind = "CC") {
  const std::string json =
      sketch("", "", R"("x": {"kind": ")" + kind + R"(", "ports": ["air", "wall"], "laws": )" + laws + "}");
  return test_reciprocity(read_model_text("sketch.json", json), ElementId(0));
}

}  // namespace

TEST_CASE("Reciprocity of a linear field is recognised") {
  using Verdict = Reciprocity::Verdict;
  CHECK(reciprocity_of(R"(["air.e = 2*air.q + 3*wall.q", "wall.e = 3*air.q + 5*wall.q"])").verdict == Verdict::proved);
  const Reciprocity violated = reciprocity_of(R"(["air.e = 2*air.q + 3*wall.q", "wall.e = 4*air.q + 5*wall.q"])");
  CHECK(violated.verdict == Verdict::violated);
  CHECK(violated.text == "d x.air.e / d x.wall.q = 3, but d x.wall.e / d x.air.q = 4");
  CHECK(reciprocity_of(R"(["air.f = 3*wall.p", "wall.f = 3*air.p"])", "II").verdict == Verdict::proved);
}

TEST_CASE("A law that uses another port's effort is tested with that effort replaced") {
  // The bellow's laws with a constant C2: from one energy.
  const Reciprocity linear = reciprocity_of(R"(["air.e = (air.q - 2*wall.q)/7", "wall.e = 350*wall.q - 2*air.e"])");
  CHECK((linear.verdict == Reciprocity::Verdict::proved || linear.verdict == Reciprocity::Verdict::sampled));
  // With C2 = A x/(rho R T) put into the same two laws the derivative of C2 is missing from the wall's.
  const Reciprocity naive =
      reciprocity_of(R"json(["air.e = (air.q - 2*wall.q)/(2*wall.q/3)", "wall.e = 350*wall.q - 2*air.e"])json");
  CHECK(naive.verdict == Reciprocity::Verdict::violated);
}

TEST_CASE("Laws solved for displacements obey the reciprocity of the Legendre transform") {
  // E = q1^2 + q1 q2 + q2^2: e1 = 2 q1 + q2, and e2 = q1 + 2 q2 solved for q2.
  using Verdict = Reciprocity::Verdict;
  CHECK(reciprocity_of(R"(["air.e = 1.5*air.q + 0.5*wall.e", "wall.q = 0.5*wall.e - 0.5*air.q"])").verdict ==
        Verdict::proved);
  CHECK(reciprocity_of(R"(["air.e = 1.5*air.q + 0.5*wall.e", "wall.q = 0.5*wall.e + 0.5*air.q"])").verdict ==
        Verdict::violated);
}

TEST_CASE("Laws that use each other in a circle are left untested and say so") {
  const Reciprocity circle = reciprocity_of(R"(["air.e = air.q + 0.5*wall.e", "wall.e = wall.q + 0.5*air.e"])");
  CHECK(circle.verdict == Reciprocity::Verdict::untested);
  CHECK_FALSE(circle.text.empty());
}

TEST_CASE("A field that is not reciprocal gets a warning") {
  const Stages stages(sketch("0:u 0:w R:r R:s", "u>x.a w>x.b u>r w>s",
                             R"("x": {"kind": "CC", "ports": ["a", "b"], "laws": ["a.e = a.q + b.q", "b.e = b.q"]})"));
  REQUIRE(stages.causal.warnings.size() == 1);
  CHECK(stages.causal.warnings[0].code == "BG306");
  CHECK(stages.causal.warnings[0].severity == Severity::warning);
}
