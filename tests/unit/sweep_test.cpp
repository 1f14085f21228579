// Which values the runs of a sweep have, what is kept of them, and that neither order nor threads matter.
#include "bgsim/sweep.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

namespace {

using namespace bgsim;
using Catch::Contains;

SweepPlan plan_of(const std::vector<std::string>& vary, const std::string& sample = {}, std::uint64_t seed = 1) {
  SweepPlan plan;
  for (const std::string& text : vary) plan.variations.push_back(parse_variation(text));
  if (!sample.empty()) parse_sampling(sample, plan);
  plan.seed = seed;
  return plan;
}

std::string fault_of(const std::vector<std::string>& vary, const std::string& sample = {}) {
  try {
    const SweepPoints points(plan_of(vary, sample));
  } catch (const SweepError& error) {
    return error.what();
  }
  return {};
}

const char* const kText = R"({ "bgsim": 1, "name": "rc",
  "parameters": { "R": { "value": 2, "unit": "ohm" }, "C": { "value": 0.5, "unit": "F" }, "U": { "value": 3, "unit": "V" },
                  "part": 7 },
  "elements": { "s": { "kind": "Se", "effort": "U" }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
    "c": { "kind": "C", "capacitance": "C" } },
  "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
  "outputs": { "u": { "value": "c.e", "unit": "V" }, "i": "r.f" },
  "scenes": { "charge": { "stop": 4, "samples": 3, "relative": 1e-9 } } })";

std::string result_fault(const std::string& text) {
  try {
    const SweepResults results(Study::from_text(kText).model(), "", {{"x", text}});
  } catch (const SweepError& error) {
    return error.what();
  }
  return {};
}

struct Swept {
  std::map<std::uint64_t, SweepRun> runs;
  std::vector<std::string> names;
};

Swept swept(const SweepPlan& plan, const std::vector<std::pair<std::string, std::string>>& wanted, unsigned threads) {
  const Study first = Study::from_text(kText);
  const SweepResults results(first.model(), "", wanted);
  ReadOptions reading;
  reading.outputs = results.further_outputs();
  reading.record = results.outputs();
  const Study study(std::make_shared<const Model>(read_model_text("rc.json", kText, reading)));
  const SweepPoints points(plan);
  Swept all{{}, results.names()};
  SweepOptions options;
  options.threads = threads;
  options.next = [&, next = std::uint64_t{0}]() mutable -> std::optional<std::uint64_t> {
    return next < points.size() ? std::optional(next++) : std::nullopt;
  };
  options.done = [&](const SweepRun& run, const RunResult&) { all.runs.emplace(run.index, run); };
  sweep(study.scene(), "", {}, points, results, options);
  return all;
}

}  // namespace

TEST_CASE("a grid has all combinations, the last quantity fastest") {
  const SweepPoints points(plan_of({"a=1,3", "b=log(1:100:3)", "c=0:1:2"}));
  REQUIRE(points.size() == 12);
  CHECK(points.at(0) == std::vector<double>{1, 1, 0});
  CHECK(points.at(1) == std::vector<double>{1, 1, 1});
  CHECK(points.at(2)[1] == Approx(10.0).epsilon(1e-15));
  CHECK(points.at(11) == std::vector<double>{3, 100, 1});
}

TEST_CASE("Latin hypercubes and Sobol's points have one value in each equally probable part of each quantity") {
  // Of Sobol's sequence that holds for 2^k points, shifted or not.
  for (const char* const sample : {"lhs:64", "sobol:64"})
    for (const std::uint64_t seed : {1U, 2U, 77U}) {
      const SweepPoints points(plan_of({"a=0:64", "b=uniform(0,64)", "c=0:64"}, sample, seed));
      for (std::size_t quantity = 0; quantity < 3; ++quantity) {
        std::set<int> parts;
        for (std::uint64_t i = 0; i < points.size(); ++i) parts.insert(static_cast<int>(points.at(i)[quantity]));
        CHECK(parts.size() == 64);
      }
      // Two quantities together: each of 8 x 8 squares has a point of Sobol's, as a net of these dimensions has.
      if (std::string(sample) == "sobol:64") {
        std::set<int> squares;
        for (std::uint64_t i = 0; i < points.size(); ++i)
          squares.insert(8 * static_cast<int>(points.at(i)[0] / 8.0) + static_cast<int>(points.at(i)[1] / 8.0));
        CHECK(squares.size() == 64);
      }
    }
  CHECK(SweepPoints(plan_of({"a=0:1"}, "sobol:8", 1)).at(3) != SweepPoints(plan_of({"a=0:1"}, "sobol:8", 2)).at(3));
}

