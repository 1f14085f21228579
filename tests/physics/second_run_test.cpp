// Errors of outputs over switches, diodes, contacts, events and delays: a second run against what is known exactly.
#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/verify.hpp"
#include "support/approx.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Contains;

namespace {

struct Compared {
  RunResult run;
  std::vector<double> off;  ///< by output: largest distance from the reference at its times
};

/// A scene at a loose tolerance, with its estimate, held against its reference at the reference's times.
Compared compared(const char* model, Method method, double relative) {
  const Study study = study_of(model);
  const Simulation scene = study.scene();
  Reference reference = scene.inputs().reference.value();
  reference.relative = reference.absolute = 0.0;
  const CsvTable table = read_reference(study.model(), reference);
  RunInputs inputs = at_reference_times(study.model(), scene.inputs(), table);
  inputs.method = method;
  inputs.relative = relative;
  Compared result{scene.simulate(inputs, untimed()), {}};
  REQUIRE(result.run.stop == StopReason::completed);
  for (const ColumnCheck& column : hold_against(study.model(), result.run.trace, table, reference).columns)
    result.off.push_back(column.error);
  return result;
}

}  // namespace

TEST_CASE("what a second run says outputs are wrong by is what they are wrong by") {
  struct Case {
    const char* model;
    Method method;
    double relative;
  };
  // Of each the first output, which does not jump: a record between two runs' instants of a jump is not compared.
  for (const Case& one :
       {Case{"models/half_wave.json", Method::bdf, 1e-4}, Case{"models/half_wave.json", Method::radau, 1e-3},
        Case{"models/thermostat.json", Method::bdf, 1e-5}, Case{"models/heated_loop.json", Method::bdf, 1e-5},
        Case{"models/ball_contact.json", Method::bdf, 1e-4}}) {
    CAPTURE(one.model, method_name(one.method));
    const Compared got = compared(one.model, one.method, one.relative);
    const OutputErrors& errors = got.run.report.errors;
    REQUIRE(errors.done);
    CHECK(errors.second_run == "at a tenth of the tolerance");
    REQUIRE(errors.estimate.size() == got.off.size());
    CAPTURE(got.off[0], errors.estimate[0], errors.range[0]);
    // The second run is wrong too, by a tenth of that at best, and by half of it where errors do not shrink with the
    // tolerance for a while. 1e-9 of the range is what the references' numbers leave.
    CHECK(errors.estimate[0] >= 0.5 * got.off[0] - 1e-9 * errors.range[0]);
    CHECK(errors.estimate[0] <= 2.0 * got.off[0] + 1e-9 * errors.range[0]);
  }
}

TEST_CASE("a second run tells what a short run of many states is wrong by") {
  // A pulse through a line of 60 coils and softening capacitors: 120 states, which no estimate follows.
  const std::string line = R"x({"bgsim": 1, "name": "line", "elements": {
      "s": {"kind": "MSe", "effort": "if(t < 8, sin(pi*t/8)^2, 0)"}, "j": {"kind": "1", "repeat": 60}, "n": {"kind": "0", "repeat": 60},
      "l": {"kind": "I", "repeat": 60, "inertance": 1}, "c": {"kind": "C", "repeat": 60, "law": "e = q + 0.4*q^2"}, "r": {"kind": "R", "resistance": 2}},
    "bonds": [{"from": "s", "to": "j[1]"}, {"from": "j[i]", "to": "l[i]"}, {"from": "j[i]", "to": "n[i]"}, {"from": "n[i]", "to": "c[i]"},
              {"from": "n[i]", "to": "j[i+1]"}, {"from": "n[60]", "to": "r"}],
    "outputs": {"m": "c[30].e", "end": "c[60].e"}, "scenes": {"s": {"stop": STOP, "samples": 101}}})x";
  const auto study_to = [&](const char* stop) {
    std::string text = line;
    return Study(std::make_shared<Model>(read_model_text("line.json", text.replace(text.find("STOP"), 4, stop))));
  };
  const Study study = study_to("120");
  RunInputs inputs = study.scene().inputs();
  SimulateOptions how = untimed();
  inputs.relative = 1e-10;
  inputs.method = Method::erk8;
  how.error_estimate = false;
  const RunResult exact = study.scene().simulate(inputs, how);
  inputs.relative = 1e-6;
  for (const Method method : {Method::automatic, Method::bdf}) {
    CAPTURE(method_name(method));
    inputs.method = method;
    const RunResult run = study.scene().simulate(inputs, untimed());
    const OutputErrors& errors = run.report.errors;
    REQUIRE(errors.done);
    CHECK(errors.second_run == "at a tenth of the tolerance");
    for (std::size_t c = 0; c < 2; ++c) {
      double off = 0.0;
      for (std::size_t i = 0; i < run.trace.times.size(); ++i)
        off = std::max(off, std::abs(run.trace.columns[c][i] - exact.trace.columns[c][i]));
      CAPTURE(off, errors.estimate[c]);
      CHECK(errors.estimate[c] >= 0.5 * off);  // as above
      CHECK(errors.estimate[c] <= 2.0 * off);
    }
  }
  // A longer one is not made twice.
  const RunResult longer = study_to("1e4").scene().simulate(untimed());
  CHECK_FALSE(longer.report.errors.possible);
  CHECK(longer.report.errors.why_not == "more than 50 states");
}

