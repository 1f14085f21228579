#include "families.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <stdexcept>
#include <utility>

namespace bgsim::bench {

namespace {

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// A model while it is being put together.
class Draft {
 public:
  explicit Draft(std::uint32_t seed) : random_(seed) {}

  /// Between @p low and @p high, by the logarithm.
  double spread(double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0.0, 1.0)(random_));
  }
  std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_); }

  void add(const std::string& name, const std::string& kind, const std::string& rest = {}) {
    elements_ += (elements_.empty() ? "\"" : ", \"") + name + R"(": { "kind": ")" + kind + '"' +
                 (rest.empty() ? "" : ", " + rest) + " }";
  }
  void add_with(const std::string& name, const std::string& kind, const char* key, double value) {
    add(name, kind, std::string("\"") + key + "\": " + number(value));
  }
  void tie(const std::string& from, const std::string& to) {
    bonds_ += (bonds_.empty() ? R"({ "from": ")" : R"(, { "from": ")") + from + R"(", "to": ")" + to + "\" }";
  }
  void signal(const std::string& name, const std::string& value) {
    signals_ += (signals_.empty() ? "\"" : ", \"") + name + "\": " + value;
  }
  void output(const std::string& name, const std::string& value) {
    outputs_ += (outputs_.empty() ? "\"" : ", \"") + name + R"(": ")" + value + '"';
  }
  std::string text(const std::string& name, double stop, std::size_t samples = 101) const {
    return R"({ "bgsim": 1, "name": ")" + name + R"(", "signals": { )" + signals_ + R"( }, "elements": { )" +
           elements_ + R"( }, "bonds": [ )" + bonds_ + R"( ], "outputs": { )" + outputs_ +
           R"( }, "scenes": { "run": { "stop": )" + number(stop) + R"(, "samples": )" + std::to_string(samples) +
           " } } }";
  }

 private:
  std::mt19937 random_;
  std::string signals_, elements_, bonds_, outputs_;
};

std::string at(const char* name, std::size_t i) { return name + std::to_string(i); }

/// Masses in a row, each on a spring to the one before and with a damper to the ground. @p spring, @p damper and
/// @p more add what is between and beside them.
void add_masses(Draft& draft, std::size_t masses, const std::function<void(std::size_t)>& spring,
                const std::function<void(std::size_t)>& damper) {
  std::string before = "wall";
  for (std::size_t i = 0; i < masses; ++i) {
    draft.add(at("link", i), "0");
    draft.add(at("at", i), "1");
    spring(i);
    draft.add_with(at("m", i), "I", "inertance", draft.spread(0.5, 2.0));
    damper(i);
    for (const auto& [from, to] : {std::pair{before, at("link", i)}, std::pair{at("link", i), at("spring", i)},
                                   std::pair{at("link", i), at("at", i)}, std::pair{at("at", i), at("m", i)},
                                   std::pair{at("at", i), at("r", i)}})
      draft.tie(from, to);
    before = at("at", i);
  }
  draft.output("v", at("at", masses / 2) + ".f");
  draft.output("last", at("at", masses - 1) + ".f");
  draft.output("first", "spring0.e");
}

/// Nodes with capacities in a row.
void add_nodes(Draft& draft, std::size_t nodes, const std::function<void(std::size_t)>& between, double unlike) {
  std::string before = "source";
  for (std::size_t i = 0; i < nodes; ++i) {
    draft.add(at("loop", i), "1");
    draft.add(at("node", i), "0");
    between(i);
    draft.add_with(at("C", i), "C", "capacitance", draft.spread(1.0 / unlike, unlike));
    for (const auto& [from, to] : {std::pair{before, at("loop", i)}, std::pair{at("loop", i), at("R", i)},
                                   std::pair{at("loop", i), at("node", i)}, std::pair{at("node", i), at("C", i)}})
      draft.tie(from, to);
    before = at("node", i);
  }
  draft.output("u", at("node", nodes / 2) + ".e");
  draft.output("last", at("node", nodes - 1) + ".e");
  draft.output("i", "R0.f");
}

std::string sine(Draft& draft, const char* key, double slow, double fast) {
  return std::string("\"") + key + "\": \"" + number(draft.spread(0.5, 2.0)) + "*sin(" +
         number(draft.spread(slow, fast)) + "*t)\"";
}

std::string ladder(Draft& draft, std::size_t states) {
  draft.add("source", "Se", sine(draft, "effort", 0.3, 3.0));
  add_nodes(
      draft, states, [&](std::size_t i) { draft.add_with(at("R", i), "R", "resistance", draft.spread(0.03, 3.0)); },
      30.0);
  return draft.text("ladder", 20.0);
}

/// Conductances that grow with the temperature, and radiation.
std::string heat(Draft& draft, std::size_t states) {
  draft.add("source", "Se", R"-("effort": "1 + if(t < 1, t, 1)")-");
  add_nodes(
      draft, states,
      [&](std::size_t i) {
        const std::string g = number(draft.spread(0.3, 300.0));
        draft.add(at("R", i), "R", R"("law": "f = )" + g + "*(e + e^3)\"");
      },
      10.0);
  return draft.text("heat", 20.0);
}

