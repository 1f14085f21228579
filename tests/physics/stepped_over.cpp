// What happens between the points that an integrator evaluates: gates, narrow laws, laws that end, denominators.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "support/fed_states.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// y' = flow, beside a clock c.q = t, an oscillator s.q = cos(t), and a loop through two resistors: r.f^3 + 2 r.f =
/// c.q.
std::string fed(const std::string& flow) {
  return R"({ "bgsim": 1, "name": "fed", "elements": {
      "tick": { "kind": "MSf", "flow": "1" }, "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
      "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
      "s": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
      "push": { "kind": "MSe", "effort": "c.q" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "law": "e = f + f^3" }, "r2": { "kind": "R", "law": "f = e" },
      "in": { "kind": "MSf", "flow": ")" +
         flow + R"(" }, "k": { "kind": "0" }, "y": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "tick", "to": "n" }, { "from": "n", "to": "c" }, { "from": "j", "to": "m" },
      { "from": "j", "to": "s" }, { "from": "push", "to": "loop" }, { "from": "loop", "to": "r" },
      { "from": "loop", "to": "r2" }, { "from": "in", "to": "k" }, { "from": "k", "to": "y" } ],
    "outputs": { "y": "y.q" }, "scenes": { "main": { "stop": 10, "samples": 11 } } })";
}

double through_loop(double push) {
  double f = 0.0;
  for (int i = 0; i < 60; ++i) f -= (f * f * f + 2.0 * f - push) / (3.0 * f * f + 2.0);
  return f;
}

struct Member {
  std::string flow;
  std::function<double(double c, double s)> same;  ///< of the clock and the oscillator
};

/// The midpoint rule: off by half a piece at each jump.
double integral(const std::function<double(double, double)>& flow) {
  constexpr int kPieces = 1'000'000;
  double sum = 0.0;
  for (int i = 0; i < kPieces; ++i) {
    const double t = 10.0 * (i + 0.5) / kPieces;
    sum += flow(t, std::cos(t));
  }
  return 10.0 * sum / kPieces;
}

/// All members by all methods, with the same relative error allowed.
void check(const std::vector<Member>& members, double relative, double allowed) {
  for (const Member& member : members) {
    const double exact = integral(member.same);
    for (const Method method :
         {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::radau, Method::rodas5p}) {
      INFO(member.flow << ", " << facts_of(method).name);
      const RunResult result = run_text(fed(member.flow), with_method(method, relative));
      REQUIRE(result.stop == StopReason::completed);
      CHECK(last(result, "y") == Approx(exact).epsilon(allowed));
    }
  }
}

double on(bool condition) { return condition ? 1.0 : 0.0; }
double bell(double x) { return std::exp(-x * x); }

}  // namespace

TEST_CASE("gates that smoothly moving states open and shut are found by every method", "[long]") {
  // The midpoint rule knows each edge to 5e-6. Where cos(t) turns, an edge moves by a hundred times the oscillator's
  // own error, which is to be no matter here: so the tolerance is tight, and the steps of the clock are long all the
  // same.
  check({{"if(sin(300*c.q) > 0, 1, 0)", [](double c, double) { return on(std::sin(300 * c) > 0); }},
         {"if(sin(40*(c.q + s.q)) > 0.9, 1, 0)", [](double c, double s) { return on(std::sin(40 * (c + s)) > 0.9); }},
         {"if(abs(s.q - 0.5) < 1e-2, 10, 0)", [](double, double s) { return 10 * on(std::abs(s - 0.5) < 1e-2); }},
         {"mod(floor(50*c.q), 2)", [](double c, double) { return std::fmod(std::floor(50 * c), 2.0); }},
         {"1 + round(20*s.q)^2", [](double, double s) { return 1 + std::pow(std::round(20 * s), 2); }},
         {"1 + sign(cos(200*c.q) - 0.2)", [](double c, double) { return 2 * on(std::cos(200 * c) > 0.2); }},
         {"if(cos(60*c.q) > 0.99 and s.q > 0, 1, 0)",
          [](double c, double s) { return on(std::cos(60 * c) > 0.99 && s > 0); }},
         {"step(sin(5*c.q*c.q) - 0.5)", [](double c, double) { return on(std::sin(5 * c * c) >= 0.5); }},
         {"if(max(sin(90*c.q), s.q) > 0.97, 1, 0)",
          [](double c, double s) { return on(std::max(std::sin(90 * c), s) > 0.97); }},
         {"if(sin(50*c.q + 30*t) > 0.5, 1, 0)", [](double c, double) { return on(std::sin(80 * c) > 0.5); }},
         {"if(abs(c.q - 2) < 1e-3, if(s.q < 0, 1e3, 0), 0)",
          [](double c, double) { return 1e3 * on(std::abs(c - 2) < 1e-3); }},
         {"if(sin(60*r.f) > 0.5, 1, 0)", [](double c, double) { return on(std::sin(60 * through_loop(c)) > 0.5); }}},
        1e-9, 2e-4);
}

