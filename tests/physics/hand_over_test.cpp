// Runs that another program of the same model goes on with.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Two capacitors of 1 F and 3 F side by side, charged through 2 ohm from 5 V: one of them is in derivative causality,
/// the one of lower priority. q2 is 1 - exp(-t/8) of 15 C.
Study side_by_side(double priority_of_a) {
  return Study::from_text(R"({"bgsim": 1, "name": "two", "elements": {
    "source": {"kind": "Se", "effort": 5}, "series": {"kind": "1"}, "node": {"kind": "0"},
    "r": {"kind": "R", "resistance": 2},
    "a": {"kind": "C", "capacitance": 1, "priority": )" +
                          std::to_string(priority_of_a) + R"(},
    "b": {"kind": "C", "capacitance": 3}, "drift": {"kind": "Df"}},
    "bonds": [{"from": "source", "to": "series"}, {"from": "series", "to": "r"}, {"from": "series", "to": "node"},
              {"from": "node", "to": "a"}, {"from": "node", "to": "b"}, {"from": "series", "to": "drift"}],
    "signals": {"charge": {"integral": "r.f"}},
    "outputs": {"qa": "a.q", "qb": "b.q", "charge": "charge"},
    "scenes": {"charging": {"stop": 40, "samples": 41, "relative": 1e-9}}})");
}

RunResult first_steps(const Simulation& of, std::uint64_t steps) {
  SimulateOptions options;
  options.max_steps = steps;
  RunResult result = of.simulate(options);
  REQUIRE(result.failure);
  REQUIRE(result.failure->code == "BG607");
  return result;
}

}  // namespace

TEST_CASE("a run goes on in a program whose strokes make another store independent") {
  const Simulation of_a = side_by_side(1.0).scene(), of_b = side_by_side(-1.0).scene();
  REQUIRE(of_a.program().state_names != of_b.program().state_names);
  for (const std::uint64_t steps : {1U, 20U, 60U}) {
    const RunResult before = first_steps(of_a, steps);
    const RunInputs rest = continued(of_a.inputs(), before.stored, before.rows, of_b.program());
    CHECK(rest.start == before.report.reached);
    const RunResult after = of_b.simulate(rest);
    REQUIRE(after.stop == StopReason::completed);
    CHECK(before.rows + after.rows == 41);
    // A relative tolerance of 1e-9 in each of some hundred steps.
    for (const RunResult* const leg : {&before, &after})
      for (std::size_t i = 0; i < leg->trace.times.size(); ++i) {
        const double share = 1.0 - std::exp(-leg->trace.times[i] / 8.0);
        CHECK(leg->trace["qa"][i] == Approx(5.0 * share).epsilon(0).margin(1e-6));
        CHECK(leg->trace["qb"][i] == Approx(15.0 * share).epsilon(0).margin(1e-6));
        CHECK(leg->trace["charge"][i] == Approx(20.0 * share).epsilon(0).margin(1e-6));
      }
    // What was stored in the two legs is what the whole run stores, 5 V on 4 F but for exp(-5) of the charge.
    const double share = 1.0 - std::exp(-5.0);
    CHECK(before.report.energy.stored + after.report.energy.stored ==
          Approx(50.0 * share * share).epsilon(0).margin(1e-5));
  }
}

TEST_CASE("a run that is over goes on for no time, and one in several legs is as good as one") {
  const Simulation one = side_by_side(1.0).scene();
  const RunResult whole = one.simulate();
  const RunResult none = one.simulate(continued(one.inputs(), whole.stored, whole.rows, one.program()));
  CHECK(none.stop == StopReason::completed);
  CHECK(none.rows == 0);

  RunInputs rest = one.inputs();
  std::uint64_t rows = 0;
  RunResult leg;
  for (int legs = 0; legs < 50; ++legs) {
    SimulateOptions options;
    options.max_steps = 30;
    leg = one.simulate(rest, options);
    rows += leg.rows;
    if (leg.stop == StopReason::completed) break;
    rest = continued(rest, leg.stored, leg.rows, one.program());
  }
  REQUIRE(leg.stop == StopReason::completed);
  CHECK(rows == 41);
  // Each leg begins with steps of order 1, within the same tolerance of 1e-9.
  CHECK(last(leg, "qb") == Approx(last(whole, "qb")).epsilon(1e-7));
}

TEST_CASE("a program with a state that the run before left out does not take over") {
  const Study study = side_by_side(1.0);
  const Simulation all = study.scene();
  RunInputs inputs = all.inputs();
  inputs.outputs = {0};  // qa: the integral is left out
  const Simulation cut = study.scene(inputs);
  REQUIRE(cut.program().state_names.size() < all.program().state_names.size());
  const RunResult before = first_steps(cut, 5);
  CHECK_THROWS_AS(continued(all.inputs(), before.stored, before.rows, all.program()), std::invalid_argument);
}

TEST_CASE("rows that were recorded of other times are no part of a run that is continued") {
  const Study study = side_by_side(1.0);
  const Simulation all = study.scene();
  RunInputs part = all.inputs();
  part.stop = all.inputs().stop / 2;
  part.output_times = {part.start, part.stop};
  const RunResult before = study.scene(part).simulate(one_run());
  REQUIRE_FALSE(before.failure);
  REQUIRE(before.rows == 2);
  // Of the whole run's times many more are behind.
  CHECK_THROWS_AS(continued(all.inputs(), before.stored, before.rows, all.program()), std::invalid_argument);
  // Nor are times of before in a scene that begins later.
  RunInputs later = all.inputs();
  later.start = part.stop;
  CHECK_THROWS_AS(study.scene(later).simulate(one_run()), std::invalid_argument);
}