TEST_CASE("samples have the moments of their distributions") {
  // 2^14 points of Sobol's sequence: means are right to some 1e-3 of the deviation.
  constexpr std::uint64_t kRuns = 16384;
  const SweepPoints points(plan_of(
      {"n=normal(3,0.5)", "l=lognormal(2,0.4)", "t=triangular(1,2,5)", "g=log(1:100)", "d=1,2,4"}, "sobol:16384"));
  std::vector<double> sum(5), squares(5);
  for (std::uint64_t i = 0; i < kRuns; ++i) {
    const std::vector<double> x = points.at(i);
    for (std::size_t k = 0; k < 5; ++k) {
      const double y = k == 1 || k == 3 ? std::log(x[k]) : x[k];
      sum[k] += y / kRuns;
      squares[k] += y * y / kRuns;
    }
  }
  const auto near = [](double a, double b) { return std::abs(a - b) < 2e-3; };
  CHECK((near(sum[0], 3.0) && near(squares[0] - sum[0] * sum[0], 0.25)));
  CHECK((near(sum[1], std::log(2.0)) && near(squares[1] - sum[1] * sum[1], 0.16)));
  CHECK((near(sum[2], 8.0 / 3.0) && near(squares[2] - sum[2] * sum[2], 13.0 / 18.0)));
  CHECK(near(sum[3], std::log(10.0)));
  CHECK(near(sum[4], 7.0 / 3.0));
}

TEST_CASE("what is no variation and no sample is refused with the text") {
  CHECK_THAT(fault_of({"k"}), Contains("it has no \"=\""));
  CHECK_THAT(fault_of({"=1"}), Contains("names nothing"));
  CHECK_THAT(fault_of({"k="}), Contains("nothing behind"));
  CHECK_THAT(fault_of({"k=1,b"}), Contains("\"b\" is no number"));
  CHECK_THAT(fault_of({"k=1,nan"}), Contains("\"nan\" is no number"));
  CHECK_THAT(fault_of({"k=1:5"}), Contains("is a distribution"));
  CHECK_THAT(fault_of({"k=5:5:3"}), Contains("the range is empty"));
  CHECK_THAT(fault_of({"k=5:1:3"}), Contains("the start 5 is above the stop 1"));
  CHECK_THAT(fault_of({"k=1:5:1"}), Contains("not an integer from 2"));
  CHECK_THAT(fault_of({"k=1:5:2.5"}), Contains("not an integer from 2"));
  CHECK_THAT(fault_of({"k=log(-1:5:3)"}), Contains("begins above 0"));
  CHECK_THAT(fault_of({"k=log(1:5:3"}), Contains("not closed"));
  CHECK_THAT(fault_of({"k=cauchy(1,2)"}, "lhs:3"), Contains("no distribution \"cauchy\""));
  CHECK_THAT(fault_of({"k=normal(1)"}, "lhs:3"), Contains("write normal(mean,sd)"));
  CHECK_THAT(fault_of({"k=normal(1,0)"}, "lhs:3"), Contains("not above 0"));
  CHECK_THAT(fault_of({"k=triangular(1,7,5)"}, "lhs:3"), Contains("the mode 7 is outside"));
  CHECK_THAT(fault_of({"k=1,2", "k=3,4"}), Contains("names \"k\" twice"));
  CHECK_THAT(fault_of({"a=0:1:100000", "b=0:1:100000"}), Contains("1e+10 runs, more than 1e9"));
  CHECK_THAT(fault_of({}), Contains("nothing is varied"));
  CHECK_THAT(fault_of({"k=1:5"}, "sobol:0"), Contains("a sample of size 0"));
  CHECK_THAT(fault_of({"k=1:5"}, "sobol"), Contains("says no number"));
  CHECK_THAT(fault_of({"k=1:5"}, "halton:10"), Contains("no such way"));
}

