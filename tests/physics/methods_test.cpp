// Runge-Kutta and fixed-step methods: order of convergence on exact solutions, events, dense output, refusals.
#include <catch2/catch.hpp>
#include <numbers>
#include <span>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Mass, spring and, unless @p damping is empty, damper; q(0) = 1.
std::string oscillator(const std::string& spring_law, const std::string& damping, const std::string& scene) {
  const std::string damper = damping.empty() ? "" : R"(, "d": { "kind": "R", "resistance": )" + damping + " }";
  const std::string bond = damping.empty() ? "" : R"(, { "from": "j", "to": "d" })";
  return R"json({ "bgsim": 1, "name": "oscillator",
    "elements": { "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
      "s": { "kind": "C", "law": ")json" +
         spring_law + R"json(", "initial": { "q": 1 } })json" + damper + R"json( },
    "bonds": [ { "from": "j", "to": "m" }, { "from": "j", "to": "s" })json" +
         bond + R"json( ], "outputs": { "q": "s.q", "p": "m.p" }, "scenes": { "main": )json" + scene + " } }";
}

SceneOverrides fixed(Method method, double step) {
  SceneOverrides overrides;
  overrides.method = method;
  overrides.step = step;
  return overrides;
}

/// q'' + c q' + q = 0, q(0) = 1, q'(0) = 0.
double damped(double t, double c) {
  const double w = std::sqrt(1.0 - c * c / 4.0);
  return std::exp(-c * t / 2.0) * (std::cos(w * t) + c / (2.0 * w) * std::sin(w * t));
}

double largest_error_of_q(const RunResult& result, double damping) {
  REQUIRE(result.stop == StopReason::completed);
  const std::vector<double> q = column(result, "q");
  double largest = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i)
    largest = std::max(largest, std::abs(q[i] - damped(result.trace.times[i], damping)));
  return largest;
}

/// Methods to be held against one another, with steps that serve the test where these are of one length.
std::vector<SceneOverrides> every_method(double relative, double step) {
  std::vector<SceneOverrides> all;
  for (const MethodFacts& facts : all_methods())
    all.push_back(facts.fixed_step() ? fixed(facts.method, step) : with_method(facts.method, relative));
  return all;
}

}  // namespace

TEST_CASE("methods with steps of one length converge with their order at and between the steps") {
  const auto [method, order, damping] = GENERATE(table<Method, double, std::string>({{Method::euler, 1, "0.3"},
                                                                                     {Method::implicit_euler, 1, "0.3"},
                                                                                     {Method::rk4, 4, "0.3"},
                                                                                     {Method::verlet, 2, ""}}));
  const double c = damping.empty() ? 0.0 : 0.3;
  CompiledModel model =
      compile_text(oscillator("e = q", damping, R"({ "stop": 6, "interval": 0.07 })"), fixed(method, 0.02));
  // 0.07 is no multiple of the steps, so the polynomial between them is judged as well
  const double coarse = largest_error_of_q(model.run(), c);
  model.inputs.step = 0.01;
  const RunResult result = model.run();
  const double fine = largest_error_of_q(result, c);
  CHECK(result.report.steps == 600);
  CHECK(result.report.step == 0.01);
  // the next term of the error's expansion is of the relative size of the step
  CHECK(std::log2(coarse / fine) == Approx(order).margin(0.05));
}

TEST_CASE("rows at the ends of steps of one length are the method's own values") {
  // Of q' = -q. Each row was the mean of two steps of Euler's methods, and of as good an order.
  constexpr double h = 0.25;
  const auto [method, factor] =
      GENERATE(table<Method, double>({{Method::euler, 1.0 - h},
                                      {Method::implicit_euler, 1.0 / (1.0 + h)},
                                      {Method::rk4, 1.0 - h + h * h / 2.0 - h * h * h / 6.0 + h * h * h * h / 24.0}}));
  const RunResult result = run_text(R"({ "bgsim": 1,
      "elements": { "j": { "kind": "1" }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
                    "r": { "kind": "R", "resistance": 1 } },
      "bonds": [{ "from": "j", "to": "c" }, { "from": "j", "to": "r" }],
      "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 2, "interval": 0.125 } } })",
                                    fixed(method, h));
  const std::span<const double> q = result.trace["q"];
  REQUIRE(q.size() == 17);
  for (std::size_t row = 0; row < q.size(); row += 2) {
    CAPTURE(method_name(method), row);
    CHECK(q[row] == Approx(std::pow(factor, static_cast<double>(row / 2))).epsilon(1e-14));
  }
  // Between the ends a straight line for methods of order one.
  if (method != Method::rk4) CHECK(q[1] == Approx((q[0] + q[2]) / 2.0).epsilon(1e-14));
}