/// Coils in line, so that it rings.
std::string line(Draft& draft, std::size_t states) {
  draft.add("source", "Se", R"-("effort": "if(t < 0.5, sin(6.283185307179586*t)^2, 0)")-");
  add_nodes(
      draft, (states + 1) / 2,
      [&](std::size_t i) {
        draft.add_with(at("R", i), "R", "resistance", draft.spread(1e-3, 1e-2));
        draft.add_with(at("L", i), "I", "inertance", draft.spread(0.05, 0.2));
        draft.tie(at("loop", i), at("L", i));
      },
      2.0);
  return draft.text("line", 20.0);
}

std::string chain(Draft& draft, std::size_t states) {
  draft.add("wall", "Sf", sine(draft, "flow", 0.3, 3.0));
  add_masses(
      draft, (states + 1) / 2,
      [&](std::size_t i) {
        draft.add(at("spring", i), "C", R"("law": "e = )" + number(draft.spread(0.5, 2.0)) + "*q + q^3\"");
      },
      [&](std::size_t i) { draft.add_with(at("r", i), "R", "resistance", draft.spread(1e-3, 1e-1)); });
  return draft.text("chain", 40.0);
}

/// Springs and dampers of all sizes between the masses.
std::string train(Draft& draft, std::size_t states) {
  draft.add("wall", "Sf", sine(draft, "flow", 0.3, 3.0));
  add_masses(
      draft, (states + 1) / 2,
      [&](std::size_t i) { draft.add_with(at("spring", i), "C", "capacitance", draft.spread(1e-5, 1.0)); },
      [&](std::size_t i) { draft.add_with(at("r", i), "R", "resistance", draft.spread(1e-2, 1e3)); });
  return draft.text("train", 40.0);
}

/// Springs that only push, over gaps.
std::string gaps(Draft& draft, std::size_t states) {
  draft.add("wall", "Sf", sine(draft, "flow", 0.5, 2.0));
  add_masses(
      draft, (states + 1) / 2,
      [&](std::size_t i) {
        const std::string k = number(draft.spread(10.0, 1000.0)), gap = number(draft.spread(0.03, 0.3));
        const std::string own = i % 3 == 0 ? "if(q > " + gap + ", " + k + "*(q - " + gap + "), 0) + q" : "q";
        draft.add(at("spring", i), "C", R"("law": "e = )" + own + "\"");
      },
      [&](std::size_t i) { draft.add_with(at("r", i), "R", "resistance", draft.spread(3e-2, 1.0)); });
  return draft.text("gaps", 20.0);
}

/// Friction that is smoothed.
std::string friction(Draft& draft, std::size_t states) {
  draft.add("wall", "Sf", sine(draft, "flow", 0.5, 2.0));
  add_masses(
      draft, (states + 1) / 2,
      [&](std::size_t i) { draft.add_with(at("spring", i), "C", "capacitance", draft.spread(0.1, 1.0)); },
      [&](std::size_t i) {
        draft.add(at("r", i), "R",
                  R"("law": "e = )" + number(draft.spread(0.05, 0.5)) + "*tanh(f/" + number(draft.spread(1e-3, 1e-2)) +
                      ") + 0.05*f\"");
      });
  return draft.text("friction", 20.0);
}

/// A plane of nodes, some of which are tied by coils.
std::string plane(Draft& draft, std::size_t states) {
  const auto side = std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(std::sqrt(double(states) / 1.3))));
  draft.add("source", "Se", sine(draft, "effort", 0.3, 3.0));
  draft.add("inlet", "1");
  draft.add_with("feed", "R", "resistance", 0.5);
  draft.tie("source", "inlet");
  draft.tie("inlet", "feed");
  draft.tie("inlet", "node0");
  for (std::size_t i = 0; i < side * side; ++i) {
    draft.add(at("node", i), "0");
    draft.add_with(at("C", i), "C", "capacitance", draft.spread(0.1, 10.0));
    draft.tie(at("node", i), at("C", i));
    for (const std::size_t step : {std::size_t{1}, side}) {
      if (step == 1 ? i % side + 1 == side : i + side >= side * side) continue;
      const std::string name = "way" + std::to_string(i) + "_" + std::to_string(step);
      draft.add(name, "1");
      draft.add_with("R" + name, "R", "resistance", draft.spread(0.01, 1.0));
      draft.tie(at("node", i), name);
      draft.tie(name, "R" + name);
      draft.tie(name, at("node", i + step));
      if (draft.below(6) != 0) continue;
      draft.add_with("L" + name, "I", "inertance", draft.spread(0.01, 1.0));
      draft.tie(name, "L" + name);
    }
  }
  draft.output("u", at("node", side * side / 2) + ".e");
  draft.output("last", at("node", side * side - 1) + ".e");
  return draft.text("plane", 20.0);
}

