// Units: their texts, what follows from those that are given, and what contradicts.
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <set>

#include "bgsim/bgsim.hpp"
#include "support/approx.hpp"
#include "support/model_text.hpp"

using namespace bgsim;

namespace {

double scale(const std::string& text) {
  const ParsedUnit parsed = parse_unit(text);
  INFO(text << ": " << parsed.fault);
  REQUIRE(parsed.unit);
  return std::exp(parsed.unit->log_scale);
}

bool same(const std::string& a, const std::string& b) {
  const ParsedUnit left = parse_unit(a), right = parse_unit(b);
  INFO(a << " and " << b << ": " << left.fault << right.fault);
  REQUIRE((left.unit && right.unit));
  return same_unit(*left.unit, *right.unit);
}

struct Units {
  explicit Units(const std::string& body, const std::string& scene = {})
      : model(read_model_text("test.json", test::model_text(body))),
        graph(build_bond_graph(model)),
        report(infer_units(model, graph, scene)) {}

  [[nodiscard]] std::string parameter(const std::string& name) const {
    for (std::size_t i = 0; i < model.parameters.size(); ++i)
      if (model.parameters[i].name == name) return report.parameters[i].text;
    return "no such parameter";
  }
  [[nodiscard]] std::string output(const std::string& name) const {
    for (std::size_t i = 0; i < model.outputs.size(); ++i)
      if (model.outputs[i].name == name) return report.outputs[i].text;
    return "no such output";
  }
  /// "BG161 BG162": the codes of all problems.
  [[nodiscard]] std::string codes() const {
    std::string text;
    for (const Diagnostic& problem : report.problems) text += (text.empty() ? "" : " ") + problem.code;
    return text;
  }
  [[nodiscard]] std::string situation() const {
    return report.problems.empty() ? std::string() : report.problems.front().situation;
  }

  Model model;
  BondGraph graph;
  UnitReport report;
};

/// A source, a resistor and a store on one junction, with what the parts say.
std::string circuit(const std::string& parameters, const std::string& source, const std::string& resistor,
                    const std::string& store, const std::string& outputs) {
  return R"("parameters": {)" + parameters + R"(}, "elements": { "source": { "kind": "MSe", "effort": ")" + source +
         R"(" }, "loop": { "kind": "1" }, "r": { )" + resistor + R"( }, "store": { )" + store +
         R"( } }, "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" }, )" +
         R"({ "from": "loop", "to": "store" } ], "outputs": { )" + outputs + " }";
}

/// The codes for a circuit whose source is @p effort; voltages and currents are anchored.
std::string with_effort(const std::string& effort) {
  return Units(circuit(R"("U": { "value": 1, "unit": "V" }, "T": { "value": 1, "unit": "s" },
                          "omega": { "value": 1, "unit": "rad/s" }, "n": { "value": 2, "unit": "1" })",
                       effort, R"("kind": "R", "resistance": 1)", R"("kind": "C", "capacitance": 1)",
                       R"("u": { "value": "store.e", "unit": "V" }, "i": { "value": "loop.f", "unit": "A" })"))
      .codes();
}

}  // namespace

