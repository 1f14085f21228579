// Enclosures of expressions, of dense output, and the search for crossings that is built on both.
#include "program/enclosure.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "run/integrate/step_polynomial.hpp"
#include "run/watch/first_crossing.hpp"
#include "run/watch/solved_along.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A C fed by a flow that may depend on its own charge a.q and on that of another C, b.q.
CompiledModel fed_by(const std::string& flow) {
  return compile_text(R"({ "bgsim": 1, "name": "fed", "parameters": { "k": 3 }, "elements": {
      "source": { "kind": "MSf", "flow": ")" +
                      flow + R"(" }, "n": { "kind": "0" }, "a": { "kind": "C", "capacitance": 2 },
      "other": { "kind": "MSf", "flow": "1 - a.q" }, "n2": { "kind": "0" }, "b": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "source", "to": "n" }, { "from": "n", "to": "a" },
               { "from": "other", "to": "n2" }, { "from": "n2", "to": "b" } ],
    "outputs": { "a": "a.q" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })");
}

struct Polynomials {
  std::array<std::array<double, 4>, 2> c{};
  double a(double t) const { return ((c[0][3] * t + c[0][2]) * t + c[0][1]) * t + c[0][0]; }
  double b(double t) const { return ((c[1][3] * t + c[1][2]) * t + c[1][1]) * t + c[1][0]; }
};

}  // namespace

TEST_CASE("an enclosure holds the values and slopes of a rate along any course of the states") {
  const std::vector<std::string> flows{"a.q*b.q - k*t",
                                       "exp(-((a.q - 0.5)*20)^2)",
                                       "sin(30*a.q)*cos(b.q) + tanh(50*b.q)",
                                       "1/(2 + a.q^2) - a.q/(3 + b.q)",
                                       "ssqrt(a.q - b.q, 1e-3)",
                                       "sqrt(abs(a.q)) + cbrt(4 + b.q)",
                                       "min(a.q, b.q) - max(t, a.q)",
                                       "hypot(a.q, b.q) + atan2(2 + a.q*0.1, b.q)",
                                       "if(a.q > 0.3, a.q^3, exp(b.q))",
                                       "(3 + a.q)^b.q + (3 + b.q)^-2 + log(4 + a.q*b.q) + log1p(0.2*a.q^2)",
                                       "atan(9*a.q) + asinh(b.q) + cosh(a.q) - sinh(b.q) + expm1(a.q) + log10(5 + a.q)",
                                       "asin(a.q/9) + acos(b.q/9) + tan(a.q/4) + acosh(5 + a.q) + atanh(b.q/9)",
                                       "sin(k*t + a.q*b.q) - cos(b.q - a.q)/k",
                                       "-(a.q - b.q*t)*(a.q - b.q*t) + exp(-a.q*b.q)*sin(a.q)",
                                       "exp(sin(a.q + b.q)) - exp(cos(t - a.q))*(b.q - t)",
                                       "floor(3*a.q)*a.q + mod(b.q, 0.7) + a.q^40 + sign(b.q)*abs(a.q)"};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-0.6, 0.6);
  for (const std::string& flow : flows) {
    INFO(flow);
    const CompiledModel model = fed_by(flow);
    const Program& program = model.program;
    const ExprId rate = program.slot_expression[program.rates.results[0]];
    Enclosure enclosure(program, model.inputs.parameters, std::vector<ExprId>{rate});
    std::vector<double> modes(program.relations.size());
    for (double& mode : modes) mode = std::round(3.0 * number(random)) > 0 ? 1.0 : 0.0;
    enclosure.set_modes(modes);
    std::vector<double> symbols(program.symbol_names.size());
    for (std::size_t i = 0; i < program.parameters.size(); ++i)
      symbols[program.parameters[i].index()] = model.inputs.parameters[i];
    for (std::size_t i = 0; i < modes.size(); ++i)
      symbols[program.pool.symbol_of(program.slot_expression[program.first_mode + i]).index()] = modes[i];
    const auto slot_symbol = [&](std::size_t slot) {
      return program.pool.symbol_of(program.slot_expression[slot]).index();
    };
    int bounded = 0;
    for (int course = 0; course < 40; ++course) {
      Polynomials p;
      for (auto& c : p.c)
        for (double& x : c) x = number(random);
      const double length = std::pow(10.0, -(course % 4));
      StepPolynomial polynomial;
      const std::vector<std::uint32_t> states = enclosure.states();
      polynomial.take(0.0, length, 3, states, 2, [&](double t, double* y) {
        y[0] = p.a(t);
        y[1] = p.b(t);
      });
      for (const auto& [from, to] : {std::pair(0.0, length), std::pair(0.25 * length, 0.375 * length)}) {
        std::vector<Jet> jets;
        polynomial.over(from, to, jets);
        enclosure.evaluate(from, to, jets, {});
        const Jet jet = enclosure[0];
        bounded += std::isfinite(jet.slope.upper() - jet.slope.lower()) ? 1 : 0;
        const auto at = [&](double t) {
          symbols[slot_symbol(program.time_slot)] = t;
          symbols[slot_symbol(program.first_state)] = p.a(t);
          symbols[slot_symbol(program.first_state + 1)] = p.b(t);
          return evaluate(program.pool, rate, symbols);
        };
        CHECK(jet.middle == Approx(at(from + (to - from) / 2)).epsilon(1e-9).margin(1e-12));
        const double step = (to - from) / 32;
        // Roundings of a difference of two values near 1 over a thirty-second of the stretch.
        const double rounding = 1e-13 / step;
        double last = 0.0;
        for (int k = 0; k <= 32; ++k) {
          const double value = at(from + k * step), slack = 1e-13 * (1.0 + std::abs(value));
          if (!(value >= jet.value.lower() - slack && value <= jet.value.upper() + slack)) CHECK(value == 0.0);
          const double slope = (value - last) / step;
          if (k > 0 && !(slope >= jet.slope.lower() - rounding - 1e-9 * std::abs(slope) &&
                         slope <= jet.slope.upper() + rounding + 1e-9 * std::abs(slope)))
            CHECK(slope == 0.0);
          last = value;
        }
      }
    }
    CHECK(bounded > 40);
  }
}

