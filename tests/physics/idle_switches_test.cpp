// Switches that set what others set already: open in series, closed in parallel; and what such diodes leave indefinite.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// @param bonds  "a>b c>d"
std::string model_of(const std::string& elements, const std::string& bonds, const std::string& outputs,
                     const std::string& signals = "") {
  std::string list;
  for (std::size_t at = 0; at < bonds.size();) {
    const std::size_t end = std::min(bonds.find(' ', at), bonds.size()), arrow = bonds.find('>', at);
    list += std::string(list.empty() ? "" : ", ") + R"({"from": ")" + bonds.substr(at, arrow - at) + R"(", "to": ")" +
            bonds.substr(arrow + 1, end - arrow - 1) + "\"}";
    at = end + 1;
  }
  return R"({"bgsim": 1, "name": "idle", "signals": {)" + signals + R"(}, "elements": {)" + elements +
         R"(}, "bonds": [)" + list + R"(], "outputs": {)" + outputs +
         R"(}, "scenes": {"run": {"stop": 5, "samples": 41, "relative": 1e-9}}})";
}

RunResult completed(const std::string& text) {
  const RunResult result = Study::from_text(text).scene().simulate();
  INFO((result.failure ? result.failure->code + " " + result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

std::string notes_of(const RunResult& result) {
  std::string all;
  for (const std::string& note : result.report.notes) all += note + "\n";
  return all;
}

std::string code_of(const std::string& text) {
  const RunResult result = Study::from_text(text).scene().simulate();
  return result.failure ? result.failure->code : "";
}

void check_same(const RunResult& one, const RunResult& other) {
  REQUIRE(one.trace.columns.size() == other.trace.columns.size());
  for (std::size_t k = 0; k < one.trace.columns.size(); ++k) {
    INFO(one.trace.names[k]);
    // The same equations in both, but the changes of more conditions are stepped to: both are within the tolerance of
    // 1e-9 of values of some units.
    CHECK(largest_difference(one.trace.columns[k], other.trace.columns[k]) < 1e-8);
  }
}

const std::string kSource = R"x("u": {"kind": "Se", "effort": "2*cos(3*t)"}, "j": {"kind": "1"},
    "r": {"kind": "R", "resistance": 0.5}, "c": {"kind": "C", "capacitance": 0.4, "initial": {"e": 1}})x";
const std::string kOutputs = R"("v": "c.e", "i": "r.f")";

}  // namespace

TEST_CASE("switches in series are one that is closed while all of them are") {
  const std::string one = model_of(kSource + R"(, "s": {"kind": "Sw", "closed": "sin(2*t) > -0.3 and sin(5*t) > 0"})",
                                   "u>j j>r j>c j>s", kOutputs);
  const std::string two = model_of(
      kSource + R"(, "a": {"kind": "Sw", "closed": "sin(2*t) > -0.3"}, "b": {"kind": "Sw", "closed": "sin(5*t) > 0"})",
      "u>j j>r j>c j>a j>b", kOutputs);
  const RunResult single = completed(one), both = completed(two);
  check_same(single, both);
  CHECK(both.report.mode_changes > single.report.mode_changes);
  CHECK(notes_of(both).empty());
  // the same beyond a transformer, and with a third one
  check_same(
      single,
      completed(model_of(
          kSource +
              R"(, "a": {"kind": "Sw", "closed": "sin(2*t) > -0.3"}, "b": {"kind": "Sw", "closed": "sin(5*t) > 0"},
                                      "tf": {"kind": "TF", "modulus": 3}, "k": {"kind": "1"}, "d": {"kind": "Sw", "closed": "sin(5*t) > 0"})",
          "u>j j>r j>c j>a j>tf tf>k k>b k>d", kOutputs)));
}