TEST_CASE("texts of units mean what they say") {
  CHECK(same("N m", "kg*m^2/s^2"));
  CHECK(same("J/(K mol)", "J K^-1 mol^-1"));
  CHECK(same("Pa", "N/m^2"));
  CHECK(same("V s", "Wb"));
  CHECK(same("Ohm", "V/A"));
  CHECK(same("ohm", "1/S"));
  CHECK(same("H", "Wb/A"));
  CHECK(same("T m\xC2\xB2", "Wb"));
  CHECK(same("s\xE2\x81\xBB\xC2\xB9", "Hz"));
  CHECK(same("m/s/s", "m s^-2"));
  CHECK(same("Pa^(1/2)", "Pa^0.5"));
  CHECK(same("N\xC2\xB7m", "N.m"));
  CHECK(same("rad/s", "1/s"));
  CHECK(same("100 kPa", "bar"));
  CHECK(
      same("\xC2\xB5"
           "F",
           "uF"));
  CHECK(same("kg/sec", "kg/s"));
  CHECK_FALSE(same("bar", "Pa"));
  CHECK_FALSE(same("mmHg", "Pa"));
  CHECK(same("mmHg", "Torr"));  // they differ by 1.4e-7
  // A unit keeps the logarithm of its scale: what is lost is its magnitude's share of the last bits.
  const auto exactly = [](double value) { return test::same_to_rounding(value, 32); };
  CHECK(scale("min") == exactly(60.0));
  CHECK(scale("mbar") == exactly(100.0));
  CHECK(scale("kg") == exactly(1.0));
  CHECK(scale("g") == exactly(1e-3));
  CHECK(scale("rpm") == exactly(2.0 * std::numbers::pi / 60.0));
  CHECK(scale("deg") == exactly(std::numbers::pi / 180.0));
  CHECK(scale("kWh") == exactly(3.6e6));
  constexpr double kPrinted = 1e-12;  // NIST SP 811, B.8, prints 13 digits
  CHECK(scale("psi") == Approx(6894.757293168).epsilon(kPrinted));
  CHECK(scale("hp") == Approx(745.6998715822).epsilon(kPrinted));
  CHECK(scale("L/min") == exactly(1e-3 / 60.0));
}

TEST_CASE("texts that are no units are refused with what was probably meant") {
  const auto help = [](const std::string& text) {
    const ParsedUnit parsed = parse_unit(text);
    return parsed.unit ? "understood" : parsed.help;
  };
  CHECK(help("Nm") == "products are written with a space: did you mean \"N m\"?");
  CHECK(help("J/kg K") == "use parentheses: \"J/(kg K)\", or put the division last: \"N m/rad\"");
  CHECK(help("m2") == "powers are written with ^: \"m^2\"");
  CHECK(help("newtons") == "did you mean \"N\"?");
  CHECK(help("hz") == "did you mean \"Hz\"?");
  CHECK(help("degC") == "give temperatures in K; a difference of 1 degC is 1 K");
  CHECK(help("persons").empty());
  for (const char* text : {"", " ", "/s", "m/", "(m", "m)", "m^", "m^x", "0 m", "-m", "m//s", "m^(1/0)", "m^1000"})
    CHECK_FALSE(parse_unit(text).unit);
  CHECK_FALSE(parse_unit(std::string(100, '(') + "m" + std::string(100, ')')).unit);
}

TEST_CASE("computed units get the usual texts") {
  for (const char* text : {"N", "Pa",  "m/s^2",    "m^3/s", "N/m", "kg/s", "J/(kg K)", "W/K", "m^3/Pa", "kg m^2",
                           "1", "V^2", "m Pa^0.5", "bar",   "mm",  "min",  "1/s",      "Wb",  "g",      "V H"}) {
    CHECK(unit_text(*parse_unit(text).unit) == text);
    CHECK(same(unit_text(*parse_unit(text).unit), text));
  }
  CHECK(unit_text(*parse_unit("1e5 N").unit) == "100000 N");
}

TEST_CASE("units that are not given follow from those that are") {
  const Units c(circuit(R"("U": { "value": 1, "unit": "V" }, "R": 1, "C": 1e-6, "tau": "R*C", "half": 0.5)",
                        "U*(1 - exp(-t/tau))*half", R"("kind": "R", "resistance": "R")",
                        R"("kind": "C", "capacitance": "C", "initial": { "q": 0 })",
                        R"("i": { "value": "loop.f", "unit": "A" }, "q": "store.q", "rate": "der(store.e)/half")"));
  CHECK(c.codes().empty());
  CHECK(c.parameter("R") == "Ohm");
  CHECK(c.parameter("C") == "F");
  CHECK(c.parameter("tau") == "s");
  CHECK(c.output("q") == "C");
  CHECK(c.parameter("half") == "1");
}

TEST_CASE("a resistance alone gives volts and amperes, since their product is a power") {
  const Units c(circuit(R"("R": { "value": 1, "unit": "Ohm" })", "1", R"("kind": "R", "resistance": "R")",
                        R"("kind": "C", "capacitance": 1)", R"("u": "store.e", "i": "loop.f", "q": "store.q")"));
  CHECK(c.codes().empty());
  CHECK(c.output("u") == "V");
  CHECK(c.output("i") == "A");
  CHECK(c.output("q") == "C");
}

