#include <algorithm>
#include <catch2/catch.hpp>

#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

// --- the stroke of every kind (docs/notation.md) ---

TEST_CASE("The table of strokes: each kind has its stroke where its causality puts it") {
  struct Row {
    const char *elements, *bonds, *bond, *stroke_at;
  };
  const Row row = GENERATE(
      // sources: effort acts on the other end of an Se, on an Sf itself; the half-arrow does not matter
      Row{"Se:s R:r", "s>r", "b1", "r"}, Row{"Se:s R:r", "r>s", "b1", "r"}, Row{"Sf:s R:r", "s>r", "b1", "s"},
      Row{"Sf:s R:r", "r>s", "b1", "s"},
      // integral causality: a C gives its effort, an I takes effort
      Row{"C:c R:r", "r>c", "b1", "r"}, Row{"C:c R:r", "c>r", "b1", "r"}, Row{"I:i R:r", "r>i", "b1", "i"},
      Row{"I:i R:r", "i>r", "b1", "i"}, Row{"C:c I:i", "c>i", "b1", "i"},
      // junctions: one stroke at a 0, one bond without a stroke at a 1
      Row{"Se:s 0:j R:r", "s>j j>r", "b2", "r"}, Row{"Sf:s 1:j R:r", "s>j j>r", "b2", "j"},
      Row{"Sf:s 0:j R:r", "s>j j>r", "b2", "j"}, Row{"Se:s 1:j R:r", "s>j j>r", "b2", "r"},
      // TF: one of its two bonds has the stroke at it; GY: both or none
      Row{"Se:s TF:tf R:r", "s>tf tf>r", "b2", "r"}, Row{"Sf:s TF:tf R:r", "s>tf tf>r", "b2", "tf"},
      Row{"Se:s GY:g R:r", "s>g g>r", "b2", "g"}, Row{"Sf:s GY:g R:r", "s>g g>r", "b2", "r"});
  INFO(row.elements << " with " << row.bonds);
  CHECK(Stages(sketch(row.elements, row.bonds)).stroke_at(row.bond) == row.stroke_at);
}

TEST_CASE("A field's ports have integral causality each for itself") {
  const Stages stages(sketch("Se:s 1:x R:q 0:y R:r", "s>x x>cc.a x>q y>cc.b y>r",
                             R"("cc": {"kind": "CC", "ports": ["a", "b"], "energy": "a.q^2 + a.q*b.q + b.q^2"})"));
  CHECK(stages.states() == "cc.a cc.b");
  CHECK(stages.stroke_at("b2") == "x");
  CHECK(stages.stroke_at("b4") == "y");
}

// --- worked graphs ---

TEST_CASE("The bellow has three states and no choice left") {
  const Stages stages(sketch("Se:pump 1:inlet 1:wall R:damping I:mass",
                             "pump>inlet inlet>orifice inlet>packet.air wall>packet.wall wall>damping wall>mass",
                             R"json("orifice": {"kind": "R", "law": "f = 0.8*ssqrt(e, 1e-3)"},
             "packet": {"kind": "CC", "ports": ["air", "wall"], "energy": "(air.q - wall.q)^2/2 + wall.q^2"})json"));
  CHECK(stages.states() == "mass packet.air packet.wall");
  CHECK(stages.dependent().empty());
  CHECK(stages.causal.free_choices.empty());
  CHECK(stages.causal.gives(stages.graph, stages.graph.port(stages.element("orifice"), 0)) == Gives::flow);
}

TEST_CASE("Two inertias on a lever: the second is dependent, because of the first") {
  const Stages stages(sketch("Se:F 1:v1 I:m1 TF:lever 1:v2 I:m2 R:r", "F>v1 v1>m1 v1>lever lever>v2 v2>m2 v2>r"));
  CHECK(stages.states() == "m1");
  REQUIRE(stages.dependent() == "m2");
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("m1")});
  CHECK(stages.causal.free_choices.empty());
}

