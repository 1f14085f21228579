// Runs that begin exactly where a law changes: an empty tank that fills, a level at the crest of a weir.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

/// A tank of 1 m2 whose level begins at @p level, where the law of what flows out has its border, in a scene of 4 s
/// from
/// @p start on.
std::string tank(const std::string& law, const std::string& inflow, double level, double start) {
  return R"x({"bgsim": 1, "name": "tank", "parameters": {"h0": )x" + std::to_string(level) + R"x(, "t0": )x" +
         std::to_string(start) + R"x(},
    "elements": {"n": {"kind": "0"}, "in": {"kind": "Sf", "flow": ")x" +
         inflow + R"x("}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": "h0"}},
                 "out": {"kind": "R", "law": "f = )x" +
         law + R"x("}},
    "bonds": [{"from": "in", "to": "n"}, {"from": "n", "to": "c"}, {"from": "n", "to": "out"}],
    "scenes": {"s": {"start": )x" +
         std::to_string(start) + R"x(, "stop": )x" + std::to_string(start + 4.0) + R"x(, "samples": 81}},
    "outputs": {"h": "c.e - h0"}})x";
}

/// When a tank with the inflow 2 that loses 0.7 h^power has the level h: the integral of dh/(2 - 0.7 h^power), by
/// Simpson's rule over v = sqrt(h), in which the integrand is smooth.
double when(double h, double power) {
  constexpr int kParts = 10000;
  const double step = std::sqrt(h) / kParts;
  double sum = 0.0;
  for (int i = 0; i <= kParts; ++i) {
    const double v = step * i, weight = i == 0 || i == kParts ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * 2.0 * v / (2.0 - 0.7 * std::pow(v, 2.0 * power));
  }
  return sum * step / 3.0;
}

const std::vector<Method> kMethods{Method::bdf,   Method::adams, Method::ida,     Method::erk5,     Method::dirk3,
                                   Method::dirk4, Method::radau, Method::rodas5p, Method::automatic};

/// A source of effort behind an inertance fills a capacitance that starts at the crest of a weir, in 6 s.
struct Weir {
  double crest, effort, inertance, capacitance, coefficient;

  /// @param law  over k and h, the coefficient and the crest
  [[nodiscard]] std::string model(const std::string& law) const {
    const auto text = [](double value) { return std::to_string(value); };
    return R"x({"bgsim": 1, "name": "weir", "parameters": {"h": )x" + text(crest) + R"x(, "k": )x" + text(coefficient) +
           R"x(},
    "elements": {"src": {"kind": "Se", "effort": )x" +
           text(effort) + R"x(}, "j": {"kind": "1"}, "n": {"kind": "0"}, "pipe": {"kind": "I", "inertance": )x" +
           text(inertance) + R"x(}, "c": {"kind": "C", "capacitance": )x" + text(capacitance) +
           R"x(, "initial": {"q": "h*)x" + text(capacitance) + R"x("}}, "v": {"kind": "R", "law": "f = )x" + law +
           R"x("}},
    "bonds": [{"from": "src", "to": "j"}, {"from": "j", "to": "pipe"}, {"from": "j", "to": "n"},
              {"from": "n", "to": "c"}, {"from": "n", "to": "v"}],
    "scenes": {"s": {"stop": 6, "samples": 61}}, "outputs": {"e": "c.e", "f": "v.f"}})x";
  }

  /// Efforts of the capacitance at the scene's times with the law f = k (e - h)^0.5. With e = h + v^2 the equations are
  /// smooth, and v = c t at first: v' = (p/(I v) - k)/(2 C), p' = drop - v^2, by the method of Runge and Kutta.
  [[nodiscard]] std::vector<double> efforts() const {
    constexpr double kBegin = 1e-6, kLongest = 1e-4;
    const double drop = effort - crest, b = coefficient / (2.0 * capacitance),
                 a = drop / (2.0 * capacitance * inertance);
    double t = kBegin, v = (std::sqrt(b * b + 4.0 * a) - b) / 2.0 * t, p = drop * t;
    const auto rate_v = [&](double at_v, double at_p) {
      return (at_p / (inertance * at_v) - coefficient) / (2.0 * capacitance);
    };
    const auto rate_p = [&](double at_v) { return drop - at_v * at_v; };
    std::vector<double> result{crest};
    for (int k = 1; k <= 60; ++k) {
      while (t < 0.1 * k) {
        const double h = std::min({kLongest, 0.01 * t, 0.1 * k - t});
        const double v1 = rate_v(v, p), p1 = rate_p(v), va = v + h / 2.0 * v1, pa = p + h / 2.0 * p1;
        const double v2 = rate_v(va, pa), p2 = rate_p(va), vb = v + h / 2.0 * v2, pb = p + h / 2.0 * p2;
        const double v3 = rate_v(vb, pb), p3 = rate_p(vb), vc = v + h * v3, pc = p + h * p3;
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + rate_v(vc, pc));
        p += h / 6.0 * (p1 + 2.0 * p2 + 2.0 * p3 + rate_p(vc));
        t += h;
      }
      result.push_back(crest + v * v);
    }
    return result;
  }
};

}  // namespace