TEST_CASE("temperature and heat flow make a pseudo bond graph, which is legal") {
  const Units c(circuit(R"("R": { "value": 1, "unit": "K/W" }, "T": { "value": 300, "unit": "K" }, "C": 1)", "T",
                        R"("kind": "R", "resistance": "R")", R"("kind": "C", "capacitance": "C")", R"("f": "loop.f")"));
  CHECK(c.codes().empty());
  CHECK(c.output("f") == "W");
  CHECK(c.parameter("C") == "J/K");
  CHECK(c.report.regions.front().pseudo);
}

TEST_CASE("efforts and flows that make no power are reported, unless the flow is one of heat, mass or matter") {
  const auto codes = [](const std::string& resistance, const std::string& effort) {
    return Units(circuit(R"("R": { "value": 1, "unit": ")" + resistance + R"(" }, "e": { "value": 1, "unit": ")" +
                             effort + R"(" })",
                         "e", R"("kind": "R", "resistance": "R")", R"("kind": "C", "capacitance": 1)", ""))
        .codes();
  };
  CHECK(codes("Ohm", "V").empty());
  CHECK(codes("K/W", "K").empty());
  CHECK(codes("Pa s/kg", "Pa").empty());
  CHECK(codes("m^3 s/mol", "mol/m^3") == "BG163");  // a flow in mol^2/(m^6 s) is none of matter
  CHECK(codes("s/m^3", "mol/m^3").empty());
  CHECK(codes("H", "V") == "BG163");
  CHECK(codes("Pa s/m^3", "bar").empty());  // a power of another scale
}

TEST_CASE("a model without units is not looked at, whatever it says") {
  const Units c(circuit(R"("x": 1)", "sin(x*t) + t", R"("kind": "R", "resistance": "x")",
                        R"("kind": "C", "capacitance": "x^2")", R"("f": "loop.f + t")"));
  CHECK(c.codes().empty());
  CHECK_FALSE(c.report.any_given);
  CHECK(c.output("f") == "");
}

TEST_CASE("a latch gives no unit, and a contradiction shows at an equation whose sides differ") {
  const auto counted = [](const std::string& parameters) {
    return Units(R"x("parameters": { )x" + parameters + R"x( },
      "signals": { "g": { "set": "sin(7*t) > 0.5", "reset": "sin(7*t) < -0.2" }, "i": { "integral": "a*a", "initial": 0.3 } },
      "events": { "e": { "when": "c.q > 0.4", "set": { "c.q": "c.q + a", "i": "k*a" } } },
      "elements": { "s": { "kind": "Sf", "flow": "a" }, "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
                    "r": { "kind": "R", "resistance": 1 } },
      "bonds": [ { "from": "s", "to": "n" }, { "from": "n", "to": "c" }, { "from": "n", "to": "r" } ],
      "scenes": { "run": { "stop": 1 } })x");
  };
  CHECK_FALSE(counted(R"x("a": 1, "k": 2)x").report.any_given);
  const Units given = counted(R"x("a": 1, "k": { "value": 2, "unit": "1/s" })x");
  CHECK(given.codes() == "BG161");  // c.q, the integral of a flow a, has a added to it
  CHECK_THAT(given.situation(), Catch::Contains("c.q"));
}

