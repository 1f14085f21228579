#include <algorithm>
#include <catch2/catch.hpp>

#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string description_of(const std::string& json) {
  const Stages stages(json);
  return describe_causality(stages.model, stages.graph, stages.causal);
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("The description of a lever with two masses reads as a person would tell it") {
  CHECK(description_of(sketch("Se:F 1:v I:m TF:lever 1:w I:n R:r", "F>v v>m v>lever lever>w w>n r>w")) ==
        R"(model "sketch": 5 elements and 2 junctions, 6 bonds
1 state, 1 dependent store, no free choices of a stroke

the bar | is where effort acts on the element, > is the half-arrow
strokes fixed by sources
  b1: F --->| v  "F" is an effort source
strokes chosen: stores in integral causality
  b2: v --->| m  "m" is in integral causality
strokes that follow
  b3: v |---> lever.1  1-junction "v" has its flow from b2
  b4: lever.2 |---> w  TF "lever" turns the flow of b3 into the flow of b4
  b5: w |---> n        1-junction "w" has its flow from b4
  b6: r --->| w        1-junction "w" has its flow from b4

states
  m.p  I
dependent stores (derivative causality): no states of their own
  n.p  is determined by "m"

half-arrows that leave a passive element
  b6 leaves r  r.f is counted into the element: r.f = -b6.f
)");
}

TEST_CASE("A free choice is described by the elements whose strokes it decides") {
  CHECK(says(description_of(sketch("Se:s 1:j R:r1 R:r2", "s>j j>r1 j>r2")),
             "algebraic loops run through the bonds whose strokes were free\n"
             "  b2  decides the strokes at \"j\", \"r1\" and \"r2\"\n"));
}

TEST_CASE("Inverted laws are reported, those used as written are not") {
  const std::string law = R"json("d": {"kind": "R", "law": "f = e + e^3"})json";
  CHECK(says(description_of(sketch("I:i", "i>d", law)), "d  solved numerically during the run, to give its effort\n"));
  CHECK_FALSE(says(description_of(sketch("C:c", "c>d", law)), "laws not used as written"));
}

TEST_CASE("Fields are described with their reciprocity") {
  const auto field = [](const std::string& how) {
    return description_of(sketch("R:r R:s", "r>x.a s>x.b", R"("x": {"kind": "CC", "ports": ["a", "b"], )" + how + "}"));
  };
  CHECK(says(field(R"("energy": "a.q^2 + b.q^2")"), "x  reciprocal by construction"));
  CHECK(says(field(R"("laws": ["a.e = a.q + b.q", "b.e = b.q + a.q"])"),
             "x  reciprocal: its cross derivatives are equal"));
  CHECK(says(field(R"("laws": ["a.e = a.q + b.q", "b.e = b.q"])"),
             "x  NOT reciprocal: d x.a.e / d x.b.q = 1, but d x.b.e / d x.a.q = 0\n"));
}

TEST_CASE("Parts that no bond connects are listed") {
  CHECK(says(description_of(sketch("Se:s R:r Sf:u C:c", "s>r u>c")),
             "the graph falls into 2 parts that no bond connects\n  s and r\n  u and c\n"));
}

TEST_CASE("The description of a large model is cut with counts, and showing it is not") {
  std::string elements = "Se:s 0:x", bonds = "s>x";
  for (int i = 0; i < 500; ++i) {
    elements += " R:r" + std::to_string(i);
    bonds += " x>r" + std::to_string(i);
  }
  const Stages stages(sketch(elements, bonds));
  const std::string described = describe_causality(stages.model, stages.graph, stages.causal);
  CHECK(says(described, "  ... and 440 more\n"));
  CHECK(std::count(described.begin(), described.end(), '\n') < 100);
  const std::string shown = show_causality(stages.model, stages.graph, stages.causal);
  CHECK(std::count(shown.begin(), shown.end(), '\n') == 501);
}

TEST_CASE("What is shown of the first stages is one line for each item") {
  const Stages stages(sketch("Se:s=2 1:j C:c=3 TF:n=4 R:r", "s>j j>c j>n n>r"));
  CHECK(show_graph(stages.model, stages.graph) ==
        "element s: Se, ports -> b1\n"
        "element j: 1, ports <- b1, -> b2, -> b3\n"
        "element c: C, ports <- b2\n"
        "element n: TF, ports 1 <- b3, 2 -> b4\n"
        "element r: R, ports <- b4\n"
        "bond b1: s -> j\n"
        "bond b2: j -> c\n"
        "bond b3: j -> n.1\n"
        "bond b4: n.2 -> r\n");
  CHECK(show_causality(stages.model, stages.graph, stages.causal) ==
        "stroke b1: s --->| j, place 1, source s\n"
        "stroke b2: j |---> c, place 2, integral c\n"
        "stroke b3: j --->| n.1, place 3, propagated j\n"
        "stroke b4: n.2 --->| r, place 4, propagated n, from b3\n"
        "integral c\n");
  CHECK(says(show_model(stages.model), "element c: C, capacitance 3\n"));
  CHECK(says(show_model(stages.model), "bond b3: j -> n\n"));
}