TEST_CASE("a tank that is filled from where its law changes fills as its law says, by every method", "[long]") {
  struct Outflow {
    std::string text;
    double power;
  };
  const std::vector<Outflow> laws{{"0.7*sign(e - h0)*sqrt(abs(e - h0))", 0.5},
                                  {"0.7*sqrt(max(e - h0, 0))", 0.5},
                                  {"if(e > h0, 0.7*sqrt(e - h0), -0.7*sqrt(h0 - e))", 0.5},
                                  {"if(e > h0, 0.7*(e - h0)^1.5, -0.7*(h0 - e)^1.5)", 1.5},
                                  {"if(e >= h0, 0.7*(e - h0)^1.5, 0)", 1.5}};
  for (const Outflow& law : laws)
    for (const double level : {0.0, 3.7})
      for (const double start : {0.0, 5.0})
        for (const Method method : kMethods) {
          CAPTURE(law.text, level, start, method_name(method));
          const RunResult run = run_text(tank(law.text, "2", level, start), with_method(method));
          REQUIRE(run.stop == StopReason::completed);
          for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
            const double h = run.trace["h"][k], late = when(std::max(h, 0.0), law.power) - (run.trace.times[k] - start);
            // A hundred tolerances of the level, in some fifty steps.
            CHECK(std::abs(late * (2.0 - 0.7 * std::pow(std::max(h, 0.0), law.power))) <= 1e-4 * (h + level));
          }
        }
}

TEST_CASE("a tank whose inflow begins at 0 follows it through a root, by every method") {
  // h = (c t)^2 in h' = t - 0.7 sqrt(h): 2 c^2 = 1 - 0.7 c.
  const double c = (std::sqrt(0.49 + 8.0) - 0.7) / 4.0;
  for (const std::string law : {"0.7*sign(e)*sqrt(abs(e))", "0.7*sqrt(max(e, 0))", "if(e >= 0, 0.7*e^0.5, 0)"})
    for (const double start : {0.0, 5.0})
      for (const Method method : kMethods) {
        CAPTURE(law, start, method_name(method));
        const RunResult run = run_text(tank(law, "t - t0", 0.0, start), with_method(method));
        REQUIRE(run.stop == StopReason::completed);
        for (std::size_t k = 0; k < run.trace.times.size(); ++k)
          CHECK(std::abs(run.trace["h"][k] - std::pow(c * (run.trace.times[k] - start), 2.0)) < 5e-4);
      }
}

