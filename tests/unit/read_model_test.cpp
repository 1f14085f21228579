#include <catch2/catch.hpp>

#include "bgsim/model.hpp"
#include "support/reading.hpp"

using namespace bgsim;
using test::fault;
using test::faults;
using test::read;

namespace {

/// A source, a resistor and a store on one junction, with parts of the text replaced.
std::string loop(const std::string& resistor = R"x("kind": "R", "resistance": "R")x", const std::string& more = "",
                 const std::string& store = R"x("kind": "C", "capacitance": 0.5)x") {
  return R"x("parameters": { "R": 2 }, )x" + more + R"x("elements": {
    "source": { "kind": "Se", "effort": "sin(t)" }, "loop": { "kind": "1" },
    "resistor": { )x" +
         resistor + R"x( }, "store": { )x" + store + R"x(
}
},
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "resistor" }, { "from": "loop", "to": "store" } ])x";
}

std::string text_of(const Model& model, ExprId e) {
  return to_text(model.pool, e, [&](SymbolId s) { return symbol_name(model, s); });
}

const Element& element(const Model& model, const std::string& name) {
  for (const Element& e : model.elements)
    if (e.name == name) return e;
  throw std::out_of_range(name);
}

}  // namespace

TEST_CASE("the model of the format's own description is read whole") {
  const Model m = read_model_text("models/bellow.json", test::example_of_the_format());
  CHECK(m.name == "bellow");
  CHECK(m.parameters.size() == 16);
  CHECK(m.elements.size() == 7);
  CHECK(m.bonds.size() == 6);
  const Element& packet = element(m, "packet");
  CHECK(packet.kind == ElementKind::c_field);
  CHECK(packet.ports == std::vector<std::string>{"air", "wall"});
  // The field's own port "wall" comes before the junction of that name.
  CHECK(text_of(m, packet.energy) == "(packet.air.q - A*packet.wall.q)^2/(2*C2) + k*packet.wall.q^2/2");
  CHECK(packet.initial.size() == 2);
  const Element& orifice = element(m, "orifice");
  REQUIRE(orifice.laws.size() == 1);
  CHECK(orifice.laws[0].variable == Variable::flow);
  CHECK(text_of(m, orifice.laws[0].right) == "Cd*D*ssqrt(orifice.e, delta)");
  CHECK(element(m, "pump").modulated);
  CHECK(text_of(m, element(m, "damping").coefficient) == "R_b");
  CHECK(m.bonds[2].name == "b3");
  CHECK(m.bonds[2].to.port == 0u);
  CHECK_FALSE(m.bonds[2].from.port.has_value());
  CHECK(m.outputs[1].name == "P2");
  CHECK(m.scenes.size() == 2);
  CHECK(m.parameters[0].unit == "m^2");
}

TEST_CASE("the example of submodels in the format's description is read beside the shipped models") {
  const Model m = read_model_text(BGSIM_SOURCE_DIR "/models/two_bellows.json", test::example_of_submodels());
  CHECK(symbol_name(m, port_variable(element(m, "left.field"), 1, Variable::displacement)) == "left.field.wall.q");
  CHECK(prepare_scene(m, "").initial.size() == 1);
}

TEST_CASE("a file that is none is refused with the reason") {
  const auto reason = [](const std::string& path) {
    try {
      read_model(path);
    } catch (const ModelError& error) {
      return error.diagnostics.front().code + " " + error.diagnostics.front().situation;
    }
    return std::string("none");
  };
  CHECK(reason("no/such.json") == "BG100 cannot read \"no/such.json\": there is no such file");
  CHECK(reason(".") == "BG100 cannot read \".\": it is a folder");
}

TEST_CASE("symbols of an element's ports stand one after the other") {
  const Model m = read(loop());
  for (const Element& e : m.elements) {
    if (is_junction(e.kind)) {
      CHECK(symbol_name(m, e.first_symbol) == e.name + ".f");
      continue;
    }
    for (const Variable v : {Variable::effort, Variable::flow})
      CHECK(symbol_name(m, port_variable(e, 0, v)) == e.name + "." + letter(v));
  }
  CHECK(symbol_name(m, port_variable(element(m, "store"), 0, Variable::displacement)) == "store.q");
  CHECK(symbol_name(m, m.time) == "t");
}