TEST_CASE("the excess of an enclosure falls with the square of the stretch") {
  const CompiledModel model = fed_by("a.q*(1 - a.q)*exp(-a.q)*sin(b.q)");
  const Program& program = model.program;
  Enclosure enclosure(program, model.inputs.parameters,
                      std::vector<ExprId>{program.slot_expression[program.rates.results[0]]});
  enclosure.set_modes({});
  const auto excess = [&](double length) {
    StepPolynomial polynomial;
    const auto a = [](double t) { return 0.3 + 0.7 * t; };
    const auto b = [](double t) { return 1.1 - t * t; };
    polynomial.take(0.2, 0.2 + length, 2, enclosure.states(), 2, [&](double t, double* y) {
      y[0] = a(t);
      y[1] = b(t);
    });
    std::vector<Jet> jets;
    polynomial.over(0.2, 0.2 + length, jets);
    enclosure.evaluate(0.2, 0.2 + length, jets, {});
    double low = 1e9, high = -1e9;
    for (int i = 0; i <= 1000; ++i) {
      const double t = 0.2 + length * i / 1000, x = a(t);
      const double value = x * (1 - x) * std::exp(-x) * std::sin(b(t));
      low = std::min(low, value);
      high = std::max(high, value);
    }
    const Range range = enclosure[0].value;
    CHECK(range.lower() <= low);
    CHECK(range.upper() >= high);
    return (range.upper() - range.lower()) - (high - low);
  };
  const double coarse = excess(0.02), fine = excess(0.002);
  CHECK(fine < 0.02 * coarse);  // a hundredth, and what is left of higher order
}

