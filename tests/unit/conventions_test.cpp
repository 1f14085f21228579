// docs/notation.md, held against runs: signs into the element, half-arrows turned round, moduli.

#include <catch2/catch.hpp>

#include "support/approx.hpp"
#include "support/run.hpp"
#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// The value of an output at the end of a short run of a sketch.
double value_of(const std::string& elements, const std::string& bonds, const std::string& output) {
  std::string json = sketch(elements, bonds);
  json.erase(json.rfind('}'));
  json += R"(, "outputs": {"y": ")" + output + R"("}, "scenes": {"run": {"stop": 0.5, "samples": 2}}})";
  const RunResult result = run_text(json);
  REQUIRE(result.stop == StopReason::completed);
  return result.trace["y"].back();
}

}  // namespace

TEST_CASE("A resistor's variables are counted into it, whichever way the half-arrow points") {
  // One of them sits between source and ground: 6 = 2*3.
  CHECK(value_of("Se:s=6 R:r=2", "s>r", "r.f") == same_to_rounding(3));
  CHECK(value_of("Sf:s=3 R:r=2", "s>r", "r.e") == same_to_rounding(6));
  // The half-arrow leaves the resistor and enters the source: power still goes into the resistor.
  CHECK(value_of("Se:s=6 R:r=2", "r>s", "r.e*r.f") == same_to_rounding(18));
  CHECK(value_of("Se:s=6 R:r=2", "r>s", "b1.f") == same_to_rounding(-3));
  CHECK(value_of("Se:s=6 R:r=2", "r>s", "r.f") == same_to_rounding(3));
}

TEST_CASE("Sources count along the half-arrow of their bond") {
  CHECK(value_of("Sf:s=3 C:c", "s>c", "c.q") == same_to_rounding(1.5));
  CHECK(value_of("Sf:s=3 C:c", "c>s", "c.q") == same_to_rounding(-1.5));
  CHECK(value_of("Se:s=3 I:i", "s>i", "i.p") == same_to_rounding(1.5));
  CHECK(value_of("Se:s=3 I:i", "i>s", "i.p") == same_to_rounding(1.5));
}

TEST_CASE("What enters a junction leaves it") {
  CHECK(value_of("Sf:a=5 Sf:b=2 0:j R:r", "a>j j>b j>r", "r.f") == same_to_rounding(3));
  CHECK(value_of("Se:a=5 Se:b=2 1:j R:r", "a>j j>b j>r", "r.e") == same_to_rounding(3));
  CHECK(value_of("Se:a=5 Se:b=2 1:j R:r", "a>j b>j j>r", "r.e") == same_to_rounding(7));
}

TEST_CASE("A TF of modulus n has e1 = n e2 and f2 = n f1") {
  CHECK(value_of("Se:s=6 TF:n=2 R:r", "s>n n>r", "r.e") == same_to_rounding(3));
  CHECK(value_of("Sf:s=6 TF:n=2 R:r", "s>n n>r", "r.f") == same_to_rounding(12));
}

TEST_CASE("A GY of modulus r has e1 = r f2 and e2 = r f1") {
  CHECK(value_of("Se:s=6 GY:n=2 R:r", "s>n n>r", "r.f") == same_to_rounding(3));
  CHECK(value_of("Sf:s=6 GY:n=2 R:r", "s>n n>r", "r.e") == same_to_rounding(12));
}

TEST_CASE("TF and GY pass power on, whichever way the half-arrows of their named ports point") {
  const std::string kind = GENERATE("TF", "GY");
  const std::string source = GENERATE("Se", "Sf");
  const std::string first = GENERATE("s>n.1", "n.1>s");
  const std::string second = GENERATE("n.2>r", "r>n.2");
  INFO(kind << " with " << source << ", " << first << " " << second);
  const std::string elements = source + ":s=6 " + kind + ":n=2 R:r=5";
  const std::string bonds = first + " " + second;
  // Supplied along the half-arrow if it leaves the source, against it otherwise.
  const std::string supplied = first == "s>n.1" ? "s.e*s.f" : "0-s.e*s.f";
  CHECK(value_of(elements, bonds, supplied) == same_to_rounding(value_of(elements, bonds, "r.e*r.f")));
  CHECK(value_of(elements, bonds, "r.e*r.f") > 1.0);
}

TEST_CASE("The transformer of Karlinde's test core reads as published") {
  // Se - 1(I) - TF(d) - 1(R) gives p' = F - r d^2 p/i (Karlinde/bondgraph, tests/test_core.py). With F = 1, i = 1, d =
  // 2, r = 3: p(t) = (1 - exp(-12 t))/12.
  CHECK(value_of("Se:F=1 1:v I:i=1 TF:d=2 1:w R:r=3", "F>v v>i v>d d>w w>r", "i.p") ==
        Approx((1 - std::exp(-12 * 0.5)) / 12).epsilon(1e-5));
  // Se - 1(C) - TF(d) - 1(R) gives q' = (F - q/c)/(r d^2): q = c F (1 - exp(-t/(r d^2 c))).
  CHECK(value_of("Se:F=1 1:v C:c=1 TF:d=2 1:w R:r=3", "F>v v>c v>d d>w w>r", "c.q") ==
        Approx(1 - std::exp(-0.5 / 12)).epsilon(1e-5));
}