TEST_CASE("bonds have the names they are given, or their positions") {
  const Model m = read(
      R"x("elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "s", "to": "j", "name": "supply", "about": "the mains" }, { "from": "j", "to": "r" } ],
    "outputs": { "P": "supply.e*supply.f", "f": "b2.f", "unnamed": "j.f" })x");
  CHECK(m.bonds[0].name == "supply");
  CHECK(m.bonds[1].name == "b2");
  CHECK(text_of(m, m.outputs[0].value) == "supply.e*supply.f");
  CHECK(text_of(m, m.outputs[2].value) == "j.f");
}

TEST_CASE("extensions of the format are taken: about, priority, units of outputs, names of bonds") {
  const Model m = read(loop(
      R"x("kind": "R", "about": "a pipe", "law": "f = e/R")x",
      R"x("$schema": "model.schema.json", "outputs": { "q": { "value": "store.q", "unit": "C", "about": "charge" } }, )x",
      R"x("kind": "C", "capacitance": 0.5, "priority": 2, "initial": { "q": "2*R" })x"));
  CHECK(element(m, "resistor").about == "a pipe");
  CHECK(element(m, "store").priority == 2.0);
  CHECK(m.outputs[0].unit == "C");
  CHECK(text_of(m, element(m, "store").initial[0].value) == "2*R");
}

TEST_CASE("a model without a name is called like its file") {
  CHECK(read_model_text("folder/pump.json", R"x({ "bgsim": 1, )x" + loop() + "}").name == "pump");
}

TEST_CASE("a name decides what a variable is: signals, elements, ports, junctions, bonds") {
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "resistor")x")) ==
        "BG121 [resistor] \"resistor\" is an element, no quantity; write one of its variables, such as \"resistor.e\"");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "loop.e")x")) ==
        "BG121 [loop.e] \"loop\" is a 1-junction and has no .e; the bonds of a 1-junction share their flow \"loop.f\" "
        "only; "
        "for another variable name a bond");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "store.p")x")) ==
        "BG121 [store.p] an element of kind C has no .p; its variables are \"e\", \"f\" and \"q\"");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "b2.q")x")) ==
        "BG121 [b2.q] a bond has no .q; a bond has an effort \"b2.e\" and a flow \"b2.f\"");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "b2")x")) ==
        "BG121 [b2] \"b2\" is a bond, no quantity; write its effort \"b2.e\" or its flow \"b2.f\"");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "stor.q")x")) ==
        "BG121 [stor.q] unknown name \"stor.q\"; did you mean \"store.q\"?");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "store.a.q")x")) ==
        "BG121 [store.a.q] \"store\" has no named ports; write \"store.q\"");
}

TEST_CASE("a law has one variable of its element alone on the left, and relates the two of its kind") {
  const auto law = [](const std::string& text) { return fault(loop(R"x("kind": "R", "law": ")x" + text + "\"")); };
  CHECK(law("e = R*f") == "none");
  CHECK(law("resistor.f = resistor.e/R") == "none");
  CHECK_THAT(law("2*e = R*f"), Catch::StartsWith("BG117 [2*e] the left side of this law is not e or f alone; "));
  CHECK_THAT(law("store.q = R*f"),
             Catch::StartsWith("BG117 [store.q] the left side of this law is not e or f alone; "));
  CHECK_THAT(law("e = R*f + e"), Catch::StartsWith("BG117 [R*f + e] resistor.e is on both sides of"));
  CHECK_THAT(law("e = q"), Catch::StartsWith("BG121 [q] unknown name \"q\"; the law of R has no displacement"));
  CHECK_THAT(law("e = R*loop.f"), Catch::StartsWith("BG118 [\"e = R*loop.f\"] the R \"resistor\" is modulated by \"l"));
  CHECK_THAT(fault(loop(R"x("kind": "R", "law": "e = R*f")x", "", R"x("kind": "C", "law": "e = 2*q + f")x")),
             Catch::StartsWith("BG117 [2*q + f] this law contains the element's own store.f; put "));
  CHECK(fault(loop(R"x("kind": "R", "law": "e = R*f")x", "", R"x("kind": "C", "law": "q = tanh(e)")x")) == "none");
  CHECK(fault(loop(R"x("kind": "R", "law": "e = R*f")x", "", R"x("kind": "I", "law": "f = p/sqrt(1 + p^2)")x")) ==
        "none");
}