TEST_CASE("The store with the larger priority gets integral causality first") {
  const std::string more = R"("m2": {"kind": "I", "inertance": 1, "priority": 1})";
  const Stages stages(sketch("Se:F 1:v I:m1", "F>v v>m1 v>m2", more));
  CHECK(stages.states() == "m2");
  CHECK(stages.dependent() == "m1");
}

TEST_CASE("A store tied to a source is dependent because of that source") {
  // BondGraphTools, test_parallel_crv_relations: C directly on Se with R parallel.
  const Stages stages(sketch("Se:s 0:j C:c R:r", "s>j j>c j>r"));
  CHECK(stages.states().empty());
  REQUIRE(stages.dependent() == "c");
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("s")});
}

TEST_CASE("A capacitor is dependent because of all the others that close its mesh") {
  const Stages stages(sketch("0:a 1:m 0:b C:c1 C:c2 C:c3 R:r", "c1>a a>m m>b b>c2 m>c3 a>r"));
  CHECK(stages.states() == "c1 c2");
  REQUIRE(stages.dependent() == "c3");
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("c1"), stages.element("c2")});
}

TEST_CASE("Two resistors in series at one source leave one free choice") {
  const Stages stages(sketch("Se:s 1:j R:r1 R:r2", "s>j j>r1 j>r2"));
  REQUIRE(stages.causal.free_choices.size() == 1);
  CHECK(stages.causal.free_choices[0].element == stages.element("r1"));
  CHECK(stages.stroke_at("b2") == "r1");  // r1 sets the flow of the junction
  CHECK(stages.stroke_at("b3") == "j");
}

TEST_CASE("A free bond between two junctions is chosen before a resistor's, and decides all of theirs") {
  // Lorenz and Wolper's point: choosing r1 first would leave the strokes of r3 and r4 to a second choice.
  const Stages stages(sketch("Se:s 1:x R:r1 R:r2 0:y R:r3 R:r4", "s>x x>r1 x>r2 x>y y>r3 y>r4"));
  REQUIRE(stages.causal.free_choices.size() == 1);
  CHECK(stages.causal.free_choices[0].bond == BondId(3));
  std::vector<std::string> path;
  for (const ElementId id : stages.causal.free_choices[0].path) path.push_back(stages.model.elements[id.index()].name);
  CHECK(path == std::vector<std::string>{"x", "r1", "r2", "y", "r3", "r4"});
}

TEST_CASE("The published algebraic loop has two states and one free choice") {
  // SystemBondGraphs.jl, Example 11: 1(Se, m) - 0(b1) - 1(b2) - 0(k, Sf).
  const Stages stages(
      sketch("Se:F 1:v1 I:m 0:f1 R:d1 1:v2 R:d2 0:f2 C:k Sf:v", "F>v1 v1>m v1>f1 f1>d1 f1>v2 v2>d2 v2>f2 f2>k v>f2"));
  CHECK(stages.states() == "m k");
  CHECK(stages.causal.free_choices.size() == 1);
}

TEST_CASE("A wheatstone bridge of resistors needs choices, and every rule is kept") {
  const Stages stages(sketch("Se:s 0:a 0:b 0:c 1:ab 1:ac 1:bc 1:bg 1:cg R:r1 R:r2 R:r3 R:r4 R:r5",
                             "s>a a>ab ab>b ab>r1 a>ac ac>c ac>r2 b>bc bc>c bc>r5 b>bg bg>r3 c>cg cg>r4"));
  CHECK(broken_rule(stages.model, stages.graph, stages.causal.strokes).empty());
  CHECK_FALSE(stages.causal.free_choices.empty());
}

TEST_CASE("A nonlinear resistor with a choice is used as its law is written") {
  const std::string squared = R"json("d": {"kind": "R", "law": "f = e + e^3"})json";
  const Stages stages(sketch("Se:s 1:j R:r", "s>j j>r j>d", squared));
  CHECK(stages.causal.gives(stages.graph, stages.graph.port(stages.element("d"), 0)) == Gives::flow);
  CHECK(stages.causal.strokes[2].reason == StrokeReason::law_as_written);
}

