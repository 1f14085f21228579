// Variational equations across changes of the mode: switches, diodes, contacts and their impacts, against closed forms
// and against differences of runs.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/held_capacitor.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

SensitivityTable forward(const Study& study, const std::vector<std::string>& to,
                         SensitivityNorm norm = SensitivityNorm::final, double relative = 1e-11) {
  return sensitivities(study, "", with_relative(relative), to, norm);
}

/// The errors of a run at 1e-11, and what a jump's differences are known to (run/mode_variation: 1e-9 of the sizes).
constexpr double kWithin = 1e-8;

void check(const SensitivityTable& table, std::size_t output, const std::vector<double>& exact,
           double within = kWithin) {
  for (std::size_t p = 0; p < exact.size(); ++p) {
    INFO(table.outputs[output] << " by " << table.parameters[p]);
    const double size = std::abs(table.values[output] / table.parameter_values[p]);
    CHECK(std::abs(table.of[output][p].derivative - exact[p]) <= within * std::max(std::abs(exact[p]), size));
  }
}

}  // namespace

TEST_CASE("the derivative of what a switch cuts off follows its instant") {
  const HeldCapacitor held;
  const Study study = held.study();
  check(forward(study, held.parameters), 0, held.derivatives());
  // The mean over the scene: what is held counts for the rest of it.
  const double tau = held.R * held.C, e = held.rest(), last = held.U * (1 - e);
  const SensitivityTable mean = forward(study, {"a"}, SensitivityNorm::mean);
  CHECK(mean.values[0] == Approx(held.U * (held.a - tau * (1 - e)) + last * (1 - held.a)).epsilon(1e-9));
  check(mean, 0, {held.U * e / tau * (1 - held.a)});
}

TEST_CASE("stores that a switch ties to each other take their derivatives along") {
  // C1 loses its charge through R until a; then C2 takes its part: u = (C1 u1 exp(-a/(R C1)) + C2 u2)/(C1 + C2), which
  // goes on falling with R (C1 + C2).
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "tied", "parameters": { "C1": 0.5, "C2": 0.8, "R": 3, "a": 0.6, "u1": 2, "u2": -0.4 },
    "elements": { "n": { "kind": "0" }, "c1": { "kind": "C", "capacitance": "C1", "initial": { "e": "u1" } },
      "r": { "kind": "R", "resistance": "R" }, "way": { "kind": "1" }, "k": { "kind": "Sw", "closed": "t >= a" },
      "c2": { "kind": "C", "capacitance": "C2", "initial": { "e": "u2" } } },
    "bonds": [ { "from": "n", "to": "c1" }, { "from": "n", "to": "r" }, { "from": "n", "to": "way" },
      { "from": "way", "to": "k" }, { "from": "way", "to": "c2" } ],
    "outputs": { "u": "n.e" }, "scenes": { "run": { "stop": 1.5, "samples": 3 } } })x");
  const auto u = [](double C1, double C2, double R, double a, double u1, double u2) {
    return (C1 * u1 * std::exp(-a / (R * C1)) + C2 * u2) / (C1 + C2) * std::exp(-(1.5 - a) / (R * (C1 + C2)));
  };
  const std::vector<double> p = {0.5, 0.8, 3, 0.6, 2, -0.4};
  std::vector<double> exact;
  for (std::size_t i = 0; i < p.size(); ++i) {
    // Of a smooth closed form by differences of the eighth order: 1e-11 of it.
    double slope = 0.0;
    const double weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280}, h = 1e-2 * std::abs(p[i]);
    for (int k = 1; k <= 4; ++k)
      for (const int side : {1, -1}) {
        std::vector<double> q = p;
        q[i] += side * k * h;
        slope += side * weights[k - 1] / h * u(q[0], q[1], q[2], q[3], q[4], q[5]);
      }
    exact.push_back(slope);
  }
  check(forward(study, {"C1", "C2", "R", "a", "u1", "u2"}), 0, exact);
}

