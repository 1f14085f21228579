// What is given for a run, before anything is computed from it.
#include "scene/given_values.hpp"

#include <catch2/catch.hpp>

#include "scene/settings.hpp"
#include "support/reading.hpp"

using namespace bgsim;

namespace {

Model oscillator(const std::string& scene) {
  return test::read(R"x("parameters": { "a": 2, "b": { "value": "a^2", "unit": "N/m" } }, "elements": {
    "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "a" },
    "k": { "kind": "C", "capacitance": "b", "initial": { "q": "a" } }, "m": { "kind": "I", "inertance": "b" } },
    "bonds": [ { "from": "j", "to": "r" }, { "from": "j", "to": "k" }, { "from": "j", "to": "m" } ],
    "signals": { "x": { "integral": "m.f", "initial": "b" } },
    "outputs": { "q": "k.q", "p": "m.p", "x": "x" },
    "scenes": { "run": { "stop": 1)x" +
                    scene + " } }");
}

SceneOverrides with_set(std::vector<std::string> set) {
  SceneOverrides overrides;
  overrides.set = std::move(set);
  return overrides;
}

GivenValues given(const Model& model, std::vector<std::string> set = {}) {
  return given_values(model, model.scenes.front(), with_set(std::move(set)));
}

std::string text(const GivenValues& values, const Model& model, ExprId value) {
  return to_text(values.pool, value, [&](SymbolId symbol) { return symbol_name(model, symbol); });
}

/// "element.port = value", in order.
std::string initial_text(const Model& model, const GivenValues& values) {
  std::string result;
  for (const auto& [key, value] : values.initial)
    result += (result.empty() ? "" : ", ") +
              (key.element.valid() ? initial_name(model.elements[key.element.index()], key.port, value.conjugate)
                                   : model.signals[key.signal.index()].name) +
              " = " + text(values, model, value.value);
  return result;
}

}  // namespace

TEST_CASE("a value of the command line goes before one of the scene, and that before the model's") {
  const Model model = oscillator(R"x(, "parameters": { "b": "3*a" }, "initial": { "m.p": "a", "x": "2*b" })x");
  const GivenValues scene = given(model);
  CHECK(text(scene, model, scene.parameters[0].value) == "2");
  CHECK(text(scene, model, scene.parameters[1].value) == "3*a");
  CHECK(initial_text(model, scene) == "k.q = a, m.p = a, x = 2*b");
  CHECK(scene.set_parameters.empty());

  const GivenValues set = given(model, {"a = 5", "x=b", "m.f=a"});
  CHECK(set.problems.empty());
  CHECK(text(set, model, set.parameters[0].value) == "5");
  CHECK(!set.parameters[0].place);
  CHECK(set.parameters[1].place);
  CHECK(initial_text(model, set) == "k.q = a, m.f = a, x = b");
  CHECK(set.set_parameters.size() == 1);
  CHECK(set.set_states.size() == 2);
}

TEST_CASE("each text of --set that is wrong has its own message") {
  const Model model = oscillator("");
  const GivenValues wrong = given(model, {"a", "nothing=1", "a=1", "a=2", "k.q=0", "k.e=1", "b=t", "m.p=a +"});
  std::string codes;
  for (const Diagnostic& problem : wrong.problems) codes += problem.code + " ";
  CHECK(codes == "BG141 BG141 BG141 BG141 BG141 BG120 ");
  CHECK(wrong.problems[3].situation == R"(--set "k.q=0" and --set "k.e=1" set the same store)");
  CHECK(text(wrong, model, wrong.parameters[0].value) == "1");
}

TEST_CASE("states are found by the names of what is stored and of what the law gives") {
  const Model model = oscillator("");
  const StateNames states(model);
  CHECK(states.find("k.q")->key == states.find("k.e")->key);
  CHECK(states.find("k.e")->conjugate);
  CHECK(states.find("m.p")->key.element == ElementId(3));
  CHECK(states.find("x")->key.signal == SignalId(0));
  CHECK(!states.find("k.f"));
  CHECK(!states.find("r.e"));
}

TEST_CASE("a method from the command line does not take over the step of the scene") {
  const Model model = oscillator(R"x(, "method": "rk4", "step": 0.01)x");
  const auto chosen = [&](std::optional<Method> method, std::optional<double> step, std::size_t faults) {
    SceneOverrides overrides;
    overrides.method = method;
    overrides.step = step;
    RunInputs inputs;
    std::vector<Diagnostic> problems;
    choose_method(model.scenes.front(), overrides, inputs, problems);
    CHECK(problems.size() == faults);
    return inputs.step;
  };
  CHECK(chosen({}, {}, 0) == 0.01);
  CHECK(chosen({}, 0.5, 0) == 0.5);
  CHECK(chosen(Method::bdf, {}, 0) == 0.0);
  CHECK(chosen(Method::euler, {}, 1) == 0.0);
  CHECK(chosen(Method::euler, 0.1, 0) == 0.1);
  CHECK(chosen(Method::bdf, 0.1, 1) == 0.1);
  chosen({}, -1.0, 1);
}