TEST_CASE("A law for one direction is obeyed before any store's wish") {
  // The diode can give its flow only, so that the inductor in series with it cannot be a state.
  const std::string diode = R"json("d": {"kind": "R", "law": "f = max(e, 0)"})json";
  const Stages stages(sketch("Se:s 1:j I:i", "s>j j>i j>d", diode));
  CHECK(stages.states().empty());
  REQUIRE(stages.dependent() == "i");
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("d")});
}

TEST_CASE("An R-field has the causality that its laws fix") {
  const std::string rr =
      R"json("rr": {"kind": "RR", "ports": ["a", "b"], "laws": ["a.e = sign(a.f)", "b.f = max(b.e, a.f)"]})json";
  const Stages stages(sketch("C:c 1:x R:r I:i 0:y R:u", "c>x x>r x>rr.a i>y y>rr.b y>u", rr));
  const ElementId field = stages.element("rr");
  CHECK(stages.causal.gives(stages.graph, stages.graph.port(field, 0)) == Gives::effort);
  CHECK(stages.causal.gives(stages.graph, stages.graph.port(field, 1)) == Gives::flow);
}

TEST_CASE("A junction with one bond has zero flow or zero effort, and forces its stroke") {
  CHECK(Stages(sketch("0:j C:c", "j>c")).stroke_at("b1") == "j");
  CHECK(Stages(sketch("1:j I:i", "j>i")).stroke_at("b1") == "i");
  // Here the junction says that the effort (the flow) is zero, so q (p) is no state.
  CHECK(Stages(sketch("1:j C:c", "j>c")).dependent() == "c");
  CHECK(Stages(sketch("0:j I:i", "j>i")).dependent() == "i");
}

TEST_CASE("Elements bonded to each other without a junction are legal") {
  CHECK(Stages(sketch("Se:s C:c", "s>c")).dependent() == "c");
  CHECK(Stages(sketch("Sf:s C:c", "s>c")).states() == "c");
  CHECK(Stages(sketch("C:c I:i", "c>i")).states() == "c i");
  CHECK(Stages(sketch("C:c C:d", "c>d")).dependent() == "d");
  CHECK(Stages(sketch("Se:s Sf:u", "s>u")).stroke_at("b1") == "u");
  CHECK(Stages(sketch("R:r R:s", "r>s")).causal.free_choices.size() == 1);
}

TEST_CASE("Where a ring determines more than strokes show, the rank chooses the states") {
  // Two bonds side by side carry the same flow back and forth: none is left for i2. i3 and i4 share one.
  const Stages stages(sketch("0:x 1:y I:i2 I:i3 I:i4", "y>x x>y x>i2 i3>y i4>y"));
  CHECK(stages.states() == "i3");
  REQUIRE(stages.dependent() == "i2 i4");
  CHECK(stages.causal.dependent[0].because.empty());
  CHECK(stages.causal.dependent[1].because == std::vector<ElementId>{stages.element("i3")});
  REQUIRE(stages.causal.ranked.size() == 1);
  CHECK(stages.causal.ranked[0].inner.size() == 2);
  CHECK(stages.causal.ranked[0].outer.size() == 3);
}

TEST_CASE("A choice that leads to a conflict is taken back, and the store says so") {
  // The way through tf beside the bond y>x forces equal strokes on the stores at both ends. Integral causality of i3
  // agrees with the rules next to it, and is found impossible only further on.
  const Stages stages(sketch("0:x 1:y TF:tf=2 I:i2 I:i3 I:i4", "y>x x>tf tf>y x>i2 i3>y i4>y"));
  CHECK(broken_rule(stages.model, stages.graph, stages.causal.strokes).empty());
  CHECK(stages.states() == "i2");
  REQUIRE(stages.dependent() == "i3 i4");
  CHECK(stages.causal.strokes[4].reason == StrokeReason::by_elimination);
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("i2")});
}