TEST_CASE("a peak detector's diode blocks at an instant that depends on the parameters") {
  // Ideal: the capacitor follows V sin(w t) until the diode's current is zero, at w t1 = pi - atan(w R C), then
  // u = V sin(w t1) exp(-(t - t1)/(R C)), whose derivative by t1 is zero.
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "peak", "parameters": { "V": 5, "w": 2, "R": 4, "C": 0.7 },
    "elements": { "s": { "kind": "MSe", "effort": "V*sin(w*t)" }, "way": { "kind": "1" }, "d": { "kind": "D" },
      "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": "C" }, "r": { "kind": "R", "resistance": "R" } },
    "bonds": [ { "from": "s", "to": "way" }, { "from": "way", "to": "d" }, { "from": "way", "to": "n" },
      { "from": "n", "to": "c" }, { "from": "n", "to": "r" } ],
    "outputs": { "u": "n.e" }, "scenes": { "run": { "stop": 2, "samples": 3 } } })x");
  const double V = 5, w = 2, R = 4, C = 0.7, pi = std::acos(-1.0);
  const double t1 = (pi - std::atan(w * R * C)) / w, fall = std::exp(-(2 - t1) / (R * C));
  const double u = V * std::sin(w * t1) * fall;
  const SensitivityTable table = forward(study, {"V", "w", "R", "C"});
  CHECK(table.values[0] == Approx(u).epsilon(1e-9));
  check(table, 0, {u / V, V * t1 * std::cos(w * t1) * fall, u * (2 - t1) / (R * R * C), u * (2 - t1) / (R * C * C)});
}

TEST_CASE("a ball that rebounds at a contact, and one that hits another") {
  // v = e v0 - g (t - t1), v0 = sqrt(2 g h), t1 = sqrt(2 h/g).
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "ball", "parameters": { "m": 0.2, "g": 9.81, "h": 1, "e": 0.7 },
    "elements": { "fall": { "kind": "1" }, "ball": { "kind": "I", "inertance": "m" },
      "weight": { "kind": "Se", "effort": "m*g" },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": "-h" }, "restitution": "e" } },
    "bonds": [ { "from": "weight", "to": "fall" }, { "from": "fall", "to": "ball" }, { "from": "fall", "to": "ground" } ],
    "outputs": { "v": "-ball.f" }, "scenes": { "run": { "stop": 0.9, "samples": 3 } } })x");
  const double g = 9.81, h = 1, e = 0.7, stop = 0.9, t1 = std::sqrt(2 * h / g), v0 = g * t1;
  const SensitivityTable table = forward(study, {"h", "g", "e"});
  CHECK(table.values[0] == Approx(e * v0 - g * (stop - t1)).epsilon(1e-9));
  // dv0/dh = g/v0, dt1/dh = 1/v0; dv0/dg = h/v0, dt1/dg = -t1/(2 g).
  check(table, 0, {(e + 1) * g / v0, e * h / v0 - (stop - t1) - t1 / 2, v0});

  // Two masses: the first, at v, hits the second, at rest 0.3 in front of it; momentum and restitution give both
  // speeds.
  const Study pair = Study::from_text(
      R"x({ "bgsim": 1, "name": "pair", "parameters": { "m1": 2, "m2": 3, "v": 1.5, "e": 0.6, "room": 0.3 },
    "signals": { "x2": { "integral": "b2.f" } },
    "elements": { "b1": { "kind": "1" }, "one": { "kind": "I", "inertance": "m1", "initial": { "f": "v" } },
      "b2": { "kind": "1" }, "other": { "kind": "I", "inertance": "m2" }, "between": { "kind": "0" },
      "hit": { "kind": "contact", "gap": "room", "restitution": "e" } },
    "bonds": [ { "from": "b1", "to": "one" }, { "from": "b2", "to": "other" }, { "from": "b1", "to": "between" },
      { "from": "between", "to": "b2" }, { "from": "between", "to": "hit" } ],
    "outputs": { "x2": "x2", "v1": "b1.f" }, "scenes": { "run": { "stop": 1, "samples": 3 } } })x");
  const double m1 = 2, m2 = 3, v = 1.5, r = 0.6, room = 0.3, m = m1 + m2, after = m1 * v * (1 + r) / m;
  const SensitivityTable both = forward(pair, {"m1", "m2", "v", "e", "room"});
  const double time = 1 - room / v;
  CHECK(both.values[0] == Approx(after * time).epsilon(1e-9));
  check(both, 0,
        {v * (1 + r) * m2 / (m * m) * time, -after / m * time, after / v * time + after * room / (v * v),
         m1 * v / m * time, -after / v});
  check(both, 1, {v * (1 + r) * m2 / (m * m), -v * m1 * (1 + r) / (m * m), (m1 - r * m2) / m, -v * m2 / m, 0.0});
}

