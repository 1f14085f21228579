// Fits: what is found against what the data were made with.
#include <catch2/catch.hpp>
#include <random>

#include "fit_support.hpp"
#include "support/rounds.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

double charging(double t, double R, double C, double U, double q0) { return U + (q0 / C - U) * std::exp(-t / (R * C)); }

/// What noise-free data give back: runs are made with 1e-11, and errors of runs are some tens of that.
constexpr double kExact = 1e-8;

void check_values(const FitResult& result, const std::vector<double>& exact) {
  REQUIRE(result.values.size() == exact.size());
  CHECK(result.converged);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    INFO(result.values[i].name << " = " << result.values[i].value << " for " << exact[i]);
    CHECK(std::abs(result.values[i].value - exact[i]) <= kExact * std::abs(exact[i]));
  }
}

/// @p text with the one @p from replaced.
std::string with_text(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// A straight line as a model: u = a + b t, whose fit is linear regression.
std::string line() {
  return model_text(R"x("parameters": { "a": 1, "b": 1 }, "signals": { "y": { "integral": "b", "initial": "a" } },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "u": "y" }, "scenes": { "s": { "stop": 10, "relative": 1e-10 } })x");
}

}  // namespace

TEST_CASE("noise-free data give parameters and initial values back") {
  const Study study = Study::from_text(capacitor());
  const FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t, 1.4, 0.5, 3.7, 0.6); });
  const FitResult result = fit(study, plan_of({"R=0.1:10", "U", "c.q"}, {data}));
  check_values(result, {1.4, 3.7, 0.6});
  CHECK(result.notes.empty());
  CHECK(result.undetermined.empty());
  CHECK(result.residuals == 23);
  CHECK(result.matches.at(0).rms < 1e-9);
  CHECK(result.matches.at(0).start_rms > 0.1);
  CHECK(result.values.at(0).start == 2.0);
  CHECK(result.values.at(2).start == 0.25);
  CHECK(result.trace.names == std::vector<std::string>{"u", "data(u)"});
  CHECK(result.trace.times.size() == 23);
}

TEST_CASE("a fit begins with what --set says, and is the same on any number of threads") {
  const Study study = Study::from_text(capacitor());
  const FitData data = measured(times(0.0, 2.0, 9), [](double t) { return charging(t, 1.4, 0.8, 3.0, 0.25); });
  const FitPlan plan = plan_of({"R", "C=0.1:5"}, {data});
  const SceneOverrides overrides = with_parameters({"R=1", "C=1.2"});
  const FitResult one = fit(study, plan, overrides, {}, 1), four = fit(study, plan, overrides, {}, 4);
  CHECK(one.values.at(0).start == 1.0);
  CHECK(one.values.at(1).start == 1.2);
  check_values(one, {1.4, 0.8});
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(one.values[i].value == four.values[i].value);
    CHECK(one.values[i].error == four.values[i].error);
  }
}

TEST_CASE("the fit of a straight line is linear regression, with its standard errors and its correlation") {
  const Study study = Study::from_text(line());
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.3);
  const std::vector<double> at = times(0.0, 10.0, 21);
  const FitData data = measured(at, [&](double t) { return 2.0 - 0.7 * t + noise(random); });
  double n = 0, st = 0, stt = 0, sy = 0, sty = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double t = at[i], y = data.cells.table.columns[1][i];
    n += 1, st += t, stt += t * t, sy += y, sty += t * y;
  }
  const double det = n * stt - st * st, b = (n * sty - st * sy) / det, a = (sy - b * st) / n;
  double square = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) square += std::pow(a + b * at[i] - data.cells.table.columns[1][i], 2);
  const double variance = square / (n - 2);
  // Runs and derivatives are exact to some 1e-10 of their size.
  const auto same = [](double value) { return Approx(value).epsilon(1e-7); };

  const FitResult result = fit(study, plan_of({"a", "b"}, {data}));
  CHECK(result.values[0].value == same(a));
  CHECK(result.values[1].value == same(b));
  CHECK(result.values[0].error == same(std::sqrt(variance * stt / det)));
  CHECK(result.values[1].error == same(std::sqrt(variance * n / det)));
  CHECK(result.covariance[0][1] == same(-variance * st / det));
  CHECK(result.correlation[0][1] == same(-st / std::sqrt(n * stt)));
  CHECK(result.deviation == same(std::sqrt(variance)));
  // Student's t of 19 degrees of freedom: 2.09302 (tables)
  CHECK((result.values[0].high - result.values[0].value) / result.values[0].error == Approx(2.09302).epsilon(1e-5));

  // With the standard deviation of the measurement these are its consequences alone.
  const FitResult known = fit(study, plan_of({"a", "b"}, {data}, 0.5));
  CHECK(known.values[0].value == same(a));
  CHECK(known.values[0].error == same(0.5 * std::sqrt(stt / det)));
  CHECK(known.deviation == same(std::sqrt(variance) / 0.5));
  CHECK((known.values[0].high - known.values[0].value) / known.values[0].error == Approx(1.95996).epsilon(1e-5));
}