TEST_CASE("Runge-Kutta methods reach the tolerance with the steps that their order lets expect") {
  const auto [method, order] = GENERATE(table<Method, double>({{Method::erk2, 2},
                                                               {Method::erk3, 3},
                                                               {Method::erk4, 4},
                                                               {Method::erk5, 5},
                                                               {Method::erk6, 6},
                                                               {Method::erk8, 8},
                                                               {Method::dirk2, 2},
                                                               {Method::dirk3, 3},
                                                               {Method::dirk4, 4},
                                                               {Method::dirk5, 5},
                                                               {Method::radau, 4},    // held, of 5
                                                               {Method::radau9, 6},   // held, of 9
                                                               {Method::radau13, 8},  // held, of 13
                                                               {Method::rodas5p, 4}}));
  CompiledModel model =
      compile_text(oscillator("e = q", "0.3", R"({ "stop": 20, "samples": 2 })"), with_method(method, 1e-5));
  const RunResult loose = model.run();
  model.inputs.relative = 1e-8;
  const RunResult tight = model.run();
  CAPTURE(method_name(method), loose.report.steps, tight.report.steps);
  // Errors of a step add up where the solution forgets slowly: by some tens of tolerances over three periods. TR-BDF2
  // holds its own error at the tolerance, the others that of their companion of lower order: it errs in every step.
  const double added_up = method == Method::dirk2 ? 200 : 50;
  CHECK(largest_error_of_q(loose, 0.3) < added_up * 1e-5);
  CHECK(largest_error_of_q(tight, 0.3) < added_up * 1e-8);
  // the controller holds the lower of two orders: steps grow as tolerance^(-1/q) to ^(-1/(q + 1)), as q is held or not
  const double growth = static_cast<double>(tight.report.steps) / static_cast<double>(loose.report.steps);
  CHECK(growth > 0.7 * std::pow(1e3, 1.0 / (order + 1.0)));
  CHECK(growth < 1.3 * std::pow(1e3, 1.0 / order));
}

TEST_CASE("explicit methods use no Jacobian and implicit ones the exact one") {
  const std::string text = oscillator("e = q + q^3", "0.3", R"({ "stop": 5, "samples": 2 })");
  const RunResult erk = run_text(text, with_method(Method::erk5));
  CHECK(erk.report.jacobian_evaluations == 0);
  CHECK(erk.report.factorizations == 0);
  CHECK(erk.report.method == "ARKODE Dormand-Prince 5(4)");
  const RunResult dirk = run_text(text, with_method(Method::dirk4));
  CHECK(dirk.report.jacobian_evaluations > 0);
  CHECK(dirk.report.factorizations >= dirk.report.jacobian_evaluations);
  CHECK(dirk.report.method == "ARKODE ESDIRK436L2SA 4(3), dense");
}