TEST_CASE("conditions on their borders after a change of the mode are on the side that the run takes") {
  // When a block starts to slide its speed is still 0, and its friction has the sign of the speed just after. With the
  // sign 0 the rates after the change were those of a block without friction, and derivatives five times too large.
  const Study study = study_of("models/stick_slip.json");
  const std::vector<std::string> to = {"Fs", "k", "v0", "Fd", "m"};
  const SensitivityTable table = forward(study, to),
                         other = difference_sensitivities(study, "", {}, to, SensitivityNorm::final);
  for (std::size_t p = 0; p < to.size(); ++p) {
    INFO(to[p]);
    // The other way is known to that.
    CHECK(std::abs(table.of[0][p].derivative - other.of[0][p].derivative) <=
          1e-7 * std::abs(table.of[0][p].derivative) + 2.0 * other.of[0][p].error);
  }
}

TEST_CASE("an event at the instant of a switch has the instant of that switch") {
  // At the time at which u comes to a the switch closes, and what is set depends on that time.
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "event", "parameters": { "a": 0.8, "C": 0.5, "R": 1.3, "k": 0.4 },
    "signals": { "n": { "integral": "c.e" } },
    "elements": { "u": { "kind": "Se", "effort": 2 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
      "o": { "kind": "0" }, "c": { "kind": "C", "capacitance": "C" }, "w": { "kind": "1" },
      "s": { "kind": "Sw", "close": "c.e > a", "open": "c.e < 0" }, "load": { "kind": "R", "resistance": 0.2 } },
    "events": { "tick": { "when": "c.e > a", "set": { "n": "k*pre(n) + t" } } },
    "bonds": [ { "from": "u", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "o" },
      { "from": "o", "to": "c" }, { "from": "o", "to": "w" }, { "from": "w", "to": "s" },
      { "from": "w", "to": "load" } ],
    "outputs": { "u": "c.e", "n": "n" }, "scenes": { "s": { "stop": 1.1, "samples": 3 } } })x");
  const std::vector<std::string> to = {"a", "C", "R", "k"};
  const SensitivityTable table = forward(study, to),
                         other = difference_sensitivities(study, "", {}, to, SensitivityNorm::final);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t p = 0; p < to.size(); ++p) {
      INFO(table.outputs[i] << " by " << to[p]);
      // The other way is known to that.
      CHECK(std::abs(table.of[i][p].derivative - other.of[i][p].derivative) <=
            1e-7 * std::abs(table.of[i][p].derivative) + 2.0 * other.of[i][p].error);
    }
  CHECK(std::abs(table.of[1][0].derivative) > 0.1);
}

TEST_CASE("variational equations over modes agree with differences of runs", "[long]") {
  struct Case {
    const char *file, *scene;
    std::vector<std::string> to;
    SensitivityNorm norm;
  };
  for (const Case& each : {Case{"buck", "start_up", {"duty", "L", "C", "Rl"}, SensitivityNorm::mean},
                           Case{"boost", "start_up", {"duty", "L", "C"}, SensitivityNorm::final},
                           Case{"water_hammer", "closure", {"t_shut", "L", "R"}, SensitivityNorm::final},
                           Case{"gripper", "cycle", {"t_vent", "A", "K", "grip"}, SensitivityNorm::final},
                           Case{"thyristor_bridge", "late", {"alpha"}, SensitivityNorm::rms},
                           Case{"relief_valve", "pumping", {"p_open", "p_shut", "Q"}, SensitivityNorm::final}}) {
    const Study study = study_of(std::string("models/") + each.file + ".json");
    const SensitivityTable table = sensitivities(study, each.scene, with_relative(1e-10), each.to, each.norm),
                           other = difference_sensitivities(study, each.scene, {}, each.to, each.norm);
    for (std::size_t i = 0; i < table.outputs.size(); ++i)
      for (std::size_t p = 0; p < each.to.size(); ++p) {
        INFO(each.file << ": " << table.outputs[i] << " by " << each.to[p]);
        const double size = table.parameter_values[p] == 0.0 ? 0.0 : table.values[i] / table.parameter_values[p];
        // Both at 1e-10; differences over a thousandth of the parameter, extrapolated (differences_test.cpp).
        CHECK(std::abs(table.of[i][p].derivative - other.of[i][p].derivative) <=
              1e-6 * std::max(std::abs(size), std::abs(table.of[i][p].derivative)) + 2.0 * other.of[i][p].error);
      }
  }
}

