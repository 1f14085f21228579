#include <catch2/catch.hpp>

#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

BondGraph graph_of(const Model& model) { return build_bond_graph(model); }
Model model_of(const std::string& json) { return read_model_text("sketch.json", json); }

const std::string kField = R"("field": {"kind": "CC", "ports": ["a", "b"], "energy": "a.q^2 + a.q*b.q + b.q^2"})";

}  // namespace

TEST_CASE("Every port of a bond graph is at one end of one bond") {
  const Model model = model_of(sketch("Se:s 1:x R:r TF:tf 0:y C:c", "s>x x>r x>tf tf>y y>c"));
  const BondGraph graph = graph_of(model);
  REQUIRE(graph.bonds.size() == 5);
  REQUIRE(graph.ports.size() == 10);
  for (std::size_t i = 0; i < graph.bonds.size(); ++i) {
    CHECK(graph[graph.bonds[i].tail].bond == BondId(i));
    CHECK(graph[graph.bonds[i].head].bond == BondId(i));
    CHECK_FALSE(graph[graph.bonds[i].tail].head);
    CHECK(graph[graph.bonds[i].head].head);
    CHECK(graph.opposite(graph.bonds[i].tail) == graph.bonds[i].head);
    CHECK(graph.opposite(graph.bonds[i].head) == graph.bonds[i].tail);
  }
  for (std::size_t i = 0; i < graph.kinds.size(); ++i)
    for (std::size_t number = 0; number < graph.port_count(ElementId(i)); ++number) {
      CHECK(graph[graph.port(ElementId(i), number)].element == ElementId(i));
      CHECK(graph[graph.port(ElementId(i), number)].number == number);
    }
}

TEST_CASE("Port 1 of a TF takes the bond whose half-arrow enters, port 2 the one that leaves") {
  // The leaving bond is written first.
  const Model model = model_of(sketch("Se:s TF:tf R:r", "tf>r s>tf"));
  const BondGraph graph = graph_of(model);
  CHECK(graph[graph.port(ElementId(1), 0)].bond == BondId(1));
  CHECK(graph[graph.port(ElementId(1), 1)].bond == BondId(0));
}

TEST_CASE("Named ports of a GY hold whatever the half-arrows are") {
  const Model model = model_of(sketch("Se:s GY:g R:r", "r>g.2 s>g.1"));
  const BondGraph graph = graph_of(model);
  CHECK(graph[graph.port(ElementId(1), 0)].bond == BondId(1));
  CHECK(graph[graph.port(ElementId(1), 1)].bond == BondId(0));
  CHECK(graph[graph.port(ElementId(1), 1)].head);
}

TEST_CASE("Several bonds may join the same two junctions") {
  const BondGraph graph = graph_of(model_of(sketch("0:x 1:y R:r", "x>y x>y x>r")));
  CHECK(graph.port_count(ElementId(0)) == 3);
}

TEST_CASE("A bond graph refuses what has no place in it, all problems in one run") {
  CHECK(problems_of(sketch("Se:s R:r C:c", "s>r s>c")) == "BG201");
  CHECK(problems_of(sketch("Se:s 1:x TF:tf R:r", "s>x x>tf x>r")) == "BG202");
  CHECK(problems_of(sketch("Se:s TF:tf R:r", "s>tf r>tf")) == "BG203");
  CHECK(problems_of(sketch("Se:s R:r C:c", "s>r")) == "BG204");
  CHECK(problems_of(sketch("Se:s 1:x R:r", "s>x x>r x>x")) == "BG205");
  CHECK(problems_of(sketch("Se:s R:r 1:x TF:tf 0:y", "s>r x>x tf>y tf>y")) == "BG205 BG203");
}

TEST_CASE("A third bond at a TF is a port bonded twice") {
  CHECK(problems_of(sketch("Se:s TF:tf R:r C:c", "s>tf tf>r tf>c")) == "BG201");
}

TEST_CASE("A port of a field without a bond is named in the message") {
  const std::string message = messages_of(sketch("Se:s", "s>field.a", kField));
  CHECK(message.find("BG202") != std::string::npos);
  CHECK(message.find("\"field.b\"") != std::string::npos);
}

TEST_CASE("Unconnected parts come in the order of their first elements, each in model order") {
  const Model model = model_of(sketch("Se:s Sf:u R:r 0:x C:c R:q", "s>r u>x x>c x>q"));
  const auto parts = connected_parts(graph_of(model));
  REQUIRE(parts.size() == 2);
  CHECK(parts[0] == std::vector<ElementId>{ElementId(0), ElementId(2)});
  CHECK(parts[1] == std::vector<ElementId>{ElementId(1), ElementId(3), ElementId(4), ElementId(5)});
}