TEST_CASE("the excess of a difference of terms that nearly cancel falls with the cube of the stretch") {
  // A state that follows a sine to 1e-9 of it: what is left of the difference is no part of either term.
  const CompiledModel model = fed_by("1e4*sin(t) - 1e4*a.q");
  const Program& program = model.program;
  Enclosure enclosure(program, model.inputs.parameters,
                      std::vector<ExprId>{program.slot_expression[program.rates.results[0]]});
  enclosure.set_modes({});
  const auto ranges = [&](double length) {
    StepPolynomial polynomial;
    polynomial.take(0.0, 0.1, 5, enclosure.states(), 2, [&](double t, double* y) {
      y[0] = t - t * t * t / 6.0 + t * t * t * t * t / 120.0;
      y[1] = 0.0;
    });
    std::vector<Jet> jets;
    polynomial.over(0.05, 0.05 + length, jets);
    enclosure.evaluate(0.05, 0.05 + length, jets, {});
    return enclosure[0];
  };
  const Jet coarse = ranges(0.04), fine = ranges(0.004);
  const auto width = [](const Range& range) { return range.upper() - range.lower(); };
  // A thousandth for values and a hundredth for slopes, and half as much again for what is left of higher order; the
  // mean value form alone gives a hundredth and a tenth.
  CHECK(width(fine.value) < 1.5e-3 * width(coarse.value));
  CHECK(width(fine.slope) < 1.5e-2 * width(coarse.slope));
  // 1e4 times the third derivative, which is at most 1, over half the stretch.
  CHECK(width(coarse.value) < 1e4 * 0.04 * 0.04 * 0.04);
}

TEST_CASE("how far an operator bends tells whether its arguments move farther than it is smooth") {
  const auto bend = [](const std::string& law, double from, double to) {
    const CompiledModel model = fed_by(law);
    const Program& program = model.program;
    Enclosure enclosure(program, model.inputs.parameters,
                        std::vector<ExprId>{program.slot_expression[program.rates.results[0]]});
    enclosure.set_modes({});
    StepPolynomial polynomial;
    polynomial.take(0.0, 1.0, 1, enclosure.states(), 2, [&](double t, double* y) {
      y[0] = from + (to - from) * t;
      y[1] = 0.0;
    });
    std::vector<Jet> jets;
    polynomial.over(0.0, 1.0, jets);
    enclosure.evaluate(0.0, 1.0, jets, {});
    const Range value = enclosure[0].value;
    return enclosure.bend(0) / std::max(std::abs(value.lower()), std::abs(value.upper()));
  };
  CHECK(bend("exp(a.q)", 0.0, 0.1) < 0.01);
  CHECK(bend("exp(a.q)", 0.0, 3.0) > 0.5);
  CHECK(bend("exp(-(100*(a.q - 0.5))^2)", 0.0, 1.0) > 100.0);
  CHECK(bend("tanh(1e3*a.q)", 0.0, 1e-4) < 0.01);
  CHECK(bend("tanh(1e3*a.q)", -0.1, 0.1) > 1.0);
  CHECK(bend("1/(1 + a.q)", 0.0, 0.1) < 0.02);
  CHECK(bend("1/(1 + a.q)", 0.0, 9.0) > 0.5);
  CHECK(bend("a.q^40", 0.9, 0.91) < 0.1);
  CHECK(bend("a.q^40", 0.5, 1.0) > 1.0);
  CHECK(bend("a.q + 3*b.q", -5.0, 5.0) == 0.0);
}