TEST_CASE("the 95 % confidence of noisy data holds what they were made with 95 times in 100", "[long]") {
  const Study study = Study::from_text(capacitor(R"("stop": 2, "samples": 11, "relative": 1e-8)"));
  constexpr int kRounds = 400;
  int R_inside = 0, U_inside = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::mt19937_64 random(static_cast<std::uint64_t>(round) + 1);
    std::normal_distribution<double> noise(0.0, 0.05);
    const FitData data =
        measured(times(0.1, 2.0, 20), [&](double t) { return charging(t, 1.4, 0.5, 3.7, 0.25) + noise(random); });
    const FitResult result = fit(study, plan_of({"R=0.1:10", "U"}, {data}));
    REQUIRE(result.converged);
    const auto inside = [&](std::size_t i, double exact) {
      return result.values[i].low <= exact && exact <= result.values[i].high;
    };
    R_inside += inside(0, 1.4);
    U_inside += inside(1, 3.7);
  }
  // Binomial of 400 at 0.95: 380 with a standard deviation of 4.36; beyond 366 to 394 once in a thousand.
  CHECK(R_inside >= 366);
  CHECK(R_inside <= 394);
  CHECK(U_inside >= 366);
  CHECK(U_inside <= 394);
}

TEST_CASE("a value that would leave its range sits on its bound, and the others are found for that") {
  const Study study = Study::from_text(line());
  const std::vector<double> at = times(0.0, 10.0, 21);
  const FitData data = measured(at, [](double t) { return 2.0 - 0.7 * t; });
  const FitResult result = fit(study, plan_of({"a=0:1.5", "b"}, {data}));
  CHECK(result.values[0].value == 1.5);
  CHECK(result.values[0].bound == 1);
  CHECK(std::isnan(result.values[0].error));
  CHECK(result.values[1].bound == 0);
  double tt = 0, ty = 0;
  for (const double t : at) tt += t * t, ty += t * (2.0 - 0.7 * t - 1.5);
  CHECK(result.values[1].value == Approx(ty / tt).epsilon(1e-7));
  CHECK(std::isfinite(result.values[1].error));
}

TEST_CASE("values that only matter together are said to be not told apart, with the direction") {
  const Study study = Study::from_text(capacitor());
  const FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t, 1.4, 0.5, 3.7, 0.0); });
  // From an empty capacitor R and C matter by R C alone; U is known by itself.
  const FitResult result = fit(study, plan_of({"R", "C", "U"}, {data}), with_parameters({"c.q=0"}));
  CHECK(result.converged);
  REQUIRE(result.undetermined.size() == 1);
  CHECK(result.undetermined[0].names == std::vector<std::string>{"R", "C"});
  // Relative changes that leave R C as it is; the derivatives are exact to some 1e-9.
  CHECK(result.undetermined[0].shares[0] / result.undetermined[0].shares[1] == Approx(-1.0).epsilon(1e-6));
  CHECK(std::isnan(result.values[0].error));
  CHECK(!result.values[0].determined);
  CHECK(result.values[0].value * result.values[1].value == Approx(0.7).epsilon(kExact));
  CHECK(result.values[2].determined);
  CHECK(result.values[2].value == Approx(3.7).epsilon(kExact));
  CHECK(std::isfinite(result.values[2].error));
}