TEST_CASE("own variables come first only where they would be hidden, and a parameter called e or f is an error there") {
  CHECK(fault(loop(R"x("kind": "R", "law": "e = R*f")x", R"x("signals": { "q": "sin(t)" }, )x")) ==
        "none");  // an R has no q
  CHECK(fault(loop(R"x("kind": "R", "law": "e = R*f + q")x", R"x("signals": { "q": "sin(t)"
}, )x")) == "none");
  CHECK(
      fault(loop(R"x("kind": "R", "law": "e = R*f")x", R"x("signals": { "e": "sin(t)"
}, )x")) ==
      "BG116 [e] \"e\" is ambiguous in this law: it is a variable of \"resistor\" and a signal of the model; give the "
      "signal \"e\" another name");
  CHECK(fault(loop(R"x("kind": "R", "resistance": "R")x", R"x("signals": { "e": "sin(t)"
  }, )x")) == "none");
}

TEST_CASE("plain kinds vary with t, parameters and signals of t, however the signal comes by it") {
  const std::string through = R"x("signals": { "a": "b + 1", "b": "c*R", "c": "sin(t)" }, )x";
  CHECK(fault(loop(R"x("kind": "R", "resistance": "2 + a")x", through)) == "none");
  const std::string state = R"x("signals": { "a": "b + 1", "b": "c*R", "c": "store.q" }, )x";
  CHECK(fault(loop(R"x("kind": "R", "resistance": "2 + a")x", state)) ==
        "BG118 [\"2 + a\"] the R \"resistor\" is modulated by \"a\"; make it of kind \"MR\"");
  CHECK(fault(loop(R"x("kind": "MR", "resistance": "2 + a")x", state)) == "none");
  CHECK(fault(loop(R"x("kind": "R", "resistance": "1 + resistor.f")x")) ==
        "BG118 [\"1 + resistor.f\"] the R \"resistor\" is modulated by \"resistor.f\"; write a \"law\" if it is "
        "nonlinear");
}

TEST_CASE("parameters and initial values are constants") {
  const auto parameter = [](const std::string& value) {
    return fault(R"x("parameters": { "a": 1, "b": )x" + value + R"x( }, "signals": { "s": "sin(t)" },
      "elements": { "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 } }, "bonds": [ { "from": "j", "to": "m" } ])x");
  };
  CHECK(parameter("\"2*a + pi\"") == "none");
  CHECK(parameter(R"x({ "value": "2*a", "unit": "m", "about": "x", "source": "y" })x") == "none");
  CHECK(parameter("\"2*t\"") ==
        "BG118 [\"2*t\"] t cannot be used in a parameter; what varies is declared among \"signals\"");
  CHECK(parameter("\"der(a)\"") ==
        "BG118 [\"der(a)\"] der cannot be used in a parameter; what varies is declared among \"signals\"");
  CHECK_THAT(parameter("\"2*s\""), Catch::StartsWith("BG118 [s] the signal \"s\" cannot be used in a parameter; a "));
  CHECK_THAT(parameter("\"2*m.p\""),
             Catch::StartsWith("BG118 [m.p] \"m.p\" cannot be used in a parameter: it varies; a p"));
  CHECK(parameter("true") == "BG113 [true] a parameter must be a number or an expression, not true or false");
  CHECK(parameter("{}") == "BG112 [\"b\"] parameter \"b\" has no \"value\"; add \"value\": a number or an expression");
}

TEST_CASE("circles among parameters and signals are named once") {
  CHECK(fault(R"x("parameters": { "a": "b", "b": "c", "c": "a", "d": "a", "R": 1 }, )x" + loop().substr(26)) ==
        "BG132 [\"b\"] parameters depend on each other: a -> b -> c -> a; give one of them a value that does not refer "
        "to "
        "the others");
  CHECK(faults(R"x("parameters": { "a": "a", "b": "2*b", "R": 1 }, )x" + loop().substr(26)) == 2);
}

TEST_CASE("a chain of a hundred thousand signals is read in either order without deep recursion", "[long]") {
  for (const bool forward : {true, false}) {
    std::string signals = "\"s0\": \"sin(t)\"";
    for (int i = 1; i < 100'000; ++i) {
      const std::string one = "\"s" + std::to_string(i) + "\": \"s" + std::to_string(i - 1) + " + 1\"";
      signals = forward ? std::move(signals) + ", " + one : signals;
    }
    if (!forward) {
      signals.clear();
      for (int i = 99'999; i > 0; --i)
        signals += "\"s" + std::to_string(i) + "\": \"s" + std::to_string(i - 1) + " + 1\", ";
      signals += "\"s0\": \"sin(t)\"";
    }
    const Model m = read(loop(R"x("kind": "R", "resistance": "2 + s99999^2")x", "\"signals\": { " + signals + " }, "));
    CHECK(m.signals.size() == 100'000);
  }
}

TEST_CASE("one cause gives one message, all causes are reported in file order") {
  const std::string text = R"x("parameters": { "R": "2*Q" }, "elements": {
    "source": { "kind": "Sx", "effort": 1 }, "loop": { "kind": "1" }, "2nd": { "kind": "R", "resistance": 1 },
    "store": { "kind": "C", "capacitance": "R*source.f", "inital": { "q": 1 } } },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "2nd" }, { "from": "loop", "to": "stor" }, { "from": "loop" } ],
    "outputs": { "i": "source.f", "x": "source" },
    "scenes": { "run": { "stop": 1, "sample": 3 } })x";
  CHECK(test::codes(text) == "BG121 BG114 BG115 BG111 BG130 BG112 BG111 ");
}

TEST_CASE("more than a hundred problems end with their number") {
  std::string elements = R"x("j": { "kind": "1" })x";
  for (int i = 0; i < 250; ++i) elements += ", \"r" + std::to_string(i) + R"x(": { "kind": "R" })x";
  try {
    read("\"elements\": { " + elements + " }");
    FAIL("accepted");
  } catch (const ModelError& error) {
    REQUIRE(error.diagnostics.size() == 101);
    CHECK(error.diagnostics.back().code == "BG105");
    CHECK(error.diagnostics.back().situation == "150 further problems are not shown");
  }
}