TEST_CASE("every method finds the change of a condition and goes on from there") {
  // stiffness 1 in tension, 4 in compression: half periods of pi and pi/2, back at q = 1 after both
  CompiledModel model = compile_text(oscillator("e = if(q > 0, q, 4*q)", "", R"({ "stop": 1, "samples": 2 })"));
  model.inputs.stop = 1.5 * std::numbers::pi;
  model.inputs.output_times = {0.0, std::numbers::pi / 2.0, model.inputs.stop};
  for (const SceneOverrides& how : every_method(1e-7, 1e-3)) {
    model.inputs.method = how.method.value();
    model.inputs.step = how.step.value_or(0.0);
    model.inputs.relative = how.relative.value_or(1e-6);
    CAPTURE(method_name(model.inputs.method));
    const RunResult result = model.run();
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.state_events == 2);
    // Euler's methods gain or lose amplitude by half the step for each radian of frequency squared: 0.24 % and 0.5 %
    const int order = facts_of(model.inputs.method).order;
    const double allowed = order == 1 ? 1e-2 : 1e-5;
    CHECK(std::abs(column(result, "q")[1]) < allowed);
    CHECK(last(result, "q") == Approx(1.0).margin(allowed));
  }
}

TEST_CASE("every method but IDA and Störmer-Verlet lets dry friction hold a mass") {
  // m = 1, v = 1, F = 1: at rest from t = 1 on, after 0.5
  const std::string text = R"json({ "bgsim": 1, "name": "slider",
    "elements": { "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } },
      "way": { "kind": "C", "law": "e = 1e-9*q" }, "d": { "kind": "R", "law": "e = sign(f)" } },
    "bonds": [ { "from": "j", "to": "m" }, { "from": "j", "to": "way" }, { "from": "j", "to": "d" } ],
    "outputs": { "q": "way.q", "p": "m.p" }, "scenes": { "main": { "stop": 3, "samples": 4 } } })json";
  CompiledModel model = compile_text(text);
  for (const SceneOverrides& how : every_method(1e-6, 1e-2)) {
    model.inputs.method = how.method.value();
    if (model.inputs.method == Method::ida || model.inputs.method == Method::verlet) continue;
    model.inputs.step = how.step.value_or(0.0);
    CAPTURE(method_name(model.inputs.method));
    const RunResult result = model.run();
    REQUIRE(result.stop == StopReason::completed);
    CHECK(std::abs(last(result, "p")) < 1e-6);
    // the way is a quadratic that Euler's methods miss by half a step
    CHECK(last(result, "q") == Approx(0.5).margin(facts_of(model.inputs.method).order == 1 ? 6e-3 : 1e-5));
  }
}

TEST_CASE("implicit Runge-Kutta methods take a stiff system with long steps", "[long]") {
  // a mode that dies within 1e-6 beside one of 1
  const std::string text = R"json({ "bgsim": 1, "name": "stiff",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "a": { "kind": "1" }, "r1": { "kind": "R", "resistance": 1 },
      "n": { "kind": "0" }, "c1": { "kind": "C", "capacitance": 1 }, "b": { "kind": "1" },
      "r2": { "kind": "R", "resistance": 1 }, "c2": { "kind": "C", "capacitance": 1e-6 } },
    "bonds": [ { "from": "s", "to": "a" }, { "from": "a", "to": "r1" }, { "from": "a", "to": "n" },
      { "from": "n", "to": "c1" }, { "from": "n", "to": "b" }, { "from": "b", "to": "r2" }, { "from": "b", "to": "c2" } ],
    "outputs": { "v": "c1.e", "w": "c2.e" }, "scenes": { "main": { "stop": 10, "samples": 101 } } })json";
  const RunResult reference = run_text(text, with_method(Method::bdf, 1e-11));
  for (const Method method : {Method::dirk2, Method::dirk3, Method::dirk4, Method::dirk5, Method::radau, Method::radau9,
                              Method::radau13, Method::rodas5p}) {
    CAPTURE(method_name(method));
    const RunResult result = run_text(text, with_method(method, 1e-6));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.steps < 2000);
    for (const char* name : {"v", "w"}) {
      const std::vector<double> ours = column(result, name), exact = column(reference, name);
      for (std::size_t i = 0; i < ours.size(); ++i) CHECK(std::abs(ours[i] - exact[i]) < 1e-4);  // 100 tolerances
    }
  }
  // an explicit method is held to about 3 over the fastest rate, whatever the tolerance: 10 * 1e6 / 3.3
  SimulateOptions options;
  options.max_steps = 100000;
  const RunResult result = run_text(text, with_method(Method::erk5, 1e-3), options);
  CHECK(result.stop == StopReason::failed);
  CHECK(result.failure.value().code == "BG607");
  CHECK(result.report.reached < 1.0);
}