TEST_CASE("What is taken back is what the conflict follows from, not what was chosen elsewhere in between") {
  // The same ring with twenty stores in other parts, chosen between i2 and i3.
  std::string elements = "0:x 1:y TF:tf=2 I:i2", bonds = "y>x x>tf tf>y x>i2 i3>y i4>y";
  for (int i = 0; i < 20; ++i) {
    const std::string n = std::to_string(i);
    elements += " C:c" + n + " R:r" + n;
    bonds += " c" + n + ">r" + n;
  }
  const Stages stages(sketch(elements + " I:i3 I:i4", bonds));
  CHECK(stages.dependent() == "i3 i4");
  CHECK(stages.causal.dependent[0].because == std::vector<ElementId>{stages.element("i2")});
}

TEST_CASE("A chain of reasons starts at a root and ends at the stroke it explains") {
  const Stages stages(sketch("Se:s 0:a TF:tf 0:b GY:g R:r", "s>a a>tf tf>b b>g g>r"));
  const std::vector<BondId> chain = reason_chain(stages.graph, stages.causal, BondId(4));
  CHECK(chain == std::vector<BondId>{BondId(0), BondId(1), BondId(2), BondId(3), BondId(4)});
  CHECK(stages.causal.strokes[0].reason == StrokeReason::source);
  for (std::size_t i = 1; i < chain.size(); ++i) {
    CHECK(stages.causal.strokes[chain[i].index()].reason == StrokeReason::propagated);
    CHECK(stages.causal.strokes[chain[i].index()].cause == chain[i - 1]);
  }
}

// --- properties over many graphs ---