TEST_CASE("switches in parallel are one that is open while all of them are") {
  const std::string parts = kSource + R"(, "n": {"kind": "0"}, "leak": {"kind": "R", "resistance": 2})";
  const std::string bonds = "u>j j>r j>c j>n n>leak ";
  const std::string one =
      model_of(parts + R"(, "s": {"kind": "Sw", "closed": "sin(2*t) > 0.3 or sin(5*t) > 0"})", bonds + "n>s", kOutputs);
  const std::string two = model_of(
      parts + R"(, "a": {"kind": "Sw", "closed": "sin(2*t) > 0.3"}, "b": {"kind": "Sw", "closed": "sin(5*t) > 0"})",
      bonds + "n>a n>b", kOutputs);
  const RunResult both = completed(two);
  check_same(completed(one), both);
  CHECK(notes_of(both).empty());
}

TEST_CASE("three capacitors at a node that switches cut off keep their charge, and share it where they meet") {
  // s1 closes at 1, s2 at 2, s3 at 3; all open at 4. Charge is conserved at each meeting.
  std::string elements = R"("n": {"kind": "0"})", bonds, outputs;
  const double capacitance[] = {1, 2, 3}, start[] = {6, 3, 1};
  for (int k = 0; k < 3; ++k) {
    const std::string i = std::to_string(k + 1);
    elements += R"(, "j)" + i + R"(": {"kind": "1"}, "c)" + i + R"(": {"kind": "C", "capacitance": )" +
                std::to_string(capacitance[k]) + R"(, "initial": {"e": )" + std::to_string(start[k]) + R"(}}, "s)" + i +
                R"(": {"kind": "Sw", "closed": "t > )" + i + R"( and t < 4"})";
    bonds += (k == 0 ? "" : " ") + ("c" + i + ">j" + i + " j" + i + ">s" + i + " j" + i + ">n");
    outputs += (k == 0 ? "" : ", ") + ("\"v" + i + "\": \"c" + i + ".e\"");
  }
  const RunResult run = completed(model_of(elements, bonds, outputs));
  const double two = (6 + 2 * 3) / 3.0, all = (two * 3 + 3) / 6.0;
  for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
    const double t = run.trace.times[i];
    CAPTURE(t);
    const double expected[] = {t <= 2 ? 6 : t <= 3 ? two : all, t <= 2 ? 3 : t <= 3 ? two : all, t <= 3 ? 1 : all};
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(run.trace.columns[k][i] == Approx(expected[k]).epsilon(1e-12));  // rounding
  }
}

TEST_CASE("an inverter of four switches without diodes rests while all are open") {
  // Legs of two switches in series across the source, a resistor between their middles; a tenth of dead time.
  const std::string high = "mod(t, 1) < 0.4", low = "mod(t, 1) > 0.5 and mod(t, 1) < 0.9";
  std::string elements =
      R"("u": {"kind": "Se", "effort": 10}, "dc": {"kind": "0"}, "a": {"kind": "0"}, "b": {"kind": "0"},
      "load": {"kind": "R", "resistance": 4}, "across": {"kind": "1"})";
  std::string bonds = "u>dc a>across across>load across>b";
  const auto add = [&](const std::string& name, const std::string& condition, const std::string& from,
                       const std::string& to) {
    elements += ", \"" + name + R"(": {"kind": "Sw", "closed": ")" + condition + "\"}";
    if (to.empty()) {
      bonds += " " + from + ">" + name;
      return;
    }
    elements += ", \"j_" + name + R"(": {"kind": "1"})";
    bonds += " " + from + ">j_" + name + " j_" + name + ">" + name + " j_" + name + ">" + to;
  };
  add("s1", high, "dc", "a");
  add("s2", low, "dc", "b");
  add("s3", low, "a", "");
  add("s4", high, "b", "");
  const RunResult run = completed(model_of(elements, bonds, R"("i": "load.f", "v": "a.e")"));
  for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
    const double phase = std::fmod(run.trace.times[k] + 1e-9, 1.0);
    if (std::abs(phase - 0.4) < 1e-6 || std::abs(phase - 0.5) < 1e-6 || std::abs(phase - 0.9) < 1e-6) continue;
    CHECK(run.trace.columns[0][k] == (phase < 0.4 ? 2.5 : phase > 0.5 && phase < 0.9 ? -2.5 : 0.0));
  }
  // What the load's ends are at then is anything between the rails.
  CHECK(notes_of(run).find("\"v\" is indefinite") != std::string::npos);
  CHECK(notes_of(run).find("\"i\" is indefinite") == std::string::npos);
}