TEST_CASE("instants of events have an error of their own, and large ones are noted") {
  constexpr double kExtinction = 3.940733135693;
  const Study study = study_of("models/half_wave.json");
  RunInputs inputs = study.scene().inputs();
  inputs.method = Method::bdf;
  inputs.relative = 1e-2;
  double off = 0.0;
  SimulateOptions how = untimed();
  how.events = [&](const RunEvent& event) {
    if (event.kind != RunEvent::Kind::diode) return;
    const double first = event.to == "conducts" ? 0.0 : kExtinction;
    off = std::max(off, std::abs(std::remainder(event.t - first, 2.0 * M_PI)));
  };
  std::size_t rows = 0;
  how.rows = [&](double, std::span<const double>) { ++rows; };
  const RunResult run = study.scene().simulate(inputs, how);
  REQUIRE(run.report.errors.instants);
  CHECK(*run.report.errors.instants == Approx(off).epsilon(0.2));  // the second run's own
  CHECK(run.report.errors.instants_of.starts_with("diode ("));
  CHECK(rows == inputs.output_times.size());  // of the first run alone
  const std::string text = report_text(run);
  CHECK_THAT(text, Contains("the instants of events are estimated to be wrong by up to"));
  CHECK_THAT(text, Contains("outputs are estimated to be wrong by more than 0.01 % of their range"));
  CHECK_THAT(text, Contains("from a second run at a tenth of the tolerance"));
}

