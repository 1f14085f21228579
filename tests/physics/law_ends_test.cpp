// Laws that end somewhere: where a store runs empty, or where no flow is too small for them.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

/// A capacitor of 1 F and 1 C that is emptied by f = e^power as long as e > 0.
std::string emptied_by(const std::string& power) {
  return R"x({"bgsim": 1, "name": "emptied",
    "elements": {"c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "n": {"kind": "0"},
                 "r": {"kind": "R", "law": "f = if(e > 0, e^()x" +
         power + R"x(), 0)"}},
    "bonds": [{"from": "n", "to": "c"}, {"from": "n", "to": "r"}],
    "scenes": {"s": {"stop": 4, "samples": 201}}, "outputs": {"q": "c.q"}})x";
}

}  // namespace

TEST_CASE("a store whose law ends where it is empty stays empty, by every method") {
  // q' = -q^a: q = (1 - (1 - a) t)^(1/(1 - a)) until that is 0. The rates beyond are no numbers, so no step gets there
  // before the condition has changed. An error of the tolerance, 1e-6, grows to a hundred times of it where a < 0.
  for (const double power : {0.5, 0.3, -0.2})
    for (const Method method : {Method::bdf, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
      INFO(power << ' ' << method_name(method));
      const RunResult run = run_text(emptied_by(std::to_string(power)), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
        const double left = std::max(0.0, 1.0 - (1.0 - power) * run.trace.times[k]);
        const double limit = left > 0.0 ? 1e-4 : 1e-5;  // what is left in the end is some tolerances
        CHECK(std::abs(run.trace["q"][k] - std::pow(left, 1.0 / (1.0 - power))) < limit);
      }
    }
}

TEST_CASE("a tank from which a pump draws beyond empty goes on, however its orifice is written, by every method") {
  // q' = -0.2 - sqrt(q) with u = sqrt(q): t = 2 (1 - u) - 0.4 log(1.2/(u + 0.2)), and from u = 0 on q' = -0.2. The
  // orifice's slope is infinite where the tank is empty, and the rate is not 0 there.
  const auto when = [](double u) { return 2.0 * (1.0 - u) - 0.4 * std::log(1.2 / (u + 0.2)); };
  for (const std::string law : {"if(e > 0, sqrt(e), 0)", "sqrt(max(e, 0))", "max(0, e)^0.5", "sqrt(if(e > 0, e, 0))"})
    for (const Method method :
         {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
      INFO(law << ' ' << method_name(method));
      const RunResult run = run_text(R"x({"bgsim": 1, "name": "pumped",
        "elements": {"c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "n": {"kind": "0"},
                     "r": {"kind": "R", "law": "f = )x" +
                                         law + R"x("}, "pump": {"kind": "Sf", "flow": -0.2}},
        "bonds": [{"from": "n", "to": "c"}, {"from": "n", "to": "r"}, {"from": "pump", "to": "n"}],
        "scenes": {"s": {"stop": 6, "samples": 201}}, "outputs": {"q": "c.q"}})x",
                                     with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
        const double t = run.trace.times[k], q = run.trace["q"][k], u = std::sqrt(std::max(q, 0.0));
        const double error = t < when(0.0) ? (t - when(u)) * (0.2 + u) : q + 0.2 * (t - when(0.0));
        CHECK(std::abs(error) < 1e-4);  // a hundred tolerances in some fifty steps
      }
    }
}

TEST_CASE("two tanks whose pipe is a root on each side come to one level and leave it, by every method") {
  // d' = Q - 2 k sqrt(d) for the difference d = h1 - h2, k = 0.3: with s = sqrt(d), s = 1 - k t until that is 0. From t
  // = 5 on a pump of Q = 0.1 fills the first tank: 2 s s' = Q - 2 k s.
  constexpr double k = 0.3, q = 0.1;
  const auto since = [](double s) { return -(s + q / (2.0 * k) * std::log1p(-2.0 * k * s / q)) / k; };
  for (const std::string law : {"if(e > 0, 0.3*sqrt(e), -0.3*sqrt(-e))", "if(e >= 0, 0.3*sqrt(e), -0.3*sqrt(-e))",
                                "if(e < 0, -0.3*(-e)^0.5, 0.3*e^0.5)", "if(-e > 0, -0.3*sqrt(-e), 0.3*sqrt(e))"})
    for (const Method method :
         {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
      INFO(law << ' ' << method_name(method));
      const RunResult run = run_text(R"x({"bgsim": 1, "name": "tanks",
        "elements": {"a": {"kind": "0"}, "b": {"kind": "0"}, "l": {"kind": "1"}, "pipe": {"kind": "R", "law": "f = )x" +
                                         law + R"x("},
                     "one": {"kind": "C", "capacitance": 1, "initial": {"q": 2}},
                     "two": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
                     "pump": {"kind": "Sf", "flow": "if(t < 5, 0, 0.1)"}},
        "bonds": [{"from": "a", "to": "one"}, {"from": "b", "to": "two"}, {"from": "a", "to": "l"}, {"from": "l", "to": "b"},
                  {"from": "l", "to": "pipe"}, {"from": "pump", "to": "a"}],
        "scenes": {"s": {"stop": 8, "samples": 161}}, "outputs": {"d": "one.e - two.e"}})x",
                                     with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
        const double t = run.trace.times[i], d = run.trace["d"][i], s = std::sqrt(std::max(d, 0.0));
        const double rest = std::pow(std::max(0.0, 1.0 - k * t), 2);
        const double error = t <= 5.0 ? d - rest : (t - 5.0 - since(s)) * (q - 2.0 * k * s);
        CHECK(std::abs(error) < 1e-4);  // a hundred tolerances
      }
    }
}