TEST_CASE("two open switches in series with a diode, and a coil that they cut off") {
  const auto with = [](const std::string& switches, const std::string& more) {
    return model_of(
        R"x("u": {"kind": "Se", "effort": "3*sin(4*t)"}, "j": {"kind": "1"}, "d": {"kind": "D", "passes": "in"},
        "l": {"kind": "I", "inertance": 0.2}, "r": {"kind": "R", "resistance": 1}, )x" +
            switches,
        "u>j j>d j>l j>r " + more, R"("i": "l.f")");
  };
  check_same(
      completed(with(R"("s": {"kind": "Sw", "closed": "t > 0.5 and t < 3"})", "j>s")),
      completed(with(R"("a": {"kind": "Sw", "closed": "t > 0.5"}, "b": {"kind": "Sw", "closed": "t > 0.2 and t < 3"},
                              "c": {"kind": "Sw", "closed": "t < 3"})",
                     "j>a j>b j>c")));
}

TEST_CASE("three capacitors round which three switches close share their charge, whatever flows round the ring") {
  // The last switch closes a ring: what flows round it is indefinite, and nothing else. C a' = (3 - v)/r from then on.
  const RunResult run = completed(model_of(
      R"("u": {"kind": "Se", "effort": 3}, "in": {"kind": "1"}, "r": {"kind": "R", "resistance": 1}, "A": {"kind": "0"},
        "B": {"kind": "0"}, "C": {"kind": "0"}, "j1": {"kind": "1"}, "j2": {"kind": "1"}, "j3": {"kind": "1"},
        "s1": {"kind": "Sw", "closed": "t > 0"}, "s2": {"kind": "Sw", "closed": "t > 0"}, "s3": {"kind": "Sw", "closed": "t > 1"},
        "ca": {"kind": "C", "capacitance": 1}, "cb": {"kind": "C", "capacitance": 2}, "cc": {"kind": "C", "capacitance": 0.5})",
      "u>in in>r in>A A>ca B>cb C>cc A>j1 j1>s1 j1>B B>j2 j2>s2 j2>C C>j3 j3>s3 j3>A",
      R"("a": "ca.e", "b": "cb.e", "c": "cc.e", "round": "s3.f")"));
  for (std::size_t i = 0; i < run.trace.times.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)  // ten tolerances of 1e-9
      CHECK(run.trace.columns[k][i] == Approx(3 * (1 - std::exp(-run.trace.times[i] / 3.5))).margin(1e-8));
  CHECK(notes_of(run).find("\"round\" is indefinite") != std::string::npos);
  CHECK(notes_of(run).find("\"a\"") == std::string::npos);
}

TEST_CASE("what switches leave indefinite is refused where something depends on it") {
  // a source of flow that two open switches cut off, and a source of effort across two that are closed
  CHECK(code_of(model_of(R"("u": {"kind": "Sf", "flow": 1}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
      "a": {"kind": "Sw", "closed": "t < 1"}, "b": {"kind": "Sw", "closed": "t < 1"})",
                         "u>j j>r j>a j>b", R"("e": "r.e")")) == "BG619");
  CHECK(code_of(
            model_of(R"("u": {"kind": "Se", "effort": "t - 1"}, "n": {"kind": "0"}, "r": {"kind": "R", "resistance": 1},
      "a": {"kind": "Sw", "closed": "t > 1"}, "b": {"kind": "Sw", "closed": "t > 1"})",
                     "u>n n>r n>a n>b", R"("f": "r.f")")) == "BG619");
  // a condition that asks for the voltage between both
  CHECK(code_of(model_of(kSource + R"(, "a": {"kind": "Sw", "closed": "sin(2*t) > -0.3"},
      "b": {"kind": "Sw", "close": "b.e > 1", "open": "b.f < 0"})",
                         "u>j j>r j>c j>a j>b", kOutputs)) == "BG619");
}