namespace {

/// A ball that comes to rest, beside y' = cos(w t) - c y, which it does not know.
std::string resting_ball(const std::string& restitution, double e) {
  return R"x({ "bgsim": 1, "name": "resting", "parameters": { "g": 9.81, "h": 1, "m": 0.2, "w": 3, "c": 0.5, "e": )x" +
         std::to_string(e) + R"x( },
    "signals": { "rest": { "integral": "if(mode('ground'), 1, 0)" }, "path": { "integral": "abs(ball.f)" },
      "y": { "integral": "cos(w*t) - c*y", "initial": 1 }, "z": { "integral": "if(mode('ground'), y, 0)" } },
    "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": "m" },
      "weight": { "kind": "Se", "effort": "m*g" },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": "-h" }, "restitution": ")x" +
         restitution + R"x(" } },
    "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "ground" } ],
    "outputs": { "rest": "rest", "path": "path", "y": "y", "z": "z", "q": "ground.q", "force": "ground.e" },
    "scenes": { "s": { "stop": 60, "samples": 3 } } })x";
}

}  // namespace

TEST_CASE("derivatives go on behind infinitely many impacts", "[long]") {
  const double g = 9.81, h = 1, w = 3, c = 0.5, first = std::sqrt(2 * h / g);
  for (const double e : {0.01, 0.3, 0.7, 0.9}) {
    INFO("restitution " << e);
    const double end = first * (1 + e) / (1 - e), by_e = 2 * first / ((1 - e) * (1 - e));
    const double a = c / (c * c + w * w), b = w / (c * c + w * w);
    const double y = (1 - a) * std::exp(-c * end) + a * std::cos(w * end) + b * std::sin(w * end);
    const SensitivityTable table = forward(Study::from_text(resting_ball("e", e)), {"e", "g", "h"});
    CHECK(table.values[0] == Approx(60 - end).epsilon(1e-10));
    check(table, 0, {-by_e, end / (2 * g), -end / (2 * h)});
    check(table, 1, {4 * h * e / ((1 - e * e) * (1 - e * e)), 0, (1 + e * e) / (1 - e * e)});
    check(table, 2, {0, 0, 0});
    // The end is 2e-6 of the longest flight over 1 - e away, and what goes on there is known to the second order of
    // that.
    check(table, 3, {-y * by_e, y * end / (2 * g), -y * end / (2 * h)}, 3 * kWithin);
    check(table, 5, {0, 0.2, 0});
    for (const OutputSensitivity& of : table.of[4]) CHECK(std::abs(of.derivative) < 1e-15);  // 0, to rounding of h
  }
}

TEST_CASE("what follows a contact where its impacts end has the derivatives of that instant") {
  // A capacitor is charged through a switch that closes there: u = 1 - exp(-(s - T)/(R C)), and a latch lets go a
  // clock.
  const double e = 0.6, g = 9.81, end = std::sqrt(2 / g) * (1 + e) / (1 - e), stop = 3, tau = 0.5 * 1.2;
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "follows", "parameters": { "g": 9.81, "e": 0.6, "C": 1.2 },
    "signals": { "lit": { "set": "mode('ground')", "reset": "t < 0", "initial": false },
      "clock": { "integral": "if(lit, t, 0)" } },
    "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
      "weight": { "kind": "Se", "effort": "g" },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": -1 }, "restitution": "e" },
      "one": { "kind": "Se", "effort": 1 }, "way": { "kind": "1" }, "r": { "kind": "R", "resistance": 0.5 },
      "gate": { "kind": "Sw", "closed": "mode('ground')" }, "c": { "kind": "C", "capacitance": "C" } },
    "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "ground" },
      { "from": "one", "to": "way" }, { "from": "way", "to": "r" }, { "from": "way", "to": "gate" },
      { "from": "way", "to": "c" } ],
    "outputs": { "u": "c.e", "clock": "clock" }, "scenes": { "s": { "stop": 3, "samples": 3 } } })x");
  const SensitivityTable table = forward(study, {"e", "g", "C"});
  const double left = std::exp(-(stop - end) / tau);
  const double by_e = 2 * std::sqrt(2 / g) / ((1 - e) * (1 - e)), by_g = -end / (2 * g);
  CHECK(table.values[0] == Approx(1 - left).epsilon(1e-9));
  CHECK(table.values[1] == Approx(0.5 * (stop * stop - end * end)).epsilon(1e-9));
  check(table, 0, {-left / tau * by_e, -left / tau * by_g, -left * (stop - end) / (tau * 1.2)});
  check(table, 1, {-end * by_e, -end * by_g, 0});
}

