#include <catch2/catch.hpp>

#include "support/sketch.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string first_problem(const std::string& json) {
  try {
    const Stages stages(json);
  } catch (const ModelError& error) {
    std::string text = error.diagnostics.front().code + ": " + error.diagnostics.front().situation;
    for (const Note& note : error.diagnostics.front().notes) text += "\n" + note.text;
    return text;
  }
  return "none";
}

const std::string kDiode = R"json("diode": {"kind": "R", "law": "f = max(e, 0)"})json";

}  // namespace

TEST_CASE("Two effort sources on a 0-junction are named with their bonds") {
  CHECK(first_problem(sketch("Se:battery Se:charger 0:bus R:load", "battery>bus charger>bus bus>load")) ==
        "BG301: two bonds set the effort of 0-junction \"bus\"\n"
        "effort source \"battery\" sets it through bond b1\n"
        "effort source \"charger\" sets it through bond b2");
}

TEST_CASE("Two flow sources on a 1-junction are named with their bonds") {
  CHECK(first_problem(sketch("Sf:pump 1:line R:load Sf:drain", "pump>line line>load line>drain")) ==
        "BG302: two bonds set the flow of 1-junction \"line\"\n"
        "flow source \"pump\" sets it through bond b1\n"
        "flow source \"drain\" sets it through bond b3");
}

TEST_CASE("Sources bonded to each other must not both be of one kind") {
  CHECK(problems_of(sketch("Se:a Se:b", "a>b")) == "BG301");
  CHECK(problems_of(sketch("Sf:a Sf:b", "a>b")) == "BG302");
}

TEST_CASE("A junction whose effort or flow nobody sets is reported with all its bonds") {
  CHECK(first_problem(sketch("Sf:a Sf:b 0:j", "a>j j>b")) ==
        "BG303: no bond sets the effort of 0-junction \"j\"\n"
        "b1: stroke at \"a\", because \"a\" is a flow source\n"
        "b2: stroke at \"b\", because \"b\" is a flow source");
  CHECK(problems_of(sketch("Se:a Se:b 1:j", "a>j j>b")) == "BG303");
}

TEST_CASE("Two effort sources that meet at a TF are reported with the chain from each") {
  CHECK(first_problem(sketch("Se:a 0:x TF:tf 0:y Se:b", "a>x x>tf tf>y y>b")) ==
        "BG304: TF \"tf\" receives the effort of b2 and the effort of b3, but its rule relates the two\n"
        "b1: stroke at \"x\", because \"a\" is an effort source\n"
        "b4: stroke at \"y\", because \"b\" is an effort source\n"
        "b2: stroke at \"tf.1\", because 0-junction \"x\" has its effort from b1\n"
        "b3: stroke at \"tf.2\", because 0-junction \"y\" has its effort from b4");
  CHECK(problems_of(sketch("Se:a TF:tf Se:b", "a>tf tf>b")) == "BG304");
  CHECK(problems_of(sketch("Se:a GY:g Sf:b", "a>g g>b")) == "BG304");
  CHECK(problems_of(sketch("Se:a GY:g Se:b", "a>g g>b")) == "");
}

TEST_CASE("A law that can only give its flow cannot receive its flow") {
  CHECK(first_problem(sketch("Sf:s 1:j R:r", "s>j j>diode j>r", kDiode)) ==
        "BG305: the law of \"diode\" cannot give its effort, which causality requires\n"
        "b1: stroke at \"s\", because \"s\" is a flow source\n"
        "b2: stroke at \"j\", because 1-junction \"j\" has its flow from b1");
}

TEST_CASE("A store whose law has no inverse cannot be dependent") {
  CHECK(problems_of(sketch("Se:s 0:j", "s>j j>c", R"json("c": {"kind": "C", "law": "e = max(q, 0)"})json")) == "BG305");
}

TEST_CASE("Two laws for one direction can contradict each other") {
  CHECK(problems_of(sketch("1:j R:r", "j>a j>b j>r",
                           R"json("a": {"kind": "R", "law": "f = max(e, 0)"},
                                  "b": {"kind": "R", "law": "f = max(e, 1)"})json")) == "BG305");
}

TEST_CASE("Independent conflicts come out in one run, one message each") {
  CHECK(problems_of(sketch("Se:a Se:b Se:c 0:bus R:r Sf:u Sf:v 1:line R:q",
                           "a>bus b>bus c>bus bus>r u>line v>line line>q")) == "BG301 BG302");
}

TEST_CASE("A chain of thousands of strokes is shown by its beginning and its end") {
  constexpr std::size_t kLength = 5000;
  std::string elements = "Se:a Se:b TF:tf", bonds = "a>x0";
  for (std::size_t i = 0; i < kLength; ++i) {
    const std::string n = std::to_string(i), next = std::to_string(i + 1);
    elements += " 0:x" + n + " R:r" + n;
    bonds += " x" + n + ">r" + n + (i + 1 < kLength ? " x" + n + ">x" + next : " x" + n + ">tf tf>b");
  }
  const std::string problem = first_problem(sketch(elements, bonds));
  CHECK(problem.size() < 2000);
  CHECK(problem.find("more strokes") != std::string::npos);
  CHECK(problem.find("\"a\" is an effort source") != std::string::npos);
  CHECK(problem.find("\"b\" is an effort source") != std::string::npos);
}
