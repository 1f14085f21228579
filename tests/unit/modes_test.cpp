// Modes of switches: named, read, derived.
#include <catch2/catch.hpp>

#include "bgsim/bgsim.hpp"

using namespace bgsim;

namespace {

const char* const kModel = R"({"bgsim": 1, "name": "modes", "elements": {
    "v": {"kind": "Se", "effort": 1}, "high": {"kind": "Sw", "closed": "t < 1"},
    "brake": {"kind": "Sw", "locked": "t >= 1"}, "in": {"kind": "1"}, "n": {"kind": "0"},
    "l": {"kind": "I", "inertance": 1}, "r": {"kind": "R", "resistance": 1}, "loop": {"kind": "1"}},
  "bonds": [{"from": "v", "to": "in"}, {"from": "in", "to": "high"}, {"from": "in", "to": "n"},
    {"from": "n", "to": "brake"}, {"from": "n", "to": "loop"}, {"from": "loop", "to": "l"}, {"from": "loop", "to": "r"}],
  "outputs": {"i": "l.f"}, "scenes": {"run": {"stop": 2}}})";

std::string code_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const ModelError& error) {
    return error.diagnostics.front().code;
  }
  return {};
}

}  // namespace

TEST_CASE("a mode is written and read by the sides that a switch is said to have") {
  const Study study = Study::from_text(kModel);
  const Model& model = study.model();
  CHECK(mode_of(model) == Mode{false, false});
  CHECK(mode_text(model, {true, true}) == "high closed, brake free");
  CHECK(parse_mode(model, "high=closed,brake=locked", {false, true}) == Mode{true, false});
  CHECK(parse_mode(model, "brake=free", {true, false}) == Mode{true, true});
  for (const char* const wrong : {"hihg=open", "high=locked", "brake=open", "high", "high=", "v=open", "=open"}) {
    INFO(wrong);
    CHECK(code_of([&] { parse_mode(model, wrong, {false, false}); }) == "BG173");
  }
}

TEST_CASE("each mode has its own strokes, and its own states") {
  const Study study = Study::from_text(kModel);
  const Study begun = study.at_start();
  CHECK(mode_of(begun.model()) == Mode{true, true});
  CHECK(code_of([&] { static_cast<void>(begun.causality()); }) == "BG301");
  const Study on = study.in_mode({true, false});
  CHECK(on.causality().dependent.empty());
  CHECK(on.equations().states.size() == 1);
  const Study off = study.in_mode({false, false});
  CHECK(off.causality().dependent.size() == 1);
  CHECK(off.equations().states.empty());
  // Names, bonds and symbols are the same in all of them.
  CHECK(on.model().symbols.size() == off.model().symbols.size());
}

TEST_CASE("the modes of a model are listed with what they make of the stores") {
  const Study study = Study::from_text(kModel);
  const std::string text = describe_modes(study.model(), study.graph());
  CHECK(text.find("modes of the switches: 4, of which the graph allows 3") == 0);
  CHECK(text.find("high open, brake locked: dependent: l.p") != std::string::npos);
  CHECK(text.find("high closed, brake free: not allowed: ") != std::string::npos);
}
