// Stores that are tied to each other rigidly, where those that are states are far smaller than the others, or larger:
// their rates are small parts of the forces on them, and may not be left over from differences.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bgsim/text.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::vector<Method> kMethods{Method::automatic, Method::bdf,  Method::ida,   Method::dirk4,
                                   Method::dirk5,     Method::erk5, Method::radau, Method::rodas5p};

/// A model element by element, bond by bond.
class Text {
 public:
  void element(const std::string& name, const std::string& kind, const std::string& rest = "") {
    elements_ += (elements_.empty() ? "\"" : ", \"") + name + R"x(": {"kind": ")x" + kind + "\"" + rest + "}";
  }
  void bond(const std::string& from, const std::string& to) {
    bonds_ += (bonds_.empty() ? "" : ", ") + (R"x({"from": ")x" + from) + R"x(", "to": ")x" + to + "\"}";
  }
  [[nodiscard]] std::string model(const std::string& outputs, const std::string& stop) const {
    return R"x({"bgsim": 1, "name": "rigid", "elements": {)x" + elements_ + R"x(}, "bonds": [)x" + bonds_ +
           R"x(], "outputs": {)x" + outputs + R"x(}, "scenes": {"s": {"stop": )x" + stop + R"x(, "samples": 13}}})x";
  }

 private:
  std::string elements_, bonds_;
};

std::string with(const std::string& name, double value) { return ", \"" + name + "\": " + number_text(value, 17); }
const std::string kState = R"x(, "priority": 1)x";

RunResult completed(const std::string& text, Method method, double relative) {
  RunResult result = Study::from_text(text).scene({}, with_method(method, relative)).simulate(one_run());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

/// v of total v' = 1 + 0.5 sin t - 0.7 v from rest.
double driven(double total, double t) {
  const double a = 0.7 / total, k = 0.5 / total, scale = k / (a * a + 1.0);
  return 1.0 / 0.7 + scale * (a * std::sin(t) - std::cos(t)) - (1.0 / 0.7 - scale) * std::exp(-a * t);
}

/// Some 500 steps at most, each with the tolerance of 1e-9 of v, which comes to 2.
void check_driven(const std::string& model, double total) {
  for (const Method method : kMethods) {
    CAPTURE(method_name(method));
    const RunResult run = completed(model, method, 1e-9);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k)
      CHECK(std::abs(run.trace["v"][k] - driven(total, run.trace.times[k])) < 1e-6);
  }
}

/// An inertia whose speed is that of both states, times the arms.
struct Arms {
  double inertia, one, two;
};

/// Two inertias with friction as states, and dependent ones.
std::string beam(double first, double second, const std::vector<Arms>& arms, double friction, const std::string& stop) {
  Text text;
  const auto state = [&](const std::string& k, double inertia, double force) {
    text.element("j" + k, "1");
    text.element("m" + k, "I", with("inertance", inertia) + kState);
    text.element("b" + k, "R", with("resistance", friction));
    text.element("s" + k, "Se", with("effort", force));
    text.bond("s" + k, "j" + k);
    text.bond("j" + k, "b" + k);
    text.bond("j" + k, "m" + k);
  };
  state("1", first, 1.0);
  state("2", second, 0.3);
  for (std::size_t k = 0; k < arms.size(); ++k) {
    const std::string n = std::to_string(k);
    text.element("n" + n, "0");
    text.element("d" + n, "I", with("inertance", arms[k].inertia));
    text.bond("n" + n, "d" + n);
    for (const std::string& j : {std::string("1"), std::string("2")}) {
      const std::string arm = "t" + n + "_" + j;
      text.element(arm, "TF", with("modulus", j == "1" ? arms[k].one : arms[k].two));
      text.bond("j" + j, arm);
      text.bond(arm, "n" + n);
    }
  }
  return text.model(R"x("v1": "j1.f", "v2": "j2.f")x", stop);
}

}  // namespace

TEST_CASE("a store that is tied to a far larger one is right as the state of both, by every method") {
  for (const bool inertia : {true, false})
    for (const bool geared : {false, true})
      for (const double ratio : {1e-3, 1e-9, 1e-13, 1e-18}) {
        CAPTURE(inertia, geared, ratio);
        const std::string store = inertia ? "I" : "C", size = inertia ? "inertance" : "capacitance";
        const double gear = geared ? 0.37 : 1.0, small = 1.3 * ratio;
        Text text;
        text.element("small", store, with(size, small) + kState);
        text.element("big", store, with(size, 1.3));
        text.element("j", inertia ? "1" : "0");
        text.element("k", inertia ? "1" : "0");
        text.element("b", "R", with("resistance", inertia ? 0.7 : 1.0 / 0.7));
        text.element("s", inertia ? "Se" : "Sf",
                     ", \"" + std::string(inertia ? "effort" : "flow") + R"x(": "1 + 0.5*sin(t)")x");
        text.element("g", "TF", with("modulus", gear));
        text.bond("s", "j");
        for (const char* const to : {"big", "b", "g"}) text.bond("j", to);
        text.bond("g", "k");
        text.bond("k", "small");
        check_driven(text.model(inertia ? R"x("v": "j.f")x" : R"x("v": "j.e")x", "6"),
                     1.3 + (inertia ? small * gear * gear : small / (gear * gear)));
      }
}