TEST_CASE("every wrong type of value is reported, with the right one") {
  CHECK(fault(R"("elements": [])") ==
        "BG113 [[]] \"elements\" must be an object, not an array; write an object: "
        "{ \"mass\": { \"kind\": \"I\", \"inertance\": 2 } }");
  CHECK(fault(R"("elements": {})") == "BG112 [{}] the model has no elements; add at least one element");
  CHECK(fault(loop().substr(0, loop().find("\"bonds\"")) + "\"bonds\": {}") ==
        "BG113 [{}] \"bonds\" must be an array, not an object; write an array: [{ \"from\": \"body\", \"to\": \"mass\" "
        "}]");
  CHECK(fault(loop(R"x("kind": "R", "resistance": null)x")) ==
        "BG113 [null] \"resistance\" must be a number or an expression, not null");
  CHECK(fault(loop(R"x("kind": "R", "law": 3)x")) ==
        "BG113 [3] \"law\" must be a text, not a number; write an equation in quotes, such as \"e = k*q^3\"");
  CHECK(fault(loop(R"x("kind": 1)x")) == "BG113 [1] \"kind\" must be a text, not a number; write it in quotes: \"1\"");
  CHECK(test::whole_fault("[]") == "BG113 [[]] a model must be an object, not an array");
}

TEST_CASE("keys of another kind are refused with what the kind may have") {
  CHECK(fault(loop(R"x("kind": "R", "capacitance": 1, "resistance": 1)x")) ==
        "BG111 [\"capacitance\"] an element of kind R has no key \"capacitance\"; an R has a \"resistance\" "
        "(e = R f) or a \"law\" such as \"f = G*e\"");
  CHECK_THAT(fault(loop(R"x("kind": "R", "resistance": 1, "initial": { "q": 1 })x")),
             Catch::StartsWith("BG111 [\"initial\"]"));
}