TEST_CASE("derivatives behind infinitely many impacts are those of differences", "[long]") {
  // With masses on both sides, a wall that moves, and a restitution that depends on the speed.
  const std::string plate = R"x({ "bgsim": 1, "name": "plate",
    "parameters": { "g": 9.81, "h": 0.3, "e": 0.5, "m": 0.2, "M": 1, "k": 100, "d": 0.8 },
    "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": "m" },
      "weight": { "kind": "Se", "effort": "m*g" }, "between": { "kind": "0" },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": "-h" }, "restitution": "e" },
      "plate": { "kind": "1" }, "body": { "kind": "I", "inertance": "M" }, "spring": { "kind": "C", "capacitance": "1/k" },
      "damper": { "kind": "R", "resistance": "d" } },
    "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "between" },
      { "from": "between", "to": "ground" }, { "from": "between", "to": "plate" }, { "from": "plate", "to": "body" },
      { "from": "plate", "to": "spring" }, { "from": "plate", "to": "damper" } ],
    "outputs": { "v": "ball.f", "x": "spring.q", "F": "ground.e" }, "scenes": { "s": { "stop": 3, "samples": 3 } } })x";
  std::string table = resting_ball("e", 0.5), soft = resting_ball("e/(1 + 0.1*f)", 0.7);
  const auto put = [](std::string& text, const std::string& from, const std::string& to) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  };
  put(table, "\"gap\": 0", "\"gap\": \"0.02*sin(w*t)\"");
  put(table, "\"stop\": 60", "\"stop\": 3");
  put(soft, "\"stop\": 60", "\"stop\": 3");
  struct Case {
    std::string text;
    std::vector<std::string> to;
    std::size_t outputs;
  };
  for (const Case& each :
       {Case{plate, {"e", "g", "k", "M", "d"}, 3}, Case{table, {"e", "g", "w"}, 6}, Case{soft, {"e", "h", "g"}, 6}}) {
    const Study study = Study::from_text(each.text);
    const SensitivityTable own = forward(study, each.to),
                           other = difference_sensitivities(study, "", {}, each.to, SensitivityNorm::final);
    REQUIRE(own.outputs.size() == each.outputs);
    for (std::size_t i = 0; i < each.outputs; ++i)
      for (std::size_t p = 0; p < each.to.size(); ++p) {
        INFO(own.outputs[i] << " by " << each.to[p]);
        const double size = std::abs(own.values[i] / own.parameter_values[p]);
        // The run that differences are of closes the contact up to 2e-6 of the longest flight early. Beside the wall q
        // is 0, to rounding of the height.
        CHECK(std::abs(own.of[i][p].derivative - other.of[i][p].derivative) <=
              2e-6 * std::max(size, std::abs(own.of[i][p].derivative)) + 2.0 * other.of[i][p].error + 1e-15);
      }
  }
}