TEST_CASE("a second run tells where errors of first order come to more than what an output varies by", "[long]") {
  // Empty tanks behind an inflow that sets in: at rest the flow of such an orifice jumps and has no bounded slope, and
  // to first order errors of 1e-7 come to more than what the output varies by. (Without the jump, e = f*abs(f), they
  // did while its sign was a condition.) Rounding has a say in whether they do: of these runs some do.
  const auto tanks = [](const std::string& count) {
    std::string text = R"x({"bgsim": 1, "name": "tanks", "elements": {
      "s": {"kind": "Sf", "flow": "100*step(t - 1)"}, "m": {"kind": "0"}, "b": {"kind": "C", "capacitance": 0.05},
      "n": {"kind": "0", "repeat": N}, "c": {"kind": "C", "repeat": N, "capacitance": 0.05},
      "j": {"kind": "1", "repeat": N}, "r": {"kind": "R", "repeat": N, "law": "f = sign(e)*(abs(e)^0.3 + 1e-4)"}},
    "bonds": [{"from": "s", "to": "m"}, {"from": "m", "to": "b"}, {"from": "m", "to": "j[1]"},
              {"from": "j[i]", "to": "r[i]"}, {"from": "j[i]", "to": "n[i]"}, {"from": "n[i]", "to": "c[i]"},
              {"from": "n[i]", "to": "j[i+1]"}],
    "outputs": {"first": "c[1].e", "last": "c[N].e"}, "scenes": {"s": {"stop": 3, "samples": 21}}})x";
    for (std::size_t at = 0; (at = text.find('N', at)) != std::string::npos;) text.replace(at, 1, count);
    return Study::from_text(text);
  };
  const auto run = [](const Study& study, Method method, double relative, bool second) {
    RunInputs inputs = study.scene("s").inputs();
    inputs.method = method;
    inputs.relative = relative;
    SimulateOptions how = untimed();
    how.second_run = second;
    RunResult result = study.scene("s").simulate(inputs, how);
    REQUIRE(result.stop == StopReason::completed);
    return result;
  };
  const auto largest_difference = [](const RunResult& one, const RunResult& other, std::size_t output) {
    double most = 0.0;
    for (std::size_t k = 0; k < one.trace.times.size(); ++k)
      most = std::max(most, std::abs(one.trace.columns[output][k] - other.trace.columns[output][k]));
    return most;
  };
  int beyond = 0, sharper = 0;
  for (const std::string count : {"16", "18"}) {
    const Study study = tanks(count);
    const RunResult fine = run(study, Method::radau9, 1e-9, false);
    for (const Method method : {Method::automatic, Method::dirk5, Method::radau, Method::bdf}) {
      const OutputErrors alone = run(study, method, 1e-6, false).report.errors;
      if (!(alone.estimate[1] > alone.range[1])) continue;
      ++beyond;
      const RunResult result = run(study, method, 1e-6, true);
      const OutputErrors& errors = result.report.errors;
      REQUIRE(errors.second_run == "at a tenth of the tolerance");
      REQUIRE_FALSE(errors.beyond_first_order.empty());
      CHECK(errors.beyond_first_order.back() == 1);
      if (errors.estimate[1] < 1e-4 * errors.range[1])  // more has a note of its own
        CHECK_THAT(report_text(result), Contains("grow to more than what these vary by; a second run"));
      const RunResult tighter = run(study, method, 1e-7, false);
      for (std::size_t c = 0; c < 2; ++c) {
        const auto off = [&](const RunResult& run) { return largest_difference(fine, run, c); };
        CAPTURE(count, method_name(method), c, off(result), off(tighter), errors.estimate[c]);
        // What the two runs differ by is nine tenths of it, where the second run is wrong by a tenth.
        CHECK(0.9 * errors.estimate[c] == Approx(largest_difference(result, tighter, c)).epsilon(1e-12).margin(0.0));
        if (off(tighter) > 0.5 * off(result)) continue;  // as above: the second run is wrong, too
        ++sharper;
        // 1e-8 of the range is what the fine run may be wrong by.
        CHECK(errors.estimate[c] >= 0.5 * off(result) - 1e-8 * errors.range[c]);
        CHECK(errors.estimate[c] <= 2.0 * off(result) + 1e-8 * errors.range[c]);
      }
    }
  }
  CHECK(beyond > 0);
  CHECK(sharper > 0);
}

TEST_CASE("a run that has an estimate of its own, or no end, or is asked for none, has no second run") {
  const auto errors_of = [](const char* model, auto change) {
    const Study study = study_of(model);
    SimulateOptions how = untimed();
    RunInputs inputs = study.scene().inputs();
    change(inputs, how);
    return study.scene().simulate(inputs, how).report.errors;
  };
  CHECK(errors_of("models/rlc.json", [](auto&, auto&) {}).second_run.empty());
  CHECK(errors_of("models/buck.json", [](auto&, auto& how) { how.max_steps = 20; }).why_not ==
        "the run did not complete");
  CHECK(errors_of("models/buck.json", [](auto&, auto& how) { how.error_estimate = false; }).second_run.empty());
  CHECK(errors_of("models/half_wave.json", [](RunInputs& inputs, auto&) {
          inputs.method = Method::rk4;
          inputs.step = 0.01;
        }).second_run == "with half the step");
  CHECK(errors_of("models/half_wave.json", [](RunInputs& inputs, auto&) { inputs.relative = 1e-12; }).second_run ==
        "at ten times the tolerance");
}