TEST_CASE("a tank that is drawn from at its crest, ever faster, leaves the law that ends there, by every method") {
  // By 0.2 t^2 from 3.7. Radau's steps moved the level by less than its rounding, and went on for days.
  for (const std::string law : {"if((e - h0) >= 0, 0.1*(e - h0)^1.5, 0)", "if(e >= h0, 0.1*sqrt(e - h0), 0)"})
    for (const Method method : kMethods) {
      CAPTURE(law, method_name(method));
      const RunResult run = run_text(tank(law, "-0.4*(t - t0)", 3.7, 0.0), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k)
        CHECK(std::abs(run.trace["h"][k] + 0.2 * std::pow(run.trace.times[k], 2)) < 1e-4);
      CHECK(run.trace["h"].back() < -3.0);
    }
}

TEST_CASE("a tank with a root of the third degree that an inflow from 0 fills is as full as its law says", "[long]") {
  // h' = t/2 - 0.12 h^(1/3), from the level that lets all of it out, (t/0.24)^3, by the method of Runge and Kutta.
  const auto rate = [](double t, double h) { return 0.5 * t - 0.12 * std::cbrt(h); };
  constexpr double kBegin = 1e-4, kLongest = 1e-4, kEnd = 4.0;
  double t = kBegin, h = std::pow(t / 0.24, 3.0);
  while (t < kEnd) {
    const double d = std::min({kLongest, 0.01 * t, kEnd - t});
    const double k1 = rate(t, h), k2 = rate(t + d / 2.0, h + d / 2.0 * k1), k3 = rate(t + d / 2.0, h + d / 2.0 * k2);
    h += d / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(t + d, h + d * k3));
    t += d;
  }
  for (const std::string law : {"if(e >= 0, 0.12*e^(1/3), 0)", "0.12*max(e, 0)^(1/3)", "0.12*cbrt(e)"})
    for (const Method method : {Method::automatic, Method::radau, Method::ida, Method::adams, Method::erk5}) {
      CAPTURE(law, method_name(method));
      const RunResult run = run_text(tank(law, "0.5*t", 0.0, 0.0), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(std::abs(last(run, "h") - h) < 1e-5);
    }
}

TEST_CASE("a weir behind a coil that starts at its crest overflows, by every method", "[long]") {
  // The last two come to no more than the tolerance above the crest for long.
  for (const Weir& weir :
       {Weir{2.0, 5.0, 0.3, 0.2, 1.3}, Weir{0.5, 1.16, 6.7, 0.3, 2.23}, Weir{2.0, 2.72, 4.4, 0.154, 1.76}}) {
    const std::vector<double> exact = weir.efforts();
    for (const std::string law :
         {"if(e > h, k*(e - h)^0.5, 0)", "if(e >= h, k*(e - h)^0.5, 0)", "k*max(e - h, 0)^0.5"}) {
      std::vector<Method> methods = kMethods;
      methods.push_back(Method::dirk5);
      for (const Method method : methods) {
        CAPTURE(law, weir.inertance, method_name(method));
        // BDF lags behind there by 4 % of the effort's range, which the report says (docs/design/state.md).
        if (method == Method::bdf && weir.inertance > 4.0 && law[0] == 'k') continue;
        const RunResult run = run_text(weir.model(law), with_method(method));
        REQUIRE(run.stop == StopReason::completed);
        double worst = 0.0;
        for (std::size_t k = 0; k < exact.size(); ++k) worst = std::max(worst, std::abs(run.trace["e"][k] - exact[k]));
        // Near the crest the effort is known to a few millionths of itself, and so the flow to some thousandths.
        CHECK(worst < 3e-3 * *std::max_element(exact.begin(), exact.end()));
      }
    }
  }
}

TEST_CASE("a tank that is filled from the border of a root is as full in the end by dirk5 and radau") {
  // Their iterations took the slope a rounding beside the border for that of the whole step.
  for (const double level : {0.0, 3.7})
    for (const Method method : {Method::dirk5, Method::radau, Method::rodas5p}) {
      CAPTURE(level, method_name(method));
      const RunResult run = run_text(tank("0.7*sign(e - h0)*sqrt(abs(e - h0))", "2", level, 0.0), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(std::abs(when(last(run, "h"), 0.5) - 4.0) < 1e-5);
    }
}

}  // namespace bgsim