TEST_CASE("contacts that close together do so by one limit") {
  // Two balls that do the same: each rests as one alone does.
  const std::string one = R"x("ball%": { "kind": "1" }, "mass%": { "kind": "I", "inertance": 0.2 },
      "weight%": { "kind": "Se", "effort": "0.2*g" },
      "ground%": { "kind": "contact", "gap": 0, "initial": { "q": "-h" }, "restitution": "e" })x",
                    bonds = R"x({ "from": "weight%", "to": "ball%" }, { "from": "ball%", "to": "mass%" },
      { "from": "ball%", "to": "ground%" })x";
  const auto of = [](std::string text, const char* name) {
    for (auto at = text.find('%'); at != std::string::npos; at = text.find('%')) text.replace(at, 1, name);
    return text;
  };
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "two", "parameters": { "g": 9.81, "h": 1, "e": 0.7 },
    "signals": { "a": { "integral": "if(mode('grounda'), 1, 0)" }, "b": { "integral": "if(mode('groundb'), t, 0)" } },
    "elements": { )x" +
      of(one, "a") + ", " + of(one, "b") + R"x( }, "bonds": [ )x" + of(bonds, "a") + ", " + of(bonds, "b") +
      R"x( ], "outputs": { "a": "a", "b": "b" }, "scenes": { "s": { "stop": 3, "samples": 3 } } })x");
  const double e = 0.7, first = std::sqrt(2 / 9.81), end = first * (1 + e) / (1 - e);
  const double by_e = 2 * first / ((1 - e) * (1 - e)), by_h = end / 2;
  const SensitivityTable table = forward(study, {"e", "h"});
  check(table, 0, {-by_e, -by_h});
  check(table, 1, {-end * by_e, -end * by_h});
}