TEST_CASE("what diodes leave indefinite is noted where an output shows it, and nothing else is") {
  const std::string series = R"x("u": {"kind": "Se", "effort": "sin(t)"}, "j": {"kind": "1"},
      "r": {"kind": "R", "resistance": 1}, "a": {"kind": "D"}, "b": {"kind": "D"})x";
  const std::string beside = R"x("u": {"kind": "Se", "effort": "sin(t)"}, "j": {"kind": "1"},
      "r": {"kind": "R", "resistance": 1}, "n": {"kind": "0"}, "a": {"kind": "D"}, )x";
  // Four diodes between a source and a capacitor with a leak, one end of which is the reference: between two charges
  // all of them block, and the source floats.
  const std::string bridge = R"x("u": {"kind": "Se", "effort": "sin(t)"}, "line": {"kind": "1"},
      "left": {"kind": "0"}, "right": {"kind": "0"}, "plus": {"kind": "0"}, "w1": {"kind": "1"}, "w2": {"kind": "1"},
      "w3": {"kind": "1"}, "w4": {"kind": "1"}, "d1": {"kind": "D"}, "d2": {"kind": "D"}, "d3": {"kind": "D"},
      "d4": {"kind": "D"}, "c": {"kind": "C", "capacitance": 1}, "r": {"kind": "R", "resistance": 10})x";
  const std::string wires =
      "u>line line>left right>line left>w1 w1>d1 w1>plus right>w3 w3>d3 w3>plus "
      "w2>d2 w2>left w4>d4 w4>right plus>c plus>r";
  struct Case {
    const char* what;
    std::string elements, bonds, outputs;
    std::vector<std::string> indefinite, definite;
  };
  const Case cases[] = {
      {"in series",
       series,
       "u>j j>r j>a j>b",
       R"("i": "r.f", "va": "a.e", "vb": "b.e", "both": "a.e + b.e")",
       {"va", "vb"},
       {"i", "both"}},
      {"in series, of other thresholds",
       series + R"(, "extra": {"kind": "D", "threshold": 0.1})",
       "u>j j>r j>a j>b j>extra",
       R"("i": "r.f", "v": "extra.e")",
       {"v"},
       {"i"}},
      {"in parallel",
       beside + R"("b": {"kind": "D"})",
       "u>j j>r j>n n>a n>b",
       R"("i": "r.f", "ia": "a.f", "ib": "b.f", "v": "a.e")",
       {"ia", "ib"},
       {"i", "v"}},
      {"in parallel, of other thresholds",
       beside + R"("b": {"kind": "D", "threshold": 0.1})",
       "u>j j>r j>n n>a n>b",
       R"("i": "r.f", "ia": "a.f", "ib": "b.f")",
       {},
       {"i", "ia", "ib"}},
      {"beside a switch, which carries all",
       beside + R"("b": {"kind": "Sw", "closed": "mod(t, 1) < 0.5"})",
       "u>j j>r j>n n>a n>b",
       R"("i": "r.f", "ia": "a.f", "ib": "b.f")",
       {},
       {"i", "ia", "ib"}},
      {"beside a capacitor that it empties",
       beside + R"("b": {"kind": "C", "capacitance": 0.1})",
       "u>j j>r j>n n>a n>b",
       R"("i": "r.f", "ia": "a.f", "v": "a.e")",
       {},
       {"i", "ia", "v"}},
      {"a bridge on a capacitor",
       bridge,
       wires,
       R"("v": "c.e", "i": "u.f", "v1": "d1.e", "i1": "d1.f", "at": "left.e", "across": "left.e - right.e")",
       {"v1", "at"},
       {"v", "i", "i1", "across"}},
  };
  for (const Case& each : cases) {
    INFO(each.what);
    const std::string notes = notes_of(completed(model_of(each.elements, each.bonds, each.outputs)));
    CAPTURE(notes);
    std::string named = notes.substr(0, notes.find("indefinite"));
    if (notes.find("indefinite") == std::string::npos) named.clear();
    for (const std::string& name : each.indefinite) CHECK(named.find("\"" + name + "\"") != std::string::npos);
    for (const std::string& name : each.definite) CHECK(named.find("\"" + name + "\"") == std::string::npos);
  }
}