TEST_CASE("degrees of freedom are counted by what the data determine, not by the number of values") {
  // u = a + b t with b = p + q: of p and q their sum alone matters, so that the data determine two numbers.
  const Study study = Study::from_text(model_text(
      R"x("parameters": { "a": 1, "p": 1, "q": 1 }, "signals": { "y": { "integral": "p + q", "initial": "a" } },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "u": "y" }, "scenes": { "s": { "stop": 10, "relative": 1e-10 } })x"));
  // What the points are off the line by has the sum 0, and 0 with the times as weights: no other line is nearer, and
  // the sum of squares is 4. Two numbers are determined by five points: 3 degrees of freedom.
  const std::vector<double> at{0.0, 2.5, 5.0, 7.5, 10.0}, off{1.0, -1.0, 0.0, -1.0, 1.0};
  const FitData data =
      measured(at, [&](double t) { return 2.0 - 0.7 * t + off[static_cast<std::size_t>(t / 2.5 + 0.5)]; });
  const FitResult result = fit(study, plan_of({"a", "p", "q"}, {data}));
  CHECK(result.converged);
  CHECK(!result.values[1].determined);
  CHECK(!result.values[2].determined);
  // Runs and derivatives are exact to some 1e-10 of their size.
  const auto same = [](double value) { return Approx(value).epsilon(1e-7); };
  CHECK(result.values[0].value == same(2.0));
  CHECK(result.deviation == same(std::sqrt(4.0 / 3.0)));
  // Linear regression: the variance of a is s^2 sum t^2/(n sum t^2 - (sum t)^2) = s^2 187.5/(5*187.5 - 625) = 0.6 s^2.
  CHECK(result.values[0].error == same(std::sqrt(4.0 / 3.0 * 0.6)));
  // Student's t of 3 degrees of freedom: 3.18245 (tables)
  CHECK((result.values[0].high - result.values[0].value) / result.values[0].error == Approx(3.18245).epsilon(1e-5));
}

TEST_CASE("models without sensitivities are fitted by differences of runs, which a note says") {
  const std::string model = model_text(R"x("parameters": { "R": 2, "U": 3 },
    "elements": { "s": { "kind": "Se", "effort": "U" }, "w": { "kind": "Sw", "closed": "t < 1" }, "one": { "kind": "1" },
      "r": { "kind": "R", "resistance": "R" }, "c": { "kind": "C", "capacitance": 0.5 } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "w" }, { "from": "one", "to": "r" },
      { "from": "one", "to": "c" } ], "outputs": { "u": "c.e" }, "scenes": { "s": { "stop": 2, "relative": 1e-11 } })x");
  const FitData data =
      measured(times(0.0, 2.0, 21), [](double t) { return 3.3 * (1.0 - std::exp(-std::min(t, 1.0) / 0.65)); });
  const FitResult result = fit(Study::from_text(model), plan_of({"R=0.2:9", "U"}, {data}));
  check_values(result, {1.3, 3.3});
  REQUIRE(result.notes.size() == 1);
  CHECK_THAT(result.notes[0], Contains("differences of runs") && Contains("ideal switches"));
}

TEST_CASE("cells may be missing, rows outside of the scene are counted, times are as they come") {
  const Study study = Study::from_text(capacitor());
  std::string text = "remark,seconds,u\n";
  for (const double t : {-0.3, 0.0, 0.017, 0.4, 0.41, 1.3, 1.7, 2.0, 2.5}) {
    const std::string u = t == 0.4 ? "" : t == 0.41 ? "NaN" : number_text(charging(t, 1.4, 0.5, 3.7, 0.25), 17);
    text += "a word," + number_text(t, 17) + "," + u + "\r\n";
  }
  FitPlan plan = plan_of({"R", "U"}, {fit_data("", "rows.csv", text)});
  plan.time = "seconds";
  const FitResult result = fit(study, plan);
  check_values(result, {1.4, 3.7});
  CHECK(result.residuals == 5);
  CHECK(result.matches[0].rows == 5);
  CHECK(result.matches[0].missing == 2);
  REQUIRE(result.notes.size() == 1);
  CHECK_THAT(result.notes[0], Contains("rows.csv: 2 of 9 rows are outside"));
}

