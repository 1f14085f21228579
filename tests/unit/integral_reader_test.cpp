// Integrals among the signals, as the reader takes them.
#include <catch2/catch.hpp>

#include "support/reading.hpp"

using namespace bgsim;
using test::line_of;

namespace {

std::string body(const std::string& signals, const std::string& flow = "x") {
  return R"x("signals": { )x" + signals + R"x( }, "elements": {
    "s": { "kind": "MSf", "flow": ")x" +
         flow + R"x(" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "c" } ], "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 1 } })x";
}

std::string text(const Model& model, ExprId e) {
  return to_text(model.pool, e, [&](SymbolId s) { return symbol_name(model, s); });
}

/// A folder with a submodel whose signal x is what @p signal says.
struct Folder {
  explicit Folder(const std::string& signal) {
    files.write("part.json", R"x({ "bgsim": 1, "parameters": { "k": 3 }, "signals": { "x": )x" + signal +
                                 R"x( }, "elements": { "s": { "kind": "MSf", "flow": "x" }, "j": { "kind": "0" } },
             "bonds": [ { "from": "s", "to": "j" } ], "ports": { "j": "j" } })x");
  }

  /// The model whose element `left` is that submodel with @p signals.
  [[nodiscard]] Model read(const std::string& signals, const std::string& scene = "") const {
    return read_model_text((files.path() / "whole.json").string(),
                           R"x({ "bgsim": 1, "types": { "part": "part.json" }, "parameters": { "a": 2 }, "elements": {
      "left": { "kind": "part", "signals": { )x" +
                               signals + R"x( } }, "c": { "kind": "C", "capacitance": 1 } },
      "bonds": [ { "from": "left.j", "to": "c" } ], "outputs": { "x": "left.x" },
      "scenes": { "main": { "stop": 1 )x" +
                               scene + "} } }");
  }
  [[nodiscard]] std::string fault(const std::string& signals, const std::string& scene = "") const {
    try {
      static_cast<void>(read(signals, scene));
    } catch (const ModelError& error) {
      return line_of(error.diagnostics.front(), *error.sources);
    }
    return "none";
  }
  test::TemporaryFolder files;
};

}  // namespace

TEST_CASE("an integral is a signal with a rate and an initial value") {
  const Model model =
      test::read(body(R"("x": { "integral": "c.q - x", "initial": "2/8", "unit": "m", "about": "a" })"));
  REQUIRE(model.signals.size() == 1);
  const Signal& x = model.signals[0];
  CHECK(x.is_state());
  CHECK(text(model, x.value) == "c.q - x");
  CHECK(text(model, x.initial) == "0.25");
  CHECK(x.unit == "m");
  CHECK(x.about == "a");
}

TEST_CASE("no circle of signals runs through an integral") {
  CHECK(test::fault(body(R"("x": { "integral": "y" }, "y": "z", "z": "2*x")")) == "none");
  CHECK(test::fault(body(R"("x": { "integral": "x" })")) == "none");
  CHECK(test::fault(body(R"("x": { "integral": "y" }, "y": "z + x", "z": "2*y")")).substr(0, 5) == "BG132");
}

TEST_CASE("faults of integrals have their places") {
  CHECK(test::fault(body(R"("x": { "unit": "m" })")) ==
        "BG112 [\"x\"] signal \"x\" has no \"value\"; add \"value\": a number or an expression, or \"integral\": its "
        "rate");
  CHECK(test::fault(body(R"("x": { "integral": "c.q", "value": 1 })")).substr(0, 18) == "BG112 [\"integral\"]");
  CHECK(test::fault(body(R"("x": { "value": 1, "initial": 1 })")).substr(0, 17) == "BG111 [\"initial\"]");
  CHECK(test::fault(body(R"("x": { "integral": "c.q", "initial": "c.q" })")).substr(0, 5) == "BG118");
  CHECK(test::fault(body(R"("x": { "integral": "c.w" })")).substr(0, 11) == "BG121 [c.w]");
  CHECK(test::fault(body(R"("x": { "integral": 1 }, "p": 1)") + R"(, "parameters": { "a": { "integral": 1 } })")
            .substr(0, 18) == "BG111 [\"integral\"]");
}

TEST_CASE("an integral of a submodel belongs to it, and whoever uses it may give it another rate or start") {
  const Folder folder(R"x({ "integral": "k - x", "initial": "k" })x");
  const auto x = [&](const std::string& signals) {
    const Model model = folder.read(signals);
    const Signal& signal = model.signals.at(0);
    CHECK(signal.name == "left.x");
    return (signal.is_state() ? "' " : "") + text(model, signal.value) +
           (signal.initial.valid() ? " from " + text(model, signal.initial) : "");
  };
  CHECK(x("") == "' left.k - left.x from left.k");
  CHECK(x(R"("x": "a*c.q")") == "a*c.q");
  CHECK(x(R"("x": { "value": "a" })") == "a");
  CHECK(x(R"("x": { "integral": "a" })") == "' a");
  CHECK(x(R"("x": { "integral": "a", "initial": "2*a" })") == "' a from 2*a");
  CHECK(x(R"("x": { "initial": "a" })") == "' left.k - left.x from a");
  CHECK(folder.fault(R"("x": { "initial": 1, "unit": "m" })").substr(0, 14) == "BG111 [\"unit\"]");
  CHECK(folder.fault("", R"(, "initial": { "left.x": 1 })") == "none");
  CHECK(folder.fault("", R"(, "initial": { "x": 1 })").substr(0, 5) == "BG147");
  CHECK(folder.fault("", R"(, "absolute": { "left.x": 1 })") == "none");
  CHECK(folder.fault(R"("x": "a")", R"(, "initial": { "left.x": 1 })").substr(0, 5) == "BG147");
}

TEST_CASE("a plain signal of a submodel may be made an integral") {
  const Folder folder("\"2*k\"");
  const Model model = folder.read(R"("x": { "integral": "c.q" })");
  CHECK(model.signals.at(0).is_state());
  CHECK(folder.fault(R"("x": { "initial": 1 })").substr(0, 10) == "BG112 [\"x\"");
}