TEST_CASE("implicit Euler is stable with steps far beyond the fastest mode and explicit Euler is not") {
  const std::string text = oscillator("e = q", "1000", R"({ "stop": 100, "samples": 2 })");
  const RunResult implicit = run_text(text, fixed(Method::implicit_euler, 1.0));
  REQUIRE(implicit.stop == StopReason::completed);
  CHECK(last(implicit, "q") == Approx(std::exp(-0.1)).margin(1e-3));
  const RunResult explicit_one = run_text(text, fixed(Method::euler, 1.0));
  // (1 - 1000)^100 is just below 1e300
  CHECK((explicit_one.stop == StopReason::failed || std::abs(last(explicit_one, "q")) > 1e100));
}

TEST_CASE("Störmer-Verlet keeps the energy of a lossless nonlinear oscillator over a thousand periods", "[long]") {
  CompiledModel model =
      compile_text(oscillator("e = q + q^3", "", R"({ "stop": 5000, "samples": 5001 })"), fixed(Method::verlet, 0.02));
  const RunResult result = model.run();
  REQUIRE(result.stop == StopReason::completed);
  const std::vector<double> q = column(result, "q"), p = column(result, "p");
  double least = 1e9, most = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double energy = p[i] * p[i] / 2.0 + q[i] * q[i] / 2.0 + std::pow(q[i], 4) / 4.0;
    least = std::min(least, energy);
    most = std::max(most, energy);
  }
  // the energy swings by (step * frequency)^2 / 8 or so, and does not drift
  CHECK(most - least < 1e-3 * 0.75);
  CHECK(result.report.energy.relative < 1e-3);
  CHECK(result.report.rate_evaluations < 5 * result.report.steps);
}

TEST_CASE("Störmer-Verlet takes two capacitors that a gyrator couples") {
  const std::string text = R"json({ "bgsim": 1, "name": "gyrator",
    "elements": { "a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "g": { "kind": "GY", "modulus": 1 },
      "b": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "a", "to": "g" }, { "from": "g", "to": "b" } ],
    "outputs": { "q": "a.q" }, "scenes": { "main": { "stop": 6, "samples": 61 } } })json";
  const RunResult result = run_text(text, fixed(Method::verlet, 1e-3));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(last(result, "q") == Approx(std::cos(6.0)).margin(1e-6));  // step^2 * t / 24
}

TEST_CASE("a limited order makes short work of a fast mode that hardly dies") {
  // BDF of order 3 to 5 is not stable along the imaginary axis: its steps stay at the fast mode's time, 1e-3, although
  // the mode has died out after 5 and the drive has a period of 21
  const std::string text = R"json({ "bgsim": 1, "name": "driven",
    "elements": { "u": { "kind": "Se", "effort": "1e6*sin(0.3*t)" }, "j": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1 }, "s": { "kind": "C", "capacitance": 1e-6, "initial": { "q": 1 } },
      "d": { "kind": "R", "resistance": 2 } },
    "bonds": [ { "from": "u", "to": "j" }, { "from": "j", "to": "m" }, { "from": "j", "to": "s" }, { "from": "j", "to": "d" } ],
    "outputs": { "q": "s.q" }, "scenes": { "main": { "stop": 20, "samples": 2, "relative": 1e-3, "max_order": 2 } } })json";
  CompiledModel model = compile_text(text);
  const RunResult limited = model.run();
  model.inputs.max_order = 0;
  model.inputs.method = Method::bdf;
  const RunResult free = model.run();
  REQUIRE(free.stop == StopReason::completed);
  REQUIRE(limited.stop == StopReason::completed);
  CHECK(limited.report.method == "CVODE BDF of order up to 2, dense");
  CHECK(free.report.method == "CVODE BDF, dense");
  CHECK(2 * limited.report.steps < free.report.steps);
  CHECK(last(limited, "q") == Approx(std::sin(6.0)).margin(1e-2));
}