namespace {

/// Every way to give the strokes of a small graph: whether one keeps all rules.
bool some_assignment_exists(const Model& model, const BondGraph& graph) {
  std::vector<Stroke> strokes(graph.bonds.size());
  for (std::uint32_t bits = 0; bits < (1U << graph.bonds.size()); ++bits) {
    for (std::size_t i = 0; i < strokes.size(); ++i)
      strokes[i].end = ((bits >> i) & 1U) != 0 ? BondEnd::head : BondEnd::tail;
    if (broken_rule(model, graph, strokes).empty()) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("Over thousands of random graphs every rule is kept, and causes come before what they force") {
  RandomGraphOptions options;
  options.most_junctions = 12;
  options.most_rings = 4;
  options.sources = 0.08;
  const std::uint64_t rounds = share_of(3000);
  std::size_t accepted = 0, by_rules = 0;
  for (std::uint64_t seed = 1; seed <= rounds; ++seed) {
    const Model model = read_model_text("random.json", random_graph(seed, options).json());
    const BondGraph graph = [&] {
      try {
        return build_bond_graph(model);
      } catch (const ModelError&) {
        return BondGraph{};  // a junction was left without bonds
      }
    }();
    if (graph.bonds.empty()) continue;
    CausalGraph causal;
    try {
      causal = assign_causality(model, graph);
    } catch (const ModelError&) {
      continue;  // sources in conflict; the next test says that there was no way
    }
    ++accepted;
    INFO("seed " << seed);
    if (!causal.ranked.empty()) continue;  // no strokes are right there
    ++by_rules;
    REQUIRE(broken_rule(model, graph, causal.strokes) == "");
    for (std::size_t i = 0; i < causal.strokes.size(); ++i)
      for (const BondId bond : reason_chain(graph, causal, BondId(i)))
        REQUIRE(causal.strokes[bond.index()].order <= causal.strokes[i].order);
    std::size_t stores = 0;
    for (const Port& port : graph.ports) stores += is_store(graph.kinds[port.element.index()]) ? 1U : 0U;
    REQUIRE(causal.integral.size() + causal.dependent.size() == stores);
  }
  CHECK(accepted > rounds / 2);
  CHECK(by_rules > rounds / 2);
}

TEST_CASE("A graph is refused only if no strokes keep all rules") {
  RandomGraphOptions options;
  options.most_junctions = 4;
  options.most_at_junction = 2;
  options.most_rings = 2;
  options.sources = 0.5;
  const std::uint64_t rounds = share_of(1500);
  std::size_t refused = 0, accepted = 0;
  for (std::uint64_t seed = 1; seed <= rounds; ++seed) {
    const RandomGraph random = random_graph(seed, options);
    if (random.bonds.empty() || random.bonds.size() > 9) continue;
    const Model model = read_model_text("random.json", random.json());
    const BondGraph graph = build_bond_graph(model);
    INFO("seed " << seed << "\n" << random.json());
    try {
      assign_causality(model, graph);
      ++accepted;
    } catch (const ModelError& error) {
      ++refused;
      REQUIRE_FALSE(error.diagnostics.empty());
      // Strokes may exist where the ring determines what a source gives: tests/physics/oracle_test.cpp
      if (error.diagnostics.front().code != "BG411") REQUIRE_FALSE(some_assignment_exists(model, graph));
    }
  }
  CHECK(refused > rounds / 15);
  CHECK(accepted > rounds / 15);
}

TEST_CASE("Permuting elements and bonds changes neither the numbers of states and choices nor a forced stroke") {
  RandomGraphOptions options;
  options.most_junctions = 8;
  options.sources = 0.1;
  options.most_rings = 0;  // in a tree of junctions what a choice forces does not depend on the order of choices
  const std::uint64_t rounds = share_of(400);
  std::size_t compared = 0;
  for (std::uint64_t seed = 1; seed <= rounds; ++seed) {
    const RandomGraph random = random_graph(seed, options);
    if (!problems_of(random.json()).empty()) {
      CHECK_FALSE(problems_of(shuffled(random, seed).json()).empty());
      continue;
    }
    const Stages one(random.json()), two(shuffled(random, seed).json());
    INFO("seed " << seed);
    REQUIRE(one.causal.integral.size() == two.causal.integral.size());
    REQUIRE(one.causal.dependent.size() == two.causal.dependent.size());
    if (one.causal.dependent.empty() && one.causal.free_choices.empty()) {
      ++compared;
      // Nothing was a matter of order: the same elements take effort at the same bonds.
      for (std::size_t i = 0; i < random.bonds.size(); ++i)
        for (std::size_t j = 0; j < random.bonds.size(); ++j) {
          const auto same = [&](const BondEndText& a, const BondEndText& b) {
            return one.model.elements[a.element.index()].name == two.model.elements[b.element.index()].name &&
                   a.port == b.port;
          };
          if (same(one.model.bonds[i].from, two.model.bonds[j].from) &&
              same(one.model.bonds[i].to, two.model.bonds[j].to))
            REQUIRE(one.causal.strokes[i].end == two.causal.strokes[j].end);
        }
    }
  }
  CHECK(compared > rounds / 8);
}

TEST_CASE("A ladder of a hundred thousand elements is assigned without recursion", "[long]") {
  constexpr std::size_t kSections = 30000;  // 120001 elements, 120000 bonds
  std::string elements = "Se:s", bonds = "s>x0";
  for (std::size_t i = 0; i < kSections; ++i) {
    const std::string n = std::to_string(i), next = std::to_string(i + 1);
    elements += " 1:x" + n + " R:r" + n + " 0:y" + n + (i % 2 == 0 ? " R:g" : " C:g") + n;
    bonds += " x" + n + ">r" + n + " x" + n + ">y" + n + " y" + n + ">g" + n;
    if (i + 1 < kSections) bonds += " y" + n + ">x" + next;
  }
  const Stages stages(sketch(elements, bonds));
  CHECK(stages.causal.integral.size() == kSections / 2);
  CHECK(stages.causal.dependent.empty());
  CHECK(stages.causal.free_choices.size() == kSections / 2);
}

TEST_CASE("Thirty thousand dependent stores behind one chain of reasons are explained in linear time", "[long]") {
  constexpr std::size_t kSections = 30000;
  std::string elements = "Se:s 0:x0", bonds = "s>x0 x0>c0", more = " C:c0";
  for (std::size_t i = 1; i < kSections; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    elements += " TF:t" + n + " 0:x" + n + " C:c" + n;
    bonds += " x" + before + ">t" + n + " t" + n + ">x" + n + " x" + n + ">c" + n;
  }
  const Stages stages(sketch(elements + more, bonds));
  REQUIRE(stages.causal.dependent.size() == kSections);
  for (const DependentPort& port : stages.causal.dependent) REQUIRE(port.because.size() == 1);
}