TEST_CASE("a field has named ports, a law for each, or an energy over what it stores") {
  const auto field = [](const std::string& body) {
    return fault(R"x("elements": { "j": { "kind": "1" }, "c": { )x" + body + R"x( } },
      "bonds": [ { "from": "j", "to": "c.a" }, { "from": "j", "to": "c.b" } ])x");
  };
  CHECK(field(R"x("kind": "CC", "ports": ["a", "b"], "energy": "a.q^2 + (a.q - b.q)^2")x") == "none");
  CHECK(field(R"x("kind": "CC", "ports": ["a", "b"], "laws": ["a.e = a.q - 2*b.e", "b.e = a.q + b.q"])x") == "none");
  CHECK(field(R"x("kind": "RR", "ports": ["a", "b"], "laws": ["a.e = a.f*b.e", "b.f = b.e"])x") == "none");
  CHECK(field(R"x("kind": "II", "ports": ["a", "b"], "energy": "a.p^2 + t*b.p^2")x") == "none");
  CHECK_THAT(field(R"x("kind": "CC", "ports": ["a", "b"], "energy": "a.q^2 + b.f")x"),
             Catch::StartsWith("BG117 [\"a.q^2 + b.f\"] the energy depends on the fi"));
  CHECK_THAT(field(R"x("kind": "CC", "ports": ["a", "b"], "laws": ["a.e = a.q", "a.e = b.q"])x"),
             Catch::StartsWith("BG117 [\"a.e = b.q\"] the port \"a\" has two "));
  CHECK_THAT(field(R"x("kind": "CC", "ports": ["a", "a", "b"], "energy": "a.q^2")x"),
             Catch::StartsWith("BG116 [\"a\"] the field \"c\" has two ports called"));
  CHECK_THAT(field(R"x("kind": "CC", "energy": "1")x"),
             Catch::StartsWith("BG112 [\"c\"] the field \"c\" has no \"ports\""));
  CHECK_THAT(field(R"x("kind": "RR", "ports": ["a", "b"], "energy": "1", "laws": ["a.e = a.f", "b.f = b.e"])x"),
             Catch::StartsWith("BG111 [\"energy\"]"));
}

TEST_CASE("bonds say where they stand") {
  const auto bond = [](const std::string& end) {
    return fault(
        R"x("parameters": { "k": 1 }, "elements": { "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "tf": { "kind": "TF", "modulus": 2 }, "c": { "kind": "CC", "ports": ["a", "b"], "energy": "a.q^2 + b.q^2" } },
      "bonds": [ { "from": "j", "to": ")x" +
        end + "\" } ]");
  };
  CHECK(bond("r") == "none");
  CHECK(bond("tf") == "none");
  CHECK(bond("tf.2") == "none");
  CHECK(bond("c.b") == "none");
  CHECK(bond("c") == "BG131 [\"c\"] \"c\" has several ports: the bond must name one of them; write \"c.a\" or \"c.b\"");
  CHECK(bond("c.d") == "BG131 [\"c.d\"] \"c\" has no port \"d\"; its ports are \"a\" and \"b\"");
  CHECK(bond("tf.3") == "BG131 [\"tf.3\"] \"tf\" has no port \"3\"; its ports are \"1\" and \"2\"");
  CHECK(bond("r.a") == "BG131 [\"r.a\"] \"r\" has one port only, without a name; write \"r\"");
  CHECK(bond("j.1") ==
        "BG131 [\"j.1\"] \"j\" is a junction: it has as many bonds as it needs, but no named ports; write \"j\"");
  CHECK(bond("k") == "BG130 [\"k\"] \"k\" is not an element");
  CHECK(bond("R") == "BG130 [\"R\"] there is no element \"R\" to bond to; did you mean \"r\"?");
  CHECK(bond("") ==
        "BG130 [\"\"] there is no element \"\" to bond to; the elements are \"j\", \"r\", \"tf\" and \"c\"");
}

TEST_CASE("a model of a hundred thousand elements is read by hashing, not by searching", "[long]") {
  std::string elements = R"x("s": { "kind": "Se", "effort": 1 })x", bonds;
  for (int i = 0; i < 50'000; ++i) {
    const std::string n = std::to_string(i);
    elements += ", \"j" + n + R"x(": { "kind": "0" }, "c)x" + n +
                R"x(": { "kind": "C", "capacitance": "C", "initial": { "q": 1 } })x";
    bonds += (i == 0 ? "" : ", ") + std::string("{ \"from\": \"j") + n + "\", \"to\": \"c" + n + "\" }";
  }
  const Model m = read(R"("parameters": { "C": 1 }, "elements": { )" + elements + " }, \"bonds\": [ " + bonds + " ]");
  CHECK(m.elements.size() == 100'001);
  CHECK(m.elements[77'777].name == "j38888");
  CHECK(m.bonds.back().name == "b50000");
}