TEST_CASE("numbers take the unit that is wanted in sums and alone, and are pure numbers beside quantities") {
  for (const char* right : {"U",
                            "U + 1",
                            "2*U",
                            "U/2 - 0.1",
                            "0.1",
                            "0.1*sin(200*pi*t)",
                            "5*t",
                            "2*t^2 + 1",
                            "5*sin(omega*t)",
                            "if(t > T, 5, 0)",
                            "if(t > 1, U, 0)",
                            "max(U, 3)",
                            "5*step(t - T)",
                            "U*(1 - exp(-t/T))",
                            "5*(1 - exp(-t/0.1))",
                            "U*sin(omega*t + 1)",
                            "sin(3*t)",
                            "U*t/T",
                            "sqrt(U^2 + 1)",
                            "U^n/U",
                            "U*2^n",
                            "hypot(U, 0.1)",
                            "der(U*t)",
                            "U*atan2(U, 2*U)",
                            "U*floor(t/T)",
                            "U*round(t/T) + U*ceil(2.5)",
                            "mod(U, 0.1)",
                            "5*mod(t, 0.2)",
                            "U*mod(t, T)/T",
                            "U*asinh(U/U)",
                            "cbrt(U^3)",
                            "ssqrt(U, 1)*sqrt(U)",
                            "abs(-U)",
                            "U*sign(T)",
                            "T*U/(T + 1)"}) {
    INFO(right);
    CHECK(with_effort(right) == "");
  }
  for (const char* wrong : {"T",
                            "2*T",
                            "U*T",
                            "U + T",
                            "U*sin(T)",
                            "U*exp(t)*sin(U)",
                            "sin(omega*t)",
                            "U*sin(omega)",
                            "if(t > U, U, 0)",
                            "if(t > T, U, T)",
                            "max(U, T)",
                            "U*t",
                            "sqrt(U)",
                            "U^n",
                            "t",
                            "der(U*t/T)",
                            "U*n^T",
                            "U*floor(T)",
                            "U*ceil(T)",
                            "U*round(U)",
                            "mod(T, 1)",
                            "mod(U, T)",
                            "U*log1p(U)",
                            "hypot(U, T)",
                            "ssqrt(U, T)*sqrt(U)",
                            "U*log(U)",
                            "U*atan2(U, T)",
                            "U + sin(omega*t)*T",
                            "exp(t/T)*T",
                            "U*2^T"}) {
    INFO(wrong);
    CHECK(with_effort(wrong) == "BG161");
  }
}

TEST_CASE("an integral has the unit of its rate times a second") {
  const auto units = [](const std::string& x, const std::string& scene = R"("stop": 1)") {
    return Units(R"x("parameters": { "U": { "value": 2, "unit": "V" }, "T": { "value": 3, "unit": "s" } },
      "signals": { "x": )x" +
                     x + R"x( },
      "elements": { "source": { "kind": "MSe", "effort": "U" }, "loop": { "kind": "1" },
        "r": { "kind": "R", "resistance": 1 } },
      "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" } ],
      "outputs": { "x": "x", "rate": "der(x)" }, "scenes": { "main": { )x" +
                     scene + " } }",
                 "main");
  };
  const Units plain = units(R"({ "integral": "U" })");
  CHECK(plain.codes().empty());
  CHECK(plain.output("x") == "Wb");
  CHECK(plain.output("rate") == "V");
  CHECK(units(R"({ "integral": "U", "unit": "V s", "initial": "U*T" })").codes().empty());
  CHECK(units(R"({ "integral": "1" , "unit": "m" })").codes().empty());
  CHECK(units(R"({ "integral": "U", "unit": "V" })").codes() == "BG161");
  CHECK(units(R"({ "integral": "U", "initial": "U" })").codes() == "BG161");
  CHECK(units(R"({ "integral": "U + x" })").codes() == "BG161");
  CHECK(units(R"({ "integral": "U - x/T" })").codes().empty());
  CHECK(units(R"({ "integral": "U" })", R"("stop": 1, "initial": { "x": "U*T" })").codes().empty());
  CHECK(units(R"({ "integral": "U" })", R"("stop": 1, "initial": { "x": "T" })").codes() == "BG161");
  CHECK(units(R"({ "integral": "U" })", R"("stop": "3*T", "times": ["T", "2*T"])").codes().empty());
  CHECK(units(R"({ "integral": "U" })", R"("stop": "3*T", "times": ["T", "U*T"])").codes() == "BG161");
  CHECK(units(R"({ "integral": "U" })", R"("stop": "3*T", "samples": { "log": 3, "from": "U" })").codes() == "BG161");
}

