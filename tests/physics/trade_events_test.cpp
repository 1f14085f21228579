// The measured trade and --accuracy on scenes with switches, diodes and contacts: instants are part of the error.
#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/trade.hpp"
#include "bgsim/verify.hpp"
#include "study/event_times.hpp"
#include "support/approx.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

EventTimes times(const std::string& name, const std::vector<double>& at) {
  EventTimes result;
  for (const double t : at) {
    RunEvent event;
    event.kind = RunEvent::Kind::switching;
    event.t = t;
    event.name = name;
    event.to = "closed";
    result.take(event);
  }
  return result;
}

/// Largest distance of what happens in a run of half_wave.json from the closed form: i = 0 at 3.940733135693 and
/// whole periods later, and begins at whole periods.
double instants_off(const Simulation& scene, Method method, double relative) {
  constexpr double kExtinction = 3.940733135693;
  RunInputs inputs = scene.inputs();
  inputs.method = method;
  inputs.relative = relative;
  double off = 0.0;
  SimulateOptions how = untimed();
  how.events = [&](const RunEvent& event) {
    if (event.kind != RunEvent::Kind::diode) return;
    const double first = event.to == "conducts" ? 0.0 : kExtinction;
    const double periods = std::round((event.t - first) / (2.0 * M_PI));
    off = std::max(off, std::abs(event.t - first - periods * 2.0 * M_PI));
  };
  REQUIRE(scene.simulate(inputs, how).stop == StopReason::completed);
  return off;
}

}  // namespace

TEST_CASE("instants of two runs are compared with the nearest of their kind, in both directions") {
  const EventTimes one = times("s", {1.0, 2.0, 3.0});
  CHECK(event_distance(one, one, 10.0).largest == 0.0);
  CHECK(event_distance(one, one, 10.0).between.empty());

  const EventDistance late = event_distance(one, times("s", {1.0, 2.25, 3.0}), 10.0);
  CHECK(late.largest == 0.25);
  CHECK(late.what == "s (closed)");
  CHECK(late.parted(2.0));
  CHECK(late.parted(2.25));
  CHECK(late.parted(2.1));
  CHECK_FALSE(late.parted(1.0));  // a known time, the same in both
  CHECK_FALSE(late.parted(2.3));

  CHECK(event_distance(one, times("s", {1.0, 3.0}), 10.0).largest == 1.0);  // one is missing
  CHECK(event_distance(times("s", {1.0, 3.0}), one, 10.0).largest == 1.0);
  const EventDistance none = event_distance(one, times("other", {1.0}), 10.0);
  CHECK(none.largest == 10.0);
  CHECK_FALSE(none.what.empty());
}

TEST_CASE("a side that is taken back within roundings of the scene is no instant of its own") {
  const auto changes = [](const std::vector<std::pair<double, std::string>>& sides) {
    EventTimes result;
    std::string from = "closed";
    for (const auto& [t, to] : sides) {
      RunEvent event;
      event.kind = RunEvent::Kind::switching;
      event.t = t;
      event.name = "s";
      event.from = std::exchange(from, to);
      event.to = to;
      result.take(event);
    }
    return result;
  };
  const EventTimes plain = changes({{1.0, "open"}, {2.0, "closed"}});
  CHECK(event_distance(plain, changes({{1e-20, "open"}, {1e-17, "closed"}, {1.0, "open"}, {2.0, "closed"}}), 10.0)
            .largest == 0.0);
  // There, back and there again lasts.
  CHECK(event_distance(plain, changes({{1.0, "open"}, {1.0 + 1e-13, "closed"}, {1.0 + 2e-13, "open"}, {2.0, "closed"}}),
                       10.0)
            .largest < 1e-12);
  CHECK(
      event_distance(plain, changes({{0.5, "open"}, {0.6, "closed"}, {1.0, "open"}, {2.0, "closed"}}), 10.0).largest ==
      1.4);
}

TEST_CASE("a run from a condition that holds with equality gets no note about instants") {
  // The second run, at a tenth of the tolerance, opens the switch for 1e-17 s.
  const Study study = Study::from_text(R"x({"bgsim": 1, "name": "equal",
    "elements": {"n": {"kind": "0"}, "s": {"kind": "Sf", "flow": "t"}, "c": {"kind": "C", "capacitance": 1.5},
                 "j": {"kind": "1"}, "sw": {"kind": "Sw", "closed": "c.e >= 0"}, "r": {"kind": "R", "resistance": 2}},
    "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}, {"from": "n", "to": "j"}, {"from": "j", "to": "sw"},
              {"from": "j", "to": "r"}],
    "scenes": {"s": {"stop": 20, "samples": 6}}, "outputs": {"u": "c.e"}})x");
  const RunResult run = study.scene().simulate(study.scene().inputs(), untimed());
  REQUIRE(run.stop == StopReason::completed);
  CHECK_FALSE(run.report.errors.second_run.empty());
  // u = 2 t - 6 + 6 exp(-t/3)
  CHECK(last(run, "u") == Approx(34.0 + 6.0 * std::exp(-20.0 / 3.0)).epsilon(1e-5));  // ten tolerances
  for (const std::string& note : run.report.notes) CHECK(note.find("instants") == std::string::npos);
}

TEST_CASE("a trade of a rectifier measures the instants of its diode, and its references agree to 1e-9", "[long]") {
  const Study study = study_of("models/half_wave.json");
  const Simulation scene = study.scene();
  TradeOptions options;
  options.budget = 3.0;
  const Trade trade = measure_trade(scene, options);
  CHECK(trade.reference.error < 1e-9);
  REQUIRE(trade.outputs.back().name == "event times");
  CHECK(trade.outputs.back().range == 18.0);
  int compared = 0;
  for (const TradeRow& row : trade.rows) {
    if (row.setting.method != Method::bdf || row.setting.max_order > 0 || row.errors.empty()) continue;
    if (row.setting.relative < 1e-6) continue;  // nearer to the reference's own error
    CAPTURE(row.setting.relative);
    // 18 times the reference's error is what the closed form may be off by here.
    CHECK(row.errors.back().max * 18.0 ==
          Approx(instants_off(scene, Method::bdf, row.setting.relative)).margin(18.0 * trade.reference.error));
    CHECK(row.max_error >= row.errors.back().max);
    ++compared;
  }
  CHECK(compared >= 3);
}

TEST_CASE("an accuracy is found and kept over impacts and their limit, by switches and by diodes", "[long]") {
  for (const char* model : {"models/ball_contact.json", "models/buck.json", "models/relief_valve.json"}) {
    CAPTURE(model);
    const Study study = study_of(model);
    const Simulation scene = study.scene();
    constexpr double kAccuracy = 1e-7;
    const TradePick pick = find_setting(scene, kAccuracy, {});
    CHECK(pick.error <= kAccuracy);
    CHECK(pick.reference.error <= kAccuracy);
    // Against the reference, which is none of bgsim's; what its columns reach is no more than their range here.
    Reference reference = scene.inputs().reference.value();
    reference.relative = kAccuracy;
    reference.absolute = 0.0;
    const CsvTable table = read_reference(study.model(), reference);
    const RunInputs inputs = at_reference_times(study.model(), with_setting(scene.inputs(), pick.setting), table);
    const ReferenceCheck check = hold_against(study.model(), scene.simulate(inputs, untimed()).trace, table, reference);
    REQUIRE_FALSE(check.columns.empty());
    for (const ColumnCheck& column : check.columns) {
      CAPTURE(column.output, column.error);
      CHECK(column.ok());
    }
  }
}