TEST_CASE("outliers pull a robust loss less than squares") {
  const Study study = Study::from_text(line());
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, 0.1);
  int count = 0;
  const FitData data = measured(
      times(0.0, 10.0, 41), [&](double t) { return 2.0 - 0.7 * t + noise(random) + (++count % 10 == 0 ? 5.0 : 0.0); });
  FitPlan plan = plan_of({"a", "b"}, {data}, 0.1);
  const FitResult squares = fit(study, plan);
  plan.loss = FitLoss::huber;
  plan.loss_at = 1.5;
  const FitResult huber = fit(study, plan);
  plan.loss = FitLoss::cauchy;
  const FitResult cauchy = fit(study, plan);
  // Four outliers of 5 in 41: the line is half of a unit off; and within two standard errors of some 0.04 without them.
  CHECK(std::abs(squares.values[0].value + 5.0 * squares.values[1].value - (2.0 - 3.5)) > 0.3);
  for (const FitResult* robust : {&huber, &cauchy}) {
    CHECK(robust->converged);
    CHECK(std::abs(robust->values[0].value - 2.0) < 0.15);
    CHECK(std::abs(robust->values[1].value + 0.7) < 0.03);
    CHECK(std::isfinite(robust->values[0].error));
  }
}

TEST_CASE("several scenes with their data are fitted with one set of values") {
  const Study study = Study::from_text(capacitor(
      R"("stop": 2, "relative": 1e-11 }, "empty": { "stop": 3, "relative": 1e-11, "initial": { "c.q": 0 },
         "parameters": { "U": 5 })"));
  const FitData charge = measured(
      times(0.1, 2.0, 7), [](double t) { return charging(t, 1.4, 0.6, 3.0, 0.25); }, "charge");
  const FitData empty = measured(
      times(0.1, 3.0, 5), [](double t) { return charging(t, 1.4, 0.6, 5.0, 0.0); }, "empty");
  const FitResult result = fit(study, plan_of({"R", "C"}, {charge, empty}));
  check_values(result, {1.4, 0.6});
  REQUIRE(result.matches.size() == 2);
  CHECK(result.matches[0].scene == "charge");
  CHECK(result.matches[1].scene == "empty");
  CHECK(result.matches[1].rows == 5);
  CHECK(result.residuals == 12);
}

TEST_CASE("a fit that ends within a standard error says how far it is, and that runs may hide the rest") {
  const Study study = Study::from_text(capacitor(R"("stop": 2, "samples": 11, "relative": 1e-6)"));
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.3);
  const FitData data =
      measured(times(0.1, 2.0, 20), [&](double t) { return charging(t, 1.4, 0.5, 3.7, 0.25) + noise(random); });
  FitPlan plan = plan_of({"R=0.1:10", "U"}, {data});
  // Newton's steps come nearer by a square each: the second leaves some tenth of a standard error.
  plan.iterations = 2;
  const FitResult result = fit(study, plan);
  CHECK(!result.converged);
  CHECK_THAT(result.stopped, Catch::StartsWith("the limit of iterations was reached, 0.") &&
                                 Contains("of a standard error from the least sum of squares, where 0.01 is enough") &&
                                 Contains("--relative 1e-09"));
  plan.iterations = 20;
  CHECK(fit(study, plan).stopped == "converged");
}

TEST_CASE("a global search finds a frequency that no local one does") {
  const std::string model = model_text(R"x("parameters": { "k": 1, "m": 1 },
    "elements": { "mass": { "kind": "I", "inertance": "m", "initial": { "p": "m" } }, "one": { "kind": "1" },
      "spring": { "kind": "C", "capacitance": "1/k" } },
    "bonds": [ { "from": "one", "to": "mass" }, { "from": "one", "to": "spring" } ],
    "outputs": { "u": "mass.f" }, "scenes": { "s": { "stop": 10, "relative": 1e-10 } })x");
  const Study study = Study::from_text(model);
  const FitData data = measured(times(0.0, 10.0, 101), [](double t) { return std::cos(7.0 * t); });
  FitPlan plan = plan_of({"k=0.5:100"}, {data});
  const FitResult local = fit(study, plan);
  CHECK(std::abs(local.values[0].value - 49.0) > 1.0);
  plan.global_runs = 100;
  const FitResult global = fit(study, plan);
  CHECK(global.values[0].value == Approx(49.0).epsilon(kExact));
  CHECK(global.values[0].start == 1.0);
  CHECK(global.runs > 100);
}