TEST_CASE("every kind of element is held to its law") {
  const auto codes = [](const std::string& resistor, const std::string& store, const std::string& parameter) {
    return Units(circuit(R"("U": { "value": 1, "unit": "V" }, "x": { "value": 1, "unit": ")" + parameter + R"(" })",
                         "U", resistor, store, R"("i": { "value": "loop.f", "unit": "A" })"))
        .codes();
  };
  const std::string r = R"("kind": "R", "resistance": 1)", c = R"("kind": "C", "capacitance": 1)";
  CHECK(codes(R"("kind": "R", "resistance": "x")", c, "Ohm").empty());
  CHECK(codes(R"("kind": "R", "resistance": "x")", c, "S") == "BG161");
  CHECK(codes(R"("kind": "R", "resistance": "x")", c, "kOhm") == "BG162");
  CHECK(codes(R"("kind": "MR", "law": "f = e^3/x")", c, "V^3/A").empty());
  CHECK(codes(R"("kind": "MR", "law": "f = e^3/x")", c, "V^2/A") == "BG161");
  CHECK(codes(r, R"("kind": "C", "capacitance": "x")", "F").empty());
  CHECK(codes(r, R"("kind": "C", "capacitance": "x")", "uF") == "BG162");
  CHECK(codes(r, R"("kind": "C", "law": "e = q/x")", "H") == "BG161");
  CHECK(codes(r, R"("kind": "I", "inertance": "x")", "H").empty());
  CHECK(codes(r, R"("kind": "I", "inertance": "x")", "F") == "BG161");
  CHECK(codes(r, R"("kind": "I", "inertance": 1, "initial": { "p": "x" })", "Wb").empty());
  CHECK(codes(r, R"("kind": "I", "inertance": 1, "initial": { "p": "x" })", "V") == "BG161");
}

TEST_CASE("transformers, gyrators and fields carry units from one domain to the next") {
  const auto two_port = [](const std::string& kind, const std::string& unit) {
    return Units(R"("parameters": { "U": { "value": 1, "unit": "V" }, "R": { "value": 1, "unit": "Ohm" },
                                    "k": { "value": 1, "unit": ")" +
                 unit + R"(" } },
      "elements": { "s": { "kind": "Se", "effort": "U" }, "l": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
                    "x": { "kind": ")" +
                 kind + R"(", "modulus": "k" }, "j": { "kind": "1" }, "m": { "kind": "R", "resistance": 1 },
                    "c": { "kind": "C", "capacitance": 1 } },
      "bonds": [ { "from": "s", "to": "l" }, { "from": "l", "to": "r" }, { "from": "l", "to": "x" }, { "from": "x", "to": "j" },
                 { "from": "j", "to": "m" }, { "from": "j", "to": "c" } ],
      "outputs": { "e": "m.e", "f": "m.f" })");
  };
  const Units motor = two_port("GY", "V s/m");
  CHECK(motor.codes().empty());
  CHECK(motor.output("e") == "N");
  CHECK(motor.output("f") == "m/s");
  const Units shaft = two_port("GY", "V s/rad");
  REQUIRE(shaft.report.regions.size() == 2);
  CHECK(shaft.report.regions[1].effort.text == "N m");
  CHECK(shaft.report.regions[1].flow.text == "rad/s");
  const Units plate = two_port("TF", "V/N");
  CHECK(plate.output("e") == "N");
  CHECK(plate.output("f") == "m/s");

  const auto field = [](const std::string& k) {
    return Units(R"("parameters": { "k": { "value": 1, "unit": ")" + k + R"(" }, "d": { "value": 1, "unit": "m" },
                                    "eps": { "value": 1, "unit": "F m" } },
      "elements": { "plates": { "kind": "CC", "ports": ["wire", "gap"], "energy": "wire.q^2*(d + gap.q)/(2*eps) + k*gap.q^2/2" },
                    "r": { "kind": "R", "resistance": 1 }, "m": { "kind": "I", "inertance": 1 } },
      "bonds": [ { "from": "r", "to": "plates.wire" }, { "from": "m", "to": "plates.gap" } ],
      "outputs": { "u": "plates.wire.e", "F": "plates.gap.e", "q": "plates.wire.q" })");
  };
  const Units plates = field("N/m");
  CHECK(plates.codes().empty());
  CHECK(plates.output("u") == "V");
  CHECK(plates.output("F") == "N");
  CHECK(plates.output("q") == "C");
}