/// All stores at one node that holds nothing: each depends on each.
std::string star(Draft& draft, std::size_t states) {
  draft.add("source", "Se", sine(draft, "effort", 0.3, 3.0));
  draft.add("inlet", "1");
  draft.add_with("feed", "R", "resistance", 0.5);
  draft.add("hub", "0");
  draft.tie("source", "inlet");
  draft.tie("inlet", "feed");
  draft.tie("inlet", "hub");
  for (std::size_t i = 0; i < states; ++i) {
    draft.add(at("arm", i), "1");
    draft.add_with(at("R", i), "R", "resistance", draft.spread(0.03, 3.0));
    draft.add_with(at("C", i), "C", "capacitance", draft.spread(0.03, 3.0));
    draft.tie("hub", at("arm", i));
    draft.tie(at("arm", i), at("R", i));
    draft.tie(at("arm", i), at("C", i));
  }
  draft.output("u", "hub.e");
  draft.output("last", at("C", states - 1) + ".e");
  return draft.text("star", 20.0);
}

/// A chain under a controller that takes samples.
std::string sampled(Draft& draft, std::size_t states) {
  draft.signal("seen", R"({ "value": "v0", "every": 0.25 })");
  draft.signal("wanted", R"-({ "value": "2*(1 - seen)", "every": 0.25 })-");
  draft.signal("v0", "\"m0.f\"");
  draft.add("motor", "MSe", R"("effort": "wanted")");
  draft.add("wall", "Sf", R"("flow": 0)");
  draft.tie("motor", "at0");
  add_masses(
      draft, (states + 1) / 2,
      [&](std::size_t i) { draft.add_with(at("spring", i), "C", "capacitance", draft.spread(0.05, 1.0)); },
      [&](std::size_t i) { draft.add_with(at("r", i), "R", "resistance", draft.spread(0.05, 1.0)); });
  return draft.text("sampled", 20.0);
}

/// A source that a switch chops, a freewheeling diode, and a filter of coils and capacities.
std::string chopper(Draft& draft, std::size_t states) {
  draft.signal("phase", R"-("t/0.5 - floor(t/0.5)")-");
  draft.add("supply", "Se", R"("effort": 10)");
  draft.add("in", "1");
  draft.add("chop", "Sw", R"("closed": "phase < 0.6")");
  draft.add("source", "0");
  draft.add("free", "D", R"("passes": "out")");
  draft.tie("supply", "in");
  draft.tie("in", "chop");
  draft.tie("in", "source");
  draft.tie("source", "free");
  add_nodes(
      draft, (states + 1) / 2,
      [&](std::size_t i) {
        draft.add_with(at("R", i), "R", "resistance", draft.spread(0.01, 1.0));
        draft.add_with(at("L", i), "I", "inertance", draft.spread(0.02, 0.5));
        draft.tie(at("loop", i), at("L", i));
      },
      5.0);
  draft.add_with("load", "R", "resistance", draft.spread(1.0, 10.0));
  draft.tie(at("node", (states + 1) / 2 - 1), "load");
  return draft.text("chopper", 20.0);
}

/// Masses of which one is now and then clutched to a drive.
std::string clutch(Draft& draft, std::size_t states) {
  draft.add("drive", "Se", R"-("effort": "3*sin(0.7*t)")-");
  draft.add("shaft", "1");
  draft.add_with("rotor", "I", "inertance", 0.5);
  draft.add_with("bearing", "R", "resistance", 0.3);
  draft.add("slip", "0");
  draft.add("disk", "Sw", R"("closed": "sin(2*t) > 0")");
  draft.add("joint", "1");
  draft.add_with("lining", "R", "resistance", 2.0);
  draft.add("wall", "Sf", R"("flow": 0)");
  draft.tie("drive", "shaft");
  draft.tie("shaft", "rotor");
  draft.tie("shaft", "bearing");
  draft.tie("shaft", "slip");
  draft.tie("slip", "joint");
  draft.tie("joint", "disk");
  draft.tie("joint", "lining");
  draft.tie("slip", "at0");
  add_masses(
      draft, std::max<std::size_t>(1, states / 2),
      [&](std::size_t i) { draft.add_with(at("spring", i), "C", "capacitance", draft.spread(1e-3, 1.0)); },
      [&](std::size_t i) { draft.add_with(at("r", i), "R", "resistance", draft.spread(0.03, 1.0)); });
  return draft.text("clutch", 20.0);
}

using Maker = std::string (*)(Draft&, std::size_t);
const std::vector<std::pair<std::string, Maker>>& makers() {
  static const std::vector<std::pair<std::string, Maker>> all{
      {"ladder", ladder}, {"heat", heat},       {"line", line},         {"chain", chain},
      {"train", train},   {"gaps", gaps},       {"friction", friction}, {"plane", plane},
      {"star", star},     {"sampled", sampled}, {"chopper", chopper},   {"clutch", clutch}};
  return all;
}

}  // namespace

const std::vector<std::string>& family_names() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> names;
    for (const auto& [name, maker] : makers()) names.push_back(name);
    return names;
  }();
  return all;
}

std::string family_model(const std::string& family, std::size_t states, std::uint32_t seed) {
  Draft draft(seed * 1000U + static_cast<std::uint32_t>(states));
  for (const auto& [name, maker] : makers())
    if (name == family) return maker(draft, states);
  throw std::invalid_argument("no family " + family);
}

}  // namespace bgsim::bench