TEST_CASE("points at which the model has no run are stepped back from") {
  // The first step from a = 400 goes below 0, where its root is no number.
  const std::string model =
      with_text(capacitor(R"("stop": 2, "relative": 1e-11)"), "\"resistance\": \"R\"", "\"resistance\": \"sqrt(R)\"");
  const FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t, 0.3, 0.5, 3.0, 0.25); });
  const FitResult result = fit(Study::from_text(model), plan_of({"R"}, {data}), with_parameters({"R=400"}));
  check_values(result, {0.09});
}

TEST_CASE("a run that ends before the data, since its end follows what is varied, is stepped back from and named") {
  // stop = R: with R < 2 the rows at t = 2 are missing. The best R is 1.
  const Study study = Study::from_text(capacitor(R"("stop": "R", "samples": 11, "relative": 1e-11)"));
  const auto charge = [](double tau) { return [tau](double t) { return 3.0 - 2.5 * std::exp(-t / tau); }; };
  FitPlan plan = plan_of({"R"}, {measured(times(0.0, 2.0, 21), charge(0.5))});
  plan.iterations = 20;
  const FitResult stuck = fit(study, plan);
  CHECK_FALSE(stuck.converged);
  CHECK(stuck.values[0].value >= 2.0);
  CHECK_THAT(stuck.stopped, Contains("steps led to values whose runs fail, the last of them with BG417") &&
                                Contains("before the last row at t = 2"));
  // To the other side there is nothing in the way.
  check_values(fit(study, plan_of({"R"}, {measured(times(0.0, 2.0, 21), charge(1.5))})), {3.0});
}

TEST_CASE("a fit by a parameter that the start of the scene follows takes differences, and finds it") {
  // Held, the start has no derivative: 100 iterations did not come to the least sum of squares.
  const Study study = Study::from_text(capacitor(R"("start": "-R", "stop": 2, "samples": 11, "relative": 1e-11)"));
  const FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t + 1.4, 1.4, 0.5, 3.0, 0.25); });
  const FitResult result = fit(study, plan_of({"R"}, {data}));
  check_values(result, {1.4});
  CHECK_THAT(result.notes.front(), Contains("the start of scene \"charge\" moves with \"R\""));
}

TEST_CASE("constant data beside others are compared in parts of their value, which a note says") {
  const Study study = Study::from_text(capacitor());
  FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t, 1.4, 0.5, 3.0, 0.25); });
  for (const double level : {3.0, 0.0}) {
    data.cells.table.names = {"t", "u", "s"};
    data.cells.table.columns.resize(2);
    data.cells.table.columns.push_back(std::vector<double>(23, level));
    data.cells.faults.resize(3);
    FitPlan plan = plan_of({"R"}, {data});
    plan.matches.push_back({"s", "s", 0.0});
    const FitResult result = fit(study, plan);
    check_values(result, {1.4});
    CHECK_THAT(result.notes.front(), Contains("the data of \"s\" are constant") &&
                                         Contains(level == 0.0 ? "as they are" : "in parts of their value"));
  }
}

TEST_CASE("a value on neither side of which the model runs is refused") {
  const std::string model =
      with_text(capacitor(), "\"resistance\": \"R\"", "\"resistance\": \"1 + sqrt(R - 2)*sqrt(2 - R)\"");
  const FitData data = measured(times(0.1, 1.9, 5), [](double t) { return t; });
  CHECK_THROWS_WITH(fit(Study::from_text(model), plan_of({"R"}, {data})), Contains("BG420"));
}

TEST_CASE("a fit that is interrupted, or has too few iterations, says so") {
  const Study study = Study::from_text(capacitor());
  const FitData data = measured(times(0.05, 1.95, 23), [](double t) { return charging(t, 1.4, 0.5, 3.7, 0.6); });
  FitPlan plan = plan_of({"R", "U", "c.q"}, {data});
  SimulateOptions how;
  how.progress = [](double) { return false; };
  CHECK_THROWS_WITH(fit(study, plan, {}, how), Contains("BG606"));
  plan.iterations = 1;
  const FitResult result = fit(study, plan);
  CHECK(!result.converged);
  CHECK(result.stopped == "the limit of iterations was reached");
}