TEST_CASE("a step's polynomial is that of its samples, for every degree") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int degree = 0; degree <= StepPolynomial::kHighestDegree; ++degree) {
    std::vector<double> c(static_cast<std::size_t>(degree) + 1);
    for (double& x : c) x = number(random);
    const double begin = 3.0, end = 3.5;
    const auto at = [&](double t) {
      double value = 0.0;
      for (std::size_t j = c.size(); j-- > 0;) value = value * (t - begin) / (end - begin) + c[j];
      return value;
    };
    StepPolynomial polynomial;
    const std::vector<std::uint32_t> second{1};
    int calls = 0;
    polynomial.take(begin, end, degree, second, 2, [&](double t, double* y) {
      ++calls;
      y[0] = 7.0;
      y[1] = at(t);
    });
    CHECK(calls == degree + 1);
    for (int i = 0; i < 16; ++i) {
      const double from = begin + (end - begin) * i / 16, to = begin + (end - begin) * (i + 1) / 16;
      const Jet jet = polynomial.over(0, from, to);
      CHECK(jet.middle == Approx(at(from + (to - from) / 2)).margin(1e-12));
      CHECK(polynomial.at(0, from).first == Approx(at(from)).margin(1e-12));
      CHECK(polynomial.at(0, from).second == Approx((at(from + 1e-6) - at(from - 1e-6)) / 2e-6).margin(1e-6));
      for (int k = 0; k <= 10; ++k) {
        const double t = from + (to - from) * k / 10, value = at(t);
        CHECK(value >= jet.value.lower() - 1e-12);
        CHECK(value <= jet.value.upper() + 1e-12);
      }
      if (degree > 0) CHECK(jet.value.upper() - jet.value.lower() < 5.0);
    }
  }
}

namespace {

/// sin(frequency*t) + shift, over stretches; the enclosure has an excess of a part of the stretch.
class Sines final : public CrossingFunctions {
 public:
  Sines(std::vector<double> frequencies, double shift, double excess = 0.0)
      : frequencies_(std::move(frequencies)), shift_(shift), excess_(excess) {
    values_.resize(frequencies_.size());
    jets_.resize(frequencies_.size());
  }
  bool enclose(double from, double to) override {
    for (std::size_t i = 0; i < jets_.size(); ++i) {
      const Range angle(frequencies_[i] * from, frequencies_[i] * to), none;
      jets_[i].value = range_of(Op::sin, nullptr, angle, none, none) + shift_ +
                       excess_ * frequencies_[i] * Range(from - to, to - from);
      jets_[i].slope = frequencies_[i] * range_of(Op::cos, nullptr, angle, none, none);
    }
    return true;
  }
  [[nodiscard]] Jet jet(std::size_t i) const override { return jets_[i]; }
  [[nodiscard]] bool stays(std::size_t, const Jet& jet) const override { return jet.value.lower() > 0.0; }
  bool evaluate(double t) override {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = std::sin(frequencies_[i] * t) + shift_;
    return true;
  }
  [[nodiscard]] bool crossed(std::size_t i) const override { return values_[i] <= 0.0; }

 private:
  std::vector<double> frequencies_, values_;
  std::vector<Jet> jets_;
  double shift_, excess_;
};

}  // namespace

TEST_CASE("the first crossing of many is bracketed, however many follow in the stretch") {
  Sines fast({300.0, 1.0}, 0.999);
  const FirstCrossing found = first_crossing(fast, {0, 1}, 0.0, 10.0, 1000);
  REQUIRE(found.bracket);
  // sin(300 t) = -0.999 first at (pi + arcsin 0.999)/300
  const double first = (M_PI + std::asin(0.999)) / 300.0;
  CHECK(found.bracket->first <= first);
  CHECK(found.bracket->second >= first);
  CHECK(found.bracket->second - found.bracket->first < 0.02);
  CHECK(found.undecided.empty());
  CHECK(found.enclosures < 60);
}

TEST_CASE("a function that comes near to zero and never crosses is excluded, at a bounded cost") {
  Sines near({300.0}, 1.0 + 1e-9, 0.5);
  const FirstCrossing none = first_crossing(near, {0}, 0.0, 0.1, 10000);
  CHECK(!none.bracket);
  CHECK(none.undecided.empty());
  // Five minima; a stretch around one is halved some 33 times, at two enclosures each, until it is shown to stay above.
  CHECK(none.enclosures < 400);
}

TEST_CASE("what the work allowed does not decide is named") {
  Sines many({1e6}, 1.0 + 1e-6, 0.5);
  const FirstCrossing unknown = first_crossing(many, {0}, 0.0, 10.0, 100);
  CHECK(!unknown.bracket);
  CHECK(unknown.undecided == std::vector<std::size_t>{0});
  CHECK(unknown.enclosures <= 200);
}

