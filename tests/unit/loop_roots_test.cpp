// What is left of a law with a root where an algebraic loop is solved.
#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "bgsim/bgsim.hpp"

using namespace bgsim;

namespace {

/// What a loop through a resistor of that law and one of 1, behind a source of 2, is to make 0.
std::string loop_of(const std::string& law) {
  const Study study = Study::from_text(
      R"({"bgsim": 1, "name": "loop", "parameters": {"k": 3}, "elements": {"u": {"kind": "Se", "effort": 2}, "j": {"kind": "1"},
          "a": {"kind": "R", "law": "f = )" +
      law + R"("}, "b": {"kind": "R", "resistance": 1}},
          "bonds": [{"from": "u", "to": "j"}, {"from": "j", "to": "a"}, {"from": "j", "to": "b"}], "outputs": {"f": "a.f"},
          "scenes": {"s": {"stop": 1}}})");
  const std::string text = equations_text(study.model(), study.equations(), study.order());
  const auto begin = text.find("  0 = ");
  if (begin == std::string::npos) return text;
  return text.substr(begin + 6, text.find("\n\n", begin) - begin - 6);
}

}  // namespace

TEST_CASE("a root in a loop is an unknown, and the law is the same however it is written") {
  const std::string root = loop_of("2*sign(e)*sqrt(abs(e)) + e");
  CHECK(root == "2 - 2*a.e.root*abs(a.e.root) - 2*a.e.root");
  for (const char* law : {"if(e > 0, 2*sqrt(e) + e, e - 2*sqrt(-e))", "if(e <= 0, -2*sqrt(-e), 2*sqrt(e)) + e",
                          "sign(e)*(2*sqrt(abs(e)) + abs(e))", "2*sqrt(max(e, 0)) - 2*sqrt(max(-e, 0)) + e",
                          "if(0 < e, 1, -1)*2*abs(e)^0.5 + e", "2*sign(3*e)*sqrt(abs(e)) + e",
                          "2*sqrt(max(0, e)) - 2*sqrt(-min(e, 0)) + e"})
    CHECK(loop_of(law) == root);
}

TEST_CASE("a root in a loop keeps what its law is on each side") {
  const std::pair<const char*, const char*> cases[] = {
      {"k*sign(e)*sqrt(abs(e)) + e", "2 - 2*a.e.root*abs(a.e.root) - k*a.e.root"},  // a parameter
      {"2*cbrt(e) + e", "2 - 2*a.e.root^3 - 2*a.e.root"},                           // another power
      {"sqrt(max(e, 0)) + cbrt(e) + e",
       "2 - if(a.e.root >= 0, a.e.root + a.e.root^3 + a.e.root*abs(a.e.root)^0.5, a.e.root + a.e.root^3) - "
       "a.e.root^3"},  // two powers: the least
      {"2*sign(e - 1)*sqrt(abs(e - 1)) + e",
       "2*a.f.root + 2*a.e - 2\n  0 = a.e - 1 - a.f.root*abs(a.f.root)"},  // of a difference, which is not an unknown
                                                                           // itself
      {"if(e > 0, 2*sqrt(e), -sqrt(-e))",
       "2 - if(a.e.root >= 0, 2*a.e.root, a.e.root) - a.e.root*abs(a.e.root)"},  // two coefficients
      {"2*sqrt(max(e, 0)) + e",
       "2 - if(a.e.root >= 0, a.e.root*abs(a.e.root) + 2*a.e.root, a.e.root*abs(a.e.root)) - "
       "a.e.root*abs(a.e.root)"},  // one way
      {"2*sqrt(e) + e",
       "2 - if(a.e.root >= 0, a.e.root*abs(a.e.root) + 2*a.e.root, a.e.root*abs(a.e.root) + "
       "2*sqrt(a.e.root*abs(a.e.root))) - a.e.root*abs(a.e.root)"},  // without a value below 0
      {"if(e > 0, 1 + sqrt(e), -1 - sqrt(-e))",
       "a.e + if(a.e > 0, sqrt(a.e) + 1, -(sqrt(-a.e) + 1)) - 2"},  // a jump: as it is
      {"2*sign(e)*sqrt(abs(e)) + sign(e)^2 - 1",
       "a.e + sign(a.e)^2 + 2*sign(a.e)*sqrt(abs(a.e)) - 3"},        // another one at 0: as it is
      {"e*abs(e)^0.5 + e", "a.e*abs(a.e)^0.5 + 2*a.e - 2"},          // no root: its slope has a bound
      {"2*sqrt(1 + e^2) - 2 + e", "2*sqrt(a.e^2 + 1) + 2*a.e - 4"},  // nor this
  };
  for (const auto& [law, loop] : cases) {
    INFO(law);
    CHECK(loop_of(law) == loop);
  }
}