TEST_CASE("each row has its own weight: weighted linear regression") {
  const Study study = Study::from_text(line());
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 1.0);
  const std::vector<double> at = times(0.0, 10.0, 21);
  std::vector<double> sigma;
  for (std::size_t i = 0; i < at.size(); ++i) sigma.push_back(i % 3 == 0 ? 2.0 : 0.1 + 0.02 * at[i]);
  std::size_t row = 0;
  FitData data = measured(at, [&](double t) { return 2.0 - 0.7 * t + sigma[row++] * noise(random); });
  data.cells.table.names.emplace_back("s");
  data.cells.table.columns.push_back(sigma);
  data.cells.faults.emplace_back();
  double n = 0, st = 0, stt = 0, sy = 0, sty = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double t = at[i], y = data.cells.table.columns[1][i], w = 1.0 / (sigma[i] * sigma[i]);
    n += w, st += w * t, stt += w * t * t, sy += w * y, sty += w * t * y;
  }
  const double det = n * stt - st * st;
  // Runs and derivatives are exact to some 1e-10 of their size.
  const auto same = [](double value) { return Approx(value).epsilon(1e-7); };
  FitPlan plan = plan_of({"a", "b"}, {data});
  plan.matches[0].sigma_column = "s";
  const FitResult result = fit(study, plan);
  CHECK(result.known_sigma);
  CHECK(result.values[0].value == same((sy * stt - st * sty) / det));
  CHECK(result.values[1].value == same((n * sty - st * sy) / det));
  CHECK(result.values[0].error == same(std::sqrt(stt / det)));
  CHECK(result.values[1].error == same(std::sqrt(n / det)));
  const auto refused = [&](double value, const std::string& column) {
    plan.data[0].cells.table.columns[2][4] = value;
    plan.matches[0].sigma_column = column;
    try {
      static_cast<void>(fit(study, plan));
    } catch (const ModelError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refused(0.0, "s"), Contains("BG417") && Contains("data.csv:6") && Contains("is 0"));
  CHECK_THAT(refused(std::numeric_limits<double>::quiet_NaN(), "s"), Contains("BG417") && Contains("is missing"));
  CHECK_THAT(refused(1.0, "sd"), Contains("BG418") && Contains("no column \"sd\""));
}

TEST_CASE("further starts find the least of several minima, and say how many came to it", "[long]") {
  const Study study =
      Study::from_text(model_text(R"x("parameters": { "w": 1 }, "elements": { "cap": { "kind": "C", "capacitance": 1 },
      "res": { "kind": "R", "resistance": 1 } }, "bonds": [ { "from": "cap", "to": "res" } ],
    "signals": { "y": { "integral": "w*cos(w*t)", "initial": 0 } },
    "outputs": { "u": "y" }, "scenes": { "s": { "stop": 5, "relative": 1e-10 } })x"));
  const FitData data = measured(times(0.0, 5.0, 21), [](double t) { return std::sin(5.0 * t); });
  FitPlan plan = plan_of({"w=0.5:8"}, {data});
  const FitResult alone = fit(study, plan);
  REQUIRE(std::abs(alone.values[0].value - 5.0) > 0.5);
  plan.starts = 14;
  const FitResult one = fit(study, plan, {}, {}, 1), four = fit(study, plan, {}, {}, 4);
  check_values(one, {5.0});
  CHECK(one.values[0].start == 1.0);
  CHECK(one.starts == 15);
  CHECK(one.same >= 1);
  CHECK(one.same < 15);
  CHECK_FALSE(one.notes.empty());
  CHECK(four.values[0].value == one.values[0].value);
  CHECK(four.same == one.same);
  // A range without an end has no points to start from.
  FitPlan open = plan_of({"w"}, {data});
  open.starts = 3;
  CHECK_THROWS_WITH(fit(study, open), Contains("has no range to be searched"));
}