TEST_CASE("windows of a state are found where their condition is a small difference of powers, by every method") {
  // The guard is at most a power of the width, beside some 70 to 5000 where x is away from the window.
  const struct {
    std::string flow;
    double width, area;
  } members[] = {{"if(1e-20 > (x.q + 1.5)^4, 1, 0)", 1e-5, 2},
                 {"if(1e-14 > (x.q + 1.5)^2, 1, 0)", 1e-7, 2},
                 {"if((x.q + 1.5)*(x.q + 1.5) < 1e-18, 1, 0)", 1e-9, 2},
                 {"if(1e-28 > (x.q + 1.5)^4, 1, 0)", 1e-7, 2},
                 {"if(1e-21 > abs(x.q + 1.5)^3, 1, 0)", 1e-7, 2},
                 {"if((x.q + 1.5)*(x.q + 1.5 + 1e-7) < 0, 1, 0)", 1e-7, 1}};
  for (const auto& member : members) {
    const std::string text =
        fed_states({{"x", "0", "-2.7"}, {"y", "0", "2.7/" + number_text(member.width, 17) + "*" + member.flow}},
                   "\"stop\": 3.7, \"samples\": 11");
    for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::erk4, Method::erk5,
                                Method::dirk4, Method::radau, Method::rodas5p}) {
      INFO(member.flow << " by " << method_name(method));
      const RunResult run = run_text(text, with_method(method, 1e-6));
      // Its ends are known to some roundings of x, and the widest is held to the tolerance.
      CHECK(run.trace.columns[1].back() == Approx(member.area).epsilon(1e-6 + 16 * 1.5 * 0x1p-52 / member.width));
    }
  }
}

TEST_CASE("narrow smooth laws of states are seen by every method", "[long]") {
  // At the default tolerance of 1e-6: the error of ten to a hundred tolerances for each passage.
  check({{"100*exp(-((c.q - 5)*100)^2)", [](double c, double) { return 100 * bell((c - 5) * 100); }},
         {"100/(1 + ((c.q - 5)*300)^2)", [](double c, double) { return 100 / (1 + std::pow((c - 5) * 300, 2)); }},
         {"50*(tanh(200*(c.q - 5)) - tanh(200*(c.q - 5.01)))",
          [](double c, double) { return 50 * (std::tanh(200 * (c - 5)) - std::tanh(200 * (c - 5.01))); }},
         {"100*max(0, 1 - abs(c.q - 5)*100)",
          [](double c, double) { return 100 * std::max(0.0, 1 - std::abs(c - 5) * 100); }},
         {"20*cos(c.q)^400", [](double c, double) { return 20 * std::pow(std::cos(c), 400); }},
         {"100*exp(-((s.q - 0.5)*200)^2)", [](double, double s) { return 100 * bell((s - 0.5) * 200); }},
         {"20*exp(-((s.q - 0.3)*50)^2 - 0.01*(c.q - 5)^2)",
          [](double c, double s) { return 20 * bell((s - 0.3) * 50) * bell(0.1 * (c - 5)); }},
         {"100/cosh(60*(c.q - 5))^2", [](double c, double) { return 100 / std::pow(std::cosh(60 * (c - 5)), 2); }},
         {"10*exp(60*(sin(3*c.q) - 1))", [](double c, double) { return 10 * std::exp(60 * (std::sin(3 * c) - 1)); }},
         {"80*exp(-((c.q + t - 10)*40)^2)", [](double c, double) { return 80 * bell((2 * c - 10) * 40); }},
         {"10*(1 - 0.04*(c.q - 5)^2)^400",
          [](double c, double) { return 10 * std::pow(1 - 0.04 * (c - 5) * (c - 5), 400); }},
         {"10*(atan(1e3*(c.q - 5)) - atan(1e3*(c.q - 5.02)))",
          [](double c, double) { return 10 * (std::atan(1e3 * (c - 5)) - std::atan(1e3 * (c - 5.02))); }},
         {"50*exp(-((r.f - 0.8)*80)^2)", [](double c, double) { return 50 * bell((through_loop(c) - 0.8) * 80); }}},
        1e-6, 1e-3);
}