TEST_CASE("of a train of gears any inertia may be the state, far smaller than the others or far larger") {
  for (const std::size_t count : {2U, 4U, 6U})
    for (const std::size_t state : {std::size_t{0}, count / 2, count - 1})
      for (const bool larger : {false, true}) {
        CAPTURE(count, state, larger);
        Text text;
        text.element("s", "Se", R"x(, "effort": "1 + 0.5*sin(t)")x");
        text.element("b", "R", with("resistance", 0.7));
        text.bond("s", "j0");
        text.bond("j0", "b");
        double total = 0.0, gear = 1.0;
        for (std::size_t i = 0; i < count; ++i) {
          const std::string n = std::to_string(i);
          const double inertia = (i == state) == larger ? 1.1 / (gear * gear) : 1e-12;
          total += inertia * gear * gear;
          text.element("j" + n, "1");
          text.element("J" + n, "I", with("inertance", inertia) + (i == state ? kState : ""));
          text.bond("j" + n, "J" + n);
          if (i + 1 == count) break;
          text.element("g" + n, "TF", with("modulus", 0.8));
          text.bond("j" + n, "g" + n);
          text.bond("g" + n, "j" + std::to_string(i + 1));
          gear *= 0.8;
        }
        check_driven(text.model(R"x("v": "j0.f")x", "6"), total);
      }
}

TEST_CASE("several states and dependent stores in one loop have rates with all digits") {
  struct Case {
    double first, second;
    std::vector<Arms> arms;
  };
  std::vector<Case> cases;
  for (const double tiny : {1e-6, 1e-12, 1e-18}) {
    cases.push_back({tiny, 1.1, {{1.3, 0.6, 0.8}}});
    cases.push_back({tiny, 1.7 * tiny, {{1.3, 0.6, 0.8}}});
    cases.push_back({tiny, 1.1, {{1.3, 0.6, 0.8}, {0.9, 0.5, -0.7}}});
    cases.push_back({tiny, 1.7 * tiny, {{1.3, 0.6, 0.8}, {0.9, 0.5, -0.7}}});
    cases.push_back({1.0, 1.7, {{1.0 / tiny, 0.6, 0.8}, {0.9, 0.5, -0.7}}});
    cases.push_back({1.0, 1.7, {{tiny, 0.6, 0.8}, {0.9, 0.5, -0.7}}});
    cases.push_back({tiny, 1.1, {{1.3, 0.6, 0.8}, {0.9, 0.5, -0.7}, {1.4, 0.3, 0.1}}});
  }
  for (const auto& [first, second, arms] : cases) {
    CAPTURE(number_text(first), second, arms.size(), arms[0].inertia);
    // Without friction the accelerations are those of Cramer's rule, with the determinant as a sum of what is positive.
    double one = first, two = second, both = 0.0, determinant = first * second;
    for (std::size_t k = 0; k < arms.size(); ++k) {
      const Arms& a = arms[k];
      one += a.inertia * a.one * a.one;
      two += a.inertia * a.two * a.two;
      both += a.inertia * a.one * a.two;
      determinant += a.inertia * (a.one * a.one * second + a.two * a.two * first);
      for (std::size_t i = 0; i < k; ++i)
        determinant += a.inertia * arms[i].inertia * std::pow(a.one * arms[i].two - a.two * arms[i].one, 2);
    }
    const double a1 = (two - 0.3 * both) / determinant, a2 = (0.3 * one - both) / determinant;
    for (const Method method : {Method::erk5, Method::automatic, Method::ida}) {
      CAPTURE(method_name(method));
      const RunResult run = completed(beam(first, second, arms, 0.0, "2"), method, 1e-6);
      CHECK(run.trace["v1"].back() == Approx(2.0 * a1).epsilon(1e-9));  // a straight line, which every method follows
      CHECK(run.trace["v2"].back() == Approx(2.0 * a2).epsilon(1e-9));
    }
    // With friction they come to the speeds at which it takes the forces: the slopes for Newton's iteration are right.
    if (arms[0].inertia > 2.0) continue;  // not within the scene
    for (const Method method : {Method::automatic, Method::bdf, Method::ida, Method::dirk5, Method::rodas5p}) {
      CAPTURE(method_name(method));
      const RunResult run = completed(beam(first, second, arms, 0.7, "100"), method, 1e-6);
      CHECK(run.trace["v1"].back() == Approx(1.0 / 0.7).epsilon(1e-5));  // ten tolerances
      CHECK(run.trace["v2"].back() == Approx(0.3 / 0.7).epsilon(1e-5));
    }
  }
}