TEST_CASE("what is solved for along a stretch is held by its enclosure, with its slopes") {
  // Two blocks that their brakes hold, tied by a nonlinear loop; limits and the spring's force change. What holds them
  // is found by hand: u = 0 of both blocks with the loop solved by bisection.
  const CompiledModel model = compile_text(R"j({ "bgsim": 1, "name": "held", "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 2 }, "n1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 3 }, "F0": { "kind": "MSe", "effort": "0.3*sin(2*t)" },
      "F1": { "kind": "MSe", "effort": "0.2*cos(t)" }, "s": { "kind": "C", "capacitance": 4, "initial": { "q": 0.5 } },
      "b0": { "kind": "MR", "law": "e = (2 + cos(5*t))*sign(f)" }, "h": { "kind": "0" },
      "b1": { "kind": "MR", "law": "e = if(f > 0, 1 + s.q^2, -1 - s.q^2)" } },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "F0", "to": "n0" }, { "from": "n0", "to": "b0" },
      { "from": "n1", "to": "m1" }, { "from": "F1", "to": "n1" }, { "from": "n1", "to": "b1" },
      { "from": "n0", "to": "h" }, { "from": "h", "to": "n1" }, { "from": "h", "to": "s" } ],
    "outputs": { "v": "n0.f" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })j");
  const Program& program = model.program;
  SolvedAlong solved(program, model.inputs.parameters);
  std::vector<std::uint32_t> relations;
  for (const std::uint32_t relation : program.guarded)
    if (program.border_rates[relation].value.valid()) relations.push_back(relation);
  REQUIRE(relations.size() == 2);
  REQUIRE(solved.look_at({}, relations));
  const bool first_is_sign = program.relations[relations[0]].kind == Relation::Kind::sign;
  const auto charge = [](double t) { return 0.5 + 0.1 * t; };
  const auto of_sign = [&](double t) { return (0.3 * std::sin(2 * t) - charge(t) / 4) / (2 + std::cos(5 * t)); };
  const auto of_condition = [&](double t) {  // 0 on one side, 1 on the other
    return 0.5 + 0.5 * (0.2 * std::cos(t) + charge(t) / 4) / (1 + charge(t) * charge(t));
  };
  const auto mode = [&](std::size_t k, double t) { return (k == 0) == first_is_sign ? of_sign(t) : of_condition(t); };
  for (const double length : {0.5, 0.1, 0.01}) {
    const double from = 0.3, to = from + length, middle = from + length / 2;
    std::vector<Jet> states;
    for (const std::uint32_t state : solved.states())
      states.push_back(program.state_names[state] == "s.q"
                           ? Jet{charge(middle), {charge(from), charge(to)}, {0.1, 0.1}, 0.1, {0.0, 0.0}}
                           : Jet{0.0, {0.0, 0.0}, {0.0, 0.0}, 0.0, {0.0, 0.0}});
    const std::vector<double> modes(program.relations.size(), 0.0), centre{mode(0, middle), mode(1, middle)};
    REQUIRE(solved.enclose(from, to, states, modes, centre, {{-2.0, 2.0}, {-2.0, 2.0}}));
    for (std::size_t k = 0; k < 2; ++k) {
      Range values(mode(k, from), mode(k, from));
      for (int i = 0; i <= 100; ++i) {
        const double t = from + (to - from) * i / 100, d = 1e-6, slope = (mode(k, t + d) - mode(k, t - d)) / (2 * d);
        values = hull(values, Range(mode(k, t), mode(k, t)));
        CHECK(solved[k].value.lower() <= mode(k, t) + 1e-12);
        CHECK(solved[k].value.upper() >= mode(k, t) - 1e-12);
        CHECK(solved[k].slope.lower() <= slope + 1e-8);
        CHECK(solved[k].slope.upper() >= slope - 1e-8);
      }
      // What is more than the values falls with the length of the stretch.
      if (length == 0.01) CHECK(width(solved[k].value) <= 2.0 * width(values));
    }
  }
}