TEST_CASE("a model with another fault is not blamed for switches that are open in series as it is read") {
  std::string codes;
  try {
    Study::from_text(
        model_of(kSource + R"(, "a": {"kind": "Sw", "closed": "t > 1"}, "b": {"kind": "Sw", "closed": "t > 2"})",
                 "u>j j>r j>c j>a j>b", R"("v": "nothing.e")"));
  } catch (const ModelError& error) {
    for (const Diagnostic& fault : error.diagnostics) codes += fault.code + " ";
  }
  CHECK(codes == "BG121 ");
}

TEST_CASE("a mode with idle switches is listed as allowed, and shown") {
  const Study study = Study::from_text(
      model_of(kSource + R"(, "a": {"kind": "Sw", "closed": "t > 1"}, "b": {"kind": "Sw", "closed": "t > 2"})",
               "u>j j>r j>c j>a j>b", kOutputs));
  const std::string modes = describe_modes(study.model(), study.graph());
  INFO(modes);
  CHECK(modes.find("4, of which the graph allows 4") != std::string::npos);
  CHECK(modes.find("\"b\" idle") != std::string::npos);
  const Study open = study.in_mode({false, false});
  CHECK(mode_of(open.model()) == Mode{false, false});
  CHECK(open.model().elements.back().idle);
  CHECK_FALSE(study.in_mode({true, false}).model().elements.back().idle);
}

TEST_CASE("a diode beside laws that the searches for loops' solutions try") {
  // The look for what diodes leave indefinite met a symbol that only a search had used, and read past its list.
  const RunResult run = Study::from_text(R"j({ "bgsim": 1, "name": "main", "elements": {
      "s": { "kind": "Se", "effort": 5 }, "line": { "kind": "1" },
      "r": { "kind": "R", "law": "0 = f/sqrt(e) + 2*log10(0.01 + 0.3/sqrt(e))" }, "fork": { "kind": "0" },
      "a": { "kind": "1" }, "ra": { "kind": "R", "law": "0 = f/sqrt(e) + 2*log10(0.02 + 0.2/sqrt(e))" },
      "b": { "kind": "1" }, "rb": { "kind": "R", "law": "0 = f/sqrt(e) + 2*log10(0.03 + 0.1/sqrt(e))" },
      "tank": { "kind": "C", "capacitance": 2 }, "n": { "kind": "0" }, "extra": { "kind": "D" } },
    "bonds": [ { "from": "s", "to": "line" }, { "from": "line", "to": "r" }, { "from": "line", "to": "fork" },
      { "from": "fork", "to": "a" }, { "from": "a", "to": "ra" }, { "from": "a", "to": "n" },
      { "from": "fork", "to": "b" }, { "from": "b", "to": "rb" }, { "from": "b", "to": "n" },
      { "from": "n", "to": "tank" }, { "from": "b", "to": "extra" } ],
    "outputs": { "q": "tank.q", "fa": "a.f", "fb": "b.f", "e": "fork.e" }, "scenes": { "main": { "stop": 0.1, "samples": 2 } } })j")
                            .scene()
                            .simulate();
  CHECK(run.stop == StopReason::completed);
}