TEST_CASE("results are functions of time, of outputs and of expressions, with the parameters of the run") {
  const Swept all = swept(plan_of({"R=1,2", "scene.stop=2,4"}),
                          {{"tau", "first(u > U*(1 - exp(-1)))/(R*C)"},
                           {"stored", "0.5*C*final(u)^2"},
                           {"lost", "integral(r.e*r.f)"},
                           {"late", "duration(u > 2)"},
                           {"never", "first(u > 4)"},
                           {"largest", "max(max(u), max(i))"},
                           {"part", "part"},
                           {"end", "final(t)"},
                           {"half", "mean(t)/max(t)"},
                           {"same", "min(R) + final(part)"}},
                          2);
  REQUIRE(all.runs.size() == 4);
  for (const auto& [index, run] : all.runs) {
    REQUIRE(run.completed);
    const double r = run.values[0], stop = run.values[1], tau = 0.5 * r, decay = std::exp(-stop / tau);
    constexpr double kError = 1e-7;  // a hundred tolerances
    CHECK(std::abs(run.results[0] - 1.0) < kError);
    CHECK(std::abs(run.results[1] - 0.25 * 9.0 * (1.0 - decay) * (1.0 - decay)) < kError);
    CHECK(std::abs(run.results[2] - 0.25 * 9.0 * (1.0 - decay * decay)) < kError);
    CHECK(std::abs(run.results[3] - (stop - tau * std::log(3.0))) < kError);
    CHECK(std::isnan(run.results[4]));
    CHECK(std::abs(run.results[5] - std::max(3.0 * (1.0 - decay), 3.0 / r)) < kError);
    CHECK(run.results[6] == 7.0);
    // The time and parameters are functions of time like others, which a trace has no columns of their names for.
    CHECK(run.results[7] == stop);
    CHECK(std::abs(run.results[8] - 0.5) < kError);
    CHECK(run.results[9] == r + 7.0);
  }
}

TEST_CASE("without a result that is asked for, five of each output are kept") {
  const Swept all = swept(plan_of({"R=1,2"}), {}, 1);
  CHECK(all.names == std::vector<std::string>{"u.final", "u.min", "u.max", "u.mean", "u.rms", "i.final", "i.min",
                                              "i.max", "i.mean", "i.rms"});
  const SweepRun& run = all.runs.at(1);
  CHECK(std::abs(run.results[3] - 3.0 * (1.0 - (1.0 - std::exp(-4.0)) / 4.0)) < 1e-7);
  CHECK(std::abs(run.results[9] - 1.5 * std::sqrt((1.0 - std::exp(-8.0)) / 8.0)) < 1e-7);
}

TEST_CASE("what is no result is refused with the text") {
  CHECK_THAT(result_fault("max(u"), Contains("not closed"));
  CHECK_THAT(result_fault("max()"), Contains("of what?"));
  CHECK_THAT(result_fault("u"), Contains("unknown name \"u\""));
  CHECK_THAT(result_fault("max(u) + t"), Contains("neither t nor der"));
  CHECK_THAT(result_fault("max(u) +"), Contains("--result \"x=max(u) +\""));
}

TEST_CASE("results of a sweep do not depend on threads, and runs that the model refuses leave the others as they are") {
  const SweepPlan plan = plan_of({"R=0.5:3", "scene.stop=-0.4:4"}, "sobol:200");
  const std::vector<std::pair<std::string, std::string>> wanted{{"mean", "mean(u)"}, {"when", "time_of_max(i)"}};
  const Swept one = swept(plan, wanted, 1), four = swept(plan, wanted, 4);
  REQUIRE(one.runs.size() == 200);
  REQUIRE(four.runs.size() == 200);
  std::size_t failed = 0;
  for (const auto& [index, run] : one.runs) {
    const SweepRun& other = four.runs.at(index);
    CHECK(run.completed == (run.values[1] > 0.0));
    CHECK(run.results == other.results);
    CHECK(run.message == other.message);
    if (run.completed) continue;
    ++failed;
    CHECK_THAT(run.message, Catch::StartsWith("BG143"));
  }
  CHECK(failed > 10);
}