TEST_CASE("a relay whose law ends at its border is held there while it is asked for less than it lets through") {
  // 1 F and 1.5 F; a pump of 0.31 sin(t) into the second one. From t = 2 pi to 3 pi it gives, and -1 is more than is
  // needed: both are level. The steps of Radau IIA came ever nearer to the border, and never there.
  for (const Method method :
       {Method::automatic, Method::radau, Method::bdf, Method::adams, Method::dirk3, Method::dirk4, Method::dirk5}) {
    INFO(method_name(method));
    const RunResult run = run_text(R"x({"bgsim": 1, "name": "relay",
        "elements": {"a": {"kind": "0"}, "b": {"kind": "0"}, "j": {"kind": "1"}, "pump": {"kind": "Sf", "flow": "0.31*sin(t)"},
                     "one": {"kind": "C", "capacitance": 1, "initial": {"e": 2}},
                     "two": {"kind": "C", "capacitance": 1.5, "initial": {"e": 1}},
                     "relay": {"kind": "R", "law": "f = if(e > 0, sqrt(e), -1)"}},
        "bonds": [{"from": "pump", "to": "b"}, {"from": "a", "to": "one"}, {"from": "a", "to": "j"}, {"from": "j", "to": "relay"},
                  {"from": "j", "to": "b"}, {"from": "b", "to": "two"}],
        "scenes": {"s": {"stop": 10, "samples": 101}}, "outputs": {"one": "one.e", "two": "two.e"}})x",
                                   with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 65; k < 94; ++k) {
      const double level = (3.5 + 0.31 * (1.0 - std::cos(run.trace.times[k]))) / 2.5;
      CHECK(std::abs(run.trace["one"][k] - level) < 1e-4);  // fifty tolerances: it is held some beside the border
      CHECK(std::abs(run.trace["two"][k] - level) < 1e-4);
    }
  }
}

TEST_CASE("a chamber that starts level with what it breathes from runs") {
  // C u' = k sqrt(|p - u|) sign(p - u) against the same law written with sign and abs, at a tolerance a thousand times
  // smaller. At the start both laws end.
  const auto chamber = [](const std::string& law) {
    return R"x({"bgsim": 1, "name": "chamber",
      "elements": {"p": {"kind": "Se", "effort": "5*sin(0.6*t)"}, "j": {"kind": "1"}, "n": {"kind": "0"},
                   "hole": {"kind": "R", "law": "f = )x" +
           law + R"x("}, "c": {"kind": "C", "capacitance": 0.15}},
      "bonds": [{"from": "p", "to": "j"}, {"from": "j", "to": "hole"}, {"from": "j", "to": "n"}, {"from": "n", "to": "c"}],
      "scenes": {"s": {"stop": 12, "samples": 121}}, "outputs": {"u": "c.e"}})x";
  };
  const RunResult exact = run_text(chamber("0.4*sign(e)*sqrt(abs(e))"), with_method(Method::bdf, 1e-9));
  REQUIRE(exact.stop == StopReason::completed);
  for (const Method method :
       {Method::automatic, Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    INFO(method_name(method));
    const RunResult run = run_text(chamber("if(e > 0, 0.4*sqrt(e), -0.4*sqrt(-e))"), with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t i = 0; i < run.trace.times.size(); ++i)
      CHECK(std::abs(run.trace["u"][i] - exact.trace["u"][i]) < 5e-4);  // a hundred tolerances of 5
  }
}

TEST_CASE("a loop starts whose law is no number at no flow, and whose condition waits for its solution") {
  // 10 + t = f + log(f - 3) + 1, where f > 4; the store is as good as empty.
  const RunResult run = run_text(R"x({"bgsim": 1, "name": "far from zero",
    "elements": {"s": {"kind": "Se", "effort": "10 + t"}, "j": {"kind": "1"}, "lin": {"kind": "R", "resistance": 1},
                 "r": {"kind": "R", "law": "e = log(f - 3) + if(f > 4, 1, 0)"}, "c": {"kind": "C", "capacitance": 1e9}},
    "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "lin"}, {"from": "j", "to": "r"}, {"from": "j", "to": "c"}],
    "scenes": {"s": {"stop": 1, "samples": 11}}, "outputs": {"f": "r.f", "u": "c.e"}})x");
  REQUIRE(run.stop == StopReason::completed);
  for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
    const double f = run.trace["f"][k], u = run.trace["u"][k];
    CHECK(std::abs(f + std::log(f - 3.0) + 1.0 + u - 10.0 - run.trace.times[k]) <
          1e-9);  // loops are solved to rounding
  }
}

}  // namespace bgsim