TEST_CASE("a law far beyond the border at which it ends never enters the result", "[long]") {
  // The states after a border begin from what BDF of first order makes of a steep law: some hundred tolerances.
  check({{"(c.q - floor(c.q))^40", [](double c, double) { return std::pow(c - std::floor(c), 40); }},
         {"if(c.q < 5, (c.q/5)^60, 0)", [](double c, double) { return c < 5 ? std::pow(c / 5, 60) : 0.0; }},
         {"if(c.q < 3, exp(30*(c.q - 3)), 0)", [](double c, double) { return c < 3 ? std::exp(30 * (c - 3)) : 0.0; }},
         {"if(c.q < 3, exp(30*(c.q - 3)), exp(30*(3 - c.q)))",
          [](double c, double) { return std::exp(-30 * std::abs(c - 3)); }},
         {"mod(c.q, 1)^30", [](double c, double) { return std::pow(std::fmod(c, 1.0), 30); }},
         {"1e5*(c.q - round(c.q))^20", [](double c, double) { return 1e5 * std::pow(c - std::round(c), 20); }},
         {"if(s.q > 0, exp(-20*s.q), 0)", [](double, double s) { return s > 0 ? std::exp(-20 * s) : 0.0; }},
         {"step(4 - c.q)*exp(9*(c.q - 4))", [](double c, double) { return c <= 4 ? std::exp(9 * (c - 4)) : 0.0; }},
         {"if(c.q < 2, 1/(2.01 - c.q), 0)", [](double c, double) { return c < 2 ? 1 / (2.01 - c) : 0.0; }},
         {"if(r.f < 1, r.f^50, 0)",
          [](double c, double) { return through_loop(c) < 1 ? std::pow(through_loop(c), 50) : 0.0; }}},
        1e-6, 1e-3);
}

TEST_CASE("a denominator of little weight that passes zero ends the run by every method") {
  for (const std::string flow :
       {"1 + 1e-6/(c.q - 0.5)", "1e-7/(s.q - 0.3)", "1 + 1e-9/(c.q - 2)^2", "1e-6/sin(c.q + 1)", "1e-6/log(c.q + 0.5)",
        "1 + 1e-6/tanh(c.q - 3)", "1e-7/(c.q*s.q - 0.2)", "2 + 1e-8/(c.q + 0.5 - 0.2*t^2)", "1e-6/(c.q^3 - 2)",
        "1e-6/(0.5 - r.f)", "1e-6*c.q/(3 - c.q - s.q)"})
    for (const Method method :
         {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::radau, Method::rodas5p}) {
      INFO(flow << ", " << facts_of(method).name);
      const RunResult result = run_text(fed(flow), with_method(method));
      REQUIRE(result.failure);
      CHECK(result.failure->code == "BG613");
    }
}

TEST_CASE("a quotient of two zeros that stays finite ends no run") {
  for (const std::string flow : {"sin(c.q - 3)/(c.q - 3)", "(exp(s.q) - 1)/s.q", "(c.q^2 - 4)/(c.q - 2)"})
    for (const Method method :
         {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::radau, Method::rodas5p}) {
      INFO(flow << ", " << facts_of(method).name);
      CHECK(run_text(fed(flow), with_method(method)).stop == StopReason::completed);
    }
}