TEST_CASE("a column of data has one unit wherever it is used, and so has what it is tabulated over") {
  const std::string table = "table('" BGSIM_SOURCE_DIR "/tests/errors/data.csv', 'u', ";
  const auto codes = [&](const std::string& argument, const std::string& factor) {
    return Units(circuit(R"("T": { "value": 1, "unit": "s" }, "U": { "value": 1, "unit": "V" })", table + "t)",
                         R"("kind": "R", "resistance": 1)", R"("kind": "C", "capacitance": 1)",
                         R"("u": { "value": "source.e", "unit": "V" }, "v": { "value": ")" + factor + table + argument +
                             R"x()", "unit": "V" })x"))
        .codes();
  };
  CHECK(codes("t", "").empty());
  CHECK(codes("T", "").empty());
  CHECK(codes("U", "") == "BG161");
  CHECK(codes("t", "T*") == "BG161");
}

TEST_CASE("the shipped models contradict themselves only where the paper does") {
  // Eq. 1 (orifice) and Eq. 2 (C2) of the paper with the units of its table.
  const std::set<std::string> literal{"actuator",         "actuator_masses", "bellow",
                                      "bellow_paper_eq3", "bellow_parts",    "packet"};
  for (const auto& file : std::filesystem::directory_iterator(BGSIM_SOURCE_DIR "/models")) {
    if (file.path().extension() != ".json") continue;
    INFO(file.path().string());
    const Model model = read_model(file.path().string());
    const std::vector<Diagnostic> problems = unit_problems(model, build_bond_graph(model));
    if (!literal.contains(file.path().stem().string())) {
      CHECK(problems.empty());
      continue;
    }
    REQUIRE(problems.size() == 2);
    CHECK(problems[0].situation.find("C2\" is in m^3/Pa, but its value") != std::string::npos);
    CHECK(problems[0].help.find("kg/mol, a molar mass") != std::string::npos);
    CHECK(problems[1].situation.find("orifice.f is in m^3/s, but") != std::string::npos);
    CHECK(problems[1].situation.find("is in m Pa^0.5") != std::string::npos);
  }
}

TEST_CASE("a scene's values take the place of the model's") {
  for (const auto& [name, literal] : {std::pair("bellow", "tracking"), std::pair("actuator", "bending")}) {
    INFO(name);
    const Model model = read_model(std::string(BGSIM_SOURCE_DIR "/models/") + name + ".json");
    const BondGraph graph = build_bond_graph(model);
    CHECK_FALSE(infer_units(model, graph, literal).problems.empty());
    CHECK(infer_units(model, graph, "physical").problems.empty());  // there both equations are sound
  }
}

namespace {

/// Whether anything depends on a parameter, other parameters between.
bool uses(const Model& model, SymbolId parameter) {
  std::vector<ExprId> roots;
  for (const Element& element : model.elements) {
    roots.insert(roots.end(), {element.coefficient, element.energy});
    for (const Law& law : element.laws) roots.push_back(law.right);
    if (element.switches) roots.insert(roots.end(), {element.switches->closes, element.switches->opens});
    if (element.diode) roots.push_back(element.diode->fire);
    if (element.contact) roots.push_back(element.contact->restitution);
    for (const InitialValue& initial : element.initial) roots.push_back(initial.value);
  }
  for (const Signal& signal : model.signals) {
    roots.insert(roots.end(), {signal.value, signal.initial});
    if (signal.delay) roots.insert(roots.end(), {signal.delay->value, signal.delay->by});
  }
  for (const ModelEvent& event : model.events) {
    roots.push_back(event.when);
    for (const ModelEvent::Set& set : event.sets) roots.push_back(set.value);
  }
  for (const Output& output : model.outputs) roots.push_back(output.value);
  std::set<SymbolId> seen;
  while (true) {
    std::erase_if(roots, [](ExprId root) { return !root.valid(); });
    const std::size_t before = seen.size();
    for (const SymbolId symbol : symbols_in(model.pool, roots)) seen.insert(symbol);
    if (seen.contains(parameter)) return true;
    if (seen.size() == before) return false;
    for (const Parameter& other : model.parameters)
      if (seen.contains(other.symbol)) roots.push_back(other.value);
  }
}

}  // namespace