TEST_CASE("what has no derivative over a change of the mode is refused") {
  const auto refusal = [](const Study& study, const std::vector<std::string>& to) {
    try {
      forward(study, to);
    } catch (const ModelError& error) {
      return render(error);
    }
    return std::string();
  };
  // Another switch changes between the last of infinitely many impacts, at 2.5586312: too few are in one mode.
  const Study between = Study::from_text(
      R"x({ "bgsim": 1, "name": "between", "parameters": { "e": 0.7 },
    "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
      "weight": { "kind": "Se", "effort": 9.81 },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": -1 }, "restitution": "e" },
      "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "k": { "kind": "Sw", "closed": "t > 2.55863" } },
    "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "ground" },
      { "from": "c", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "k" } ],
    "outputs": { "q": "ground.q", "u": "c.e" }, "scenes": { "s": { "stop": 3, "samples": 3 } } })x");
  CHECK_THAT(refusal(between, {"e"}), Contains("BG414") &&
                                          Contains("the impacts of \"ground\" accumulate, and it closes") &&
                                          Contains("--method differences"));
  // A contact that does not rebound: with a restitution above 0 its impacts end later, and there is none below.
  const auto landing = [](const std::string& restitution) {
    return Study::from_text(
        R"x({ "bgsim": 1, "name": "landing", "parameters": { "e": 0, "g": 10 },
    "signals": { "clock": { "integral": "if(mode('ground'), 1, 0)" } },
    "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
      "weight": { "kind": "Se", "effort": "g" },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": -1 }, "restitution": ")x" +
        restitution + R"x(" } },
    "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "ground" } ],
    "outputs": { "clock": "clock" }, "scenes": { "s": { "stop": 2, "samples": 3 } } })x");
  };
  for (const char* restitution : {"e", "e*f/(1 + f)", "max(e, 0)^2 + 3*e"})
    CHECK_THAT(refusal(landing(restitution), {"e"}),
               Contains("BG414") && Contains("\"ground\" does not rebound, and would with another value"));
  check(forward(landing("e"), {"g"}), 0, {0.5 * std::sqrt(0.2) / 10});  // of 2 - sqrt(2/g)
  // A condition whose instant is the end of the scene: an integral that grows from there on, or not at all.
  const Study end = Study::from_text(
      R"x({ "bgsim": 1, "name": "end", "parameters": { "a": 2, "b": 3 },
    "signals": { "x": { "integral": "if(t > a, b, 0)" } },
    "elements": { "c": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "c", "to": "r" } ],
    "outputs": { "x": "x" }, "scenes": { "s": { "stop": 2, "samples": 3 } } })x");
  CHECK_THAT(refusal(end, {"a"}), Contains("BG414") && Contains("event at the end of the run") &&
                                      Contains("by 0 on one side of it and by -3 on the other"));
  CHECK(refusal(end, {"b"}).empty());
  // Of several conditions at the end any one may be the one that matters.
  const Study several = Study::from_text(
      R"x({ "bgsim": 1, "name": "several", "parameters": { "a": 2 },
    "signals": { "y": { "integral": "if(t > 2*a - 2, 1, 0)" }, "x": { "integral": "if(t > a, 3, 0)" } },
    "elements": { "c": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "c", "to": "r" } ],
    "outputs": { "y": "y", "x": "x" }, "scenes": { "s": { "stop": 2, "samples": 3 } } })x");
  CHECK_THAT(refusal(several, {"a"}), Contains("\"y\" changes with \"a\" by 0 on one side of it and by -2"));
  // The same of a switch, which is on its other side from then on.
  const Study late = Study::from_text(
      R"x({ "bgsim": 1, "name": "late", "parameters": { "a": 2 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "k": { "kind": "Sw", "closed": "t > a" }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "k" }, { "from": "j", "to": "r" },
      { "from": "j", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 2, "samples": 3 } } })x");
  CHECK_THAT(refusal(late, {"a"}), Contains("BG414") && Contains("event at the end of the run"));
  CHECK(forward(late, {"a"}, SensitivityNorm::mean).of[0][0].derivative == 0.0);
  // A diode at its border as the scene begins, which this parameter takes across; and one that another one keeps.
  const Study border = Study::from_text(
      R"x({ "bgsim": 1, "name": "border", "parameters": { "V": 0, "R": 2 },
    "elements": { "u": { "kind": "Se", "effort": "V" }, "j": { "kind": "1" }, "d": { "kind": "D" },
      "r": { "kind": "R", "resistance": "R" }, "c": { "kind": "C", "capacitance": 0.5 } },
    "bonds": [ { "from": "u", "to": "j" }, { "from": "j", "to": "d" }, { "from": "j", "to": "r" },
      { "from": "j", "to": "c" } ],
    "outputs": { "u": "c.e" }, "scenes": { "s": { "stop": 1, "samples": 3 } } })x");
  CHECK_THAT(refusal(border, {"V"}), Contains("BG414") && Contains("at its border as the scene begins"));
  CHECK(refusal(border, {"R"}).empty());
  // A contact that touches: on one side of that it is inside of the wall.
  const Study touch = Study::from_text(
      R"x({ "bgsim": 1, "name": "touch", "parameters": { "x0": 0, "f": 1 },
    "elements": { "u": { "kind": "Se", "effort": "f" }, "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
      "w": { "kind": "contact", "gap": 0, "initial": { "q": "x0" }, "restitution": 0.5 } },
    "bonds": [ { "from": "u", "to": "j" }, { "from": "j", "to": "m" }, { "from": "j", "to": "w" } ],
    "outputs": { "x": "w.q" }, "scenes": { "s": { "stop": 1, "samples": 3 } } })x");
  CHECK_THAT(refusal(touch, {"x0"}), Contains("BG414") && Contains("at its border as the scene begins"));
  // Two switches at one instant, of which another value of the parameter moves one.
  const Study two = Study::from_text(
      R"x({ "bgsim": 1, "name": "two", "parameters": { "a": 0.5, "b": 0.5, "R": 2 },
    "elements": { "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
      "w1": { "kind": "1" }, "k1": { "kind": "Sw", "closed": "t > a" }, "r1": { "kind": "R", "resistance": 1 },
      "w2": { "kind": "1" }, "k2": { "kind": "Sw", "closed": "t > b" }, "r2": { "kind": "R", "resistance": "R" } },
    "bonds": [ { "from": "n", "to": "c" }, { "from": "n", "to": "w1" }, { "from": "w1", "to": "k1" },
      { "from": "w1", "to": "r1" }, { "from": "n", "to": "w2" }, { "from": "w2", "to": "k2" },
      { "from": "w2", "to": "r2" } ],
    "outputs": { "u": "n.e" }, "scenes": { "run": { "stop": 1, "samples": 3 } } })x");
  CHECK_THAT(refusal(two, {"a"}), Contains("BG414") && Contains("that another value of the parameter parts"));
  // By R both stay where they are: u = exp(-(1 + 1/R)/2).
  check(forward(two, {"R"}), 0, {std::exp(-0.75) / 8.0});
}