TEST_CASE("one wrong unit in a shipped model is found wherever it is", "[long]") {
  for (const auto& file : std::filesystem::directory_iterator(BGSIM_SOURCE_DIR "/models")) {
    if (file.path().extension() != ".json") continue;
    Model model = read_model(file.path().string());
    const BondGraph graph = build_bond_graph(model);
    const std::size_t before = infer_units(model, graph).problems.size();
    if (before > 0) continue;
    for (Parameter& parameter : model.parameters) {
      // Where actuator_object gives a packet its C2 and its orifice, what the packet would compute them from is not
      // used.
      if (parameter.unit.empty() || !uses(model, parameter.symbol)) continue;
      const std::string right = std::exchange(parameter.unit, "cd (" + parameter.unit + ")");
      CHECK((infer_units(model, graph).problems.empty() ? model.name + ": " + parameter.name : "found") == "found");
      parameter.unit = "1000 (" + right + ")";
      CHECK((infer_units(model, graph).problems.empty() ? model.name + ": " + parameter.name : "found") == "found");
      parameter.unit = right;
    }
    for (Output& output : model.outputs) {
      if (output.unit.empty()) continue;
      const std::string right = std::exchange(output.unit, "cd (" + output.unit + ")");
      CHECK((infer_units(model, graph).problems.empty() ? model.name + ": " + output.name : "found") == "found");
      output.unit = right;
    }
  }
}

TEST_CASE("one wrong unit that many equations contradict is reported once, with the unit that would fit") {
  const Units c(circuit(
      R"("U": { "value": 1, "unit": "A" }, "R": { "value": 1, "unit": "Ohm" }, "C": { "value": 1, "unit": "F" })", "U",
      R"("kind": "R", "resistance": "R")", R"("kind": "C", "capacitance": "C")",
      R"("i": { "value": "loop.f", "unit": "A" }, "u": { "value": "store.e", "unit": "V" })"));
  REQUIRE(c.codes() == "BG161");
  CHECK(c.situation() == "parameter \"U\" is in A, which 3 equations contradict");
  CHECK(c.report.problems.front().help == "all of them hold if it is in V");
}

TEST_CASE("units of a long model take time in proportion", "[long]") {
  const auto seconds = [](std::size_t cells, bool with_units) {
    std::string elements = R"("s": { "kind": "Se", "effort": "U" }, "j0": { "kind": "1" })",
                bonds = R"({ "from": "s", "to": "j0" })";
    for (std::size_t i = 0; i < cells; ++i) {
      const std::string n = std::to_string(i), next = std::to_string(i + 1);
      elements += ", \"r" + n + R"(": { "kind": "R", "resistance": "R" }, "k)" + n + R"(": { "kind": "0" }, "c)" + n +
                  R"(": { "kind": "C", "law": "e = q/C + q^3/D" }, "x)" + n +
                  R"(": { "kind": "TF", "modulus": "n" }, "j)" + next + R"(": { "kind": "1" })";
      bonds += ", { \"from\": \"j" + n + R"(", "to": "r)" + n + "\" }, { \"from\": \"j" + n + R"(", "to": "k)" + n +
               "\" }, { \"from\": \"k" + n + R"(", "to": "c)" + n + "\" }, { \"from\": \"k" + n + R"(", "to": "x)" + n +
               "\" }, { \"from\": \"x" + n + R"(", "to": "j)" + next + "\" }";
    }
    const std::string ohm = with_units ? R"({ "value": 1, "unit": "Ohm" })" : "1";
    const Model model = read_model_text(
        "ladder.json", R"({ "bgsim": 1, "name": "ladder", "parameters": { "U": { "value": 1, "unit": "V" }, "R": )" +
                           ohm + R"(, "C": 1, "D": 1, "n": 2 }, "elements": { )" + elements + R"( }, "bonds": [ )" +
                           bonds + " ] }");
    const BondGraph graph = build_bond_graph(model);
    const std::clock_t begin = std::clock();
    const UnitReport report = infer_units(model, graph);
    CHECK(report.problems.empty());
    CHECK(report.complete);
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  };
  // Ten times the cells in less than forty times the time: a quadratic method needs a hundred times.
  for (const bool with_units : {true, false}) CHECK(seconds(3000, with_units) < 40.0 * seconds(300, with_units) + 0.05);
}
