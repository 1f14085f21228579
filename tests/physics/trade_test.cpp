// The measured trade: errors against exact solutions, verdicts, the front, the pick.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/approx.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Contains;

namespace {

/// Mass, spring and damper, q(0) = 1; q and a flow that is always zero are recorded.
std::string oscillator(const std::string& damping) {
  const std::string damper = damping.empty() ? "" : R"(, "d": { "kind": "R", "resistance": )" + damping + " }";
  const std::string bond = damping.empty() ? "" : R"(, { "from": "j", "to": "d" })";
  return R"json({ "bgsim": 1, "name": "oscillator",
    "elements": { "j": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
      "s": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } })json" +
         damper + R"json( },
    "bonds": [ { "from": "j", "to": "m" }, { "from": "j", "to": "s" })json" +
         bond +
         R"json( ], "outputs": { "q": "s.q", "nothing": "0*m.p" }, "scenes": { "main": { "stop": 6, "samples": 31 } } })json";
}

/// q' = -q and a store that follows within 1e-6.
const char* const kStiff = R"json({ "bgsim": 1, "name": "stiff",
  "elements": { "n": { "kind": "0" }, "c1": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
    "r1": { "kind": "R", "resistance": 1 }, "b": { "kind": "1" }, "r2": { "kind": "R", "resistance": 1 },
    "c2": { "kind": "C", "capacitance": 1e-6 } },
  "bonds": [ { "from": "n", "to": "c1" }, { "from": "n", "to": "r1" }, { "from": "n", "to": "b" },
    { "from": "b", "to": "r2" }, { "from": "b", "to": "c2" } ],
  "outputs": { "v": "c1.e" }, "scenes": { "main": { "stop": 5, "samples": 21 } } })json";

/// @param budget  seconds: several times what an optimised build needs, for those under sanitizers.
Trade trade_of(const CompiledModel& model, double budget) {
  TradeOptions options;
  options.budget = budget;
  return measure_trade(model.program, model.inputs, options);
}

const TradeRow& row_of(const Trade& trade, Method method, double relative, int max_order = 0) {
  for (const TradeRow& row : trade.rows)
    if (row.setting.method == method && row.setting.max_order == max_order && row.setting.relative == relative)
      return row;
  throw std::invalid_argument("no such row");
}

}  // namespace

TEST_CASE("a trade tells errors as they are, marks the front, and picks from it", "[long]") {
  const CompiledModel model = compile_text(oscillator("0.2"));
  const Trade trade = trade_of(model, 8.0);
  CHECK(trade.reference.error < 1e-8);
  CHECK(trade.reference.setting.method != trade.reference.second.method);
  CHECK(trade.fastest_rate == same_to_rounding(1.0, 32));
  CHECK(trade.outputs[0].judged());
  CHECK(trade.outputs[1].why_not == "zero throughout");

  // one row against the closed form
  CompiledModel same = model;
  same.inputs.method = Method::bdf;
  same.inputs.relative = 1e-4;
  const RunResult run = same.run();
  const std::vector<double> q = column(run, "q");
  const double w = std::sqrt(1.0 - 0.01);
  double error = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double t = run.trace.times[i];
    error = std::max(error, std::abs(q[i] - std::exp(-0.1 * t) * (std::cos(w * t) + 0.1 / w * std::sin(w * t))));
  }
  const TradeRow& row = row_of(trade, Method::bdf, 1e-4);
  CHECK(row.max_error == Approx(error / trade.outputs[0].range).epsilon(1e-3));  // the reference's own error
  CHECK(row.rms_error < row.max_error);
  CHECK(row.steps == run.report.steps);
  CHECK(row.rates == run.report.rate_evaluations);
  CHECK(row.energy_residual.value() > 0.0);
  CHECK(row.repeats >= 3);

  // tighter is more exact, for every error-controlled method; Störmer-Verlet is not for a damped oscillator
  for (const MethodFacts& facts : all_methods()) {
    if (facts.method == Method::automatic || facts.fixed_step()) continue;
    CAPTURE(facts.name);
    // Rows of what is for accurate runs begin at 1e-6, and end a decade or two below, at the reference's own error.
    const bool accurate = facts.method == Method::radau9 || facts.method == Method::radau13;
    const auto [loose, tight] = accurate ? std::pair(1e-4, 1e-6) : std::pair(1e-2, 1e-5);
    const TradeRow& before = row_of(trade, accurate ? Method::radau : facts.method, loose);
    CHECK(row_of(trade, facts.method, tight).max_error < 0.1 * before.max_error);
    if (accurate) CHECK_THROWS(row_of(trade, facts.method, loose));
  }
  CHECK_THROWS(row_of(trade, Method::verlet, 0.0));

  std::size_t front = 0;
  for (const TradeRow& one : trade.rows) {
    if (!one.pareto) continue;
    ++front;
    for (const TradeRow& other : trade.rows)
      CHECK_FALSE((other.verdict == TradeVerdict::stable && other.cpu_seconds < one.cpu_seconds &&
                   other.max_error < one.max_error));
  }
  CHECK(front >= 2);

  const auto picked = pick_row(trade, 1e-3);
  REQUIRE(picked);
  CHECK(trade.rows[*picked].max_error <= 1e-3);
  for (const TradeRow& other : trade.rows)
    if (other.verdict == TradeVerdict::stable && other.max_error <= 1e-3 && other.check_error <= 1e-3)
      CHECK(trade.rows[*picked].cpu_seconds <= other.cpu_seconds);
  CHECK_FALSE(pick_row(trade, trade.reference.error));

  const std::string csv = trade_csv(trade);
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) == trade.rows.size() + 1);
  CHECK_THAT(csv, Catch::StartsWith("method,max_order,relative,step,max_error,rms_error,error_between,cpu_seconds,"));
  CHECK_THAT(csv, Contains(",max:q,rms:q\r\n"));
  const auto json = nlohmann::json::parse(trade_json(trade));
  CHECK(json["rows"].size() == trade.rows.size());
  CHECK(json["outputs"][1]["why_not"] == "zero throughout");
}

TEST_CASE("a lossless graph is measured with Störmer-Verlet too", "[long]") {
  const Trade trade = trade_of(compile_text(oscillator("")), 4.0);
  const auto found = std::find_if(trade.rows.begin(), trade.rows.end(),
                                  [](const TradeRow& row) { return row.setting.method == Method::verlet; });
  CHECK(found != trade.rows.end());
}

TEST_CASE("on a stiff scene explicit methods are cut or unstable, and the table says why", "[long]") {
  const Trade trade = trade_of(compile_text(kStiff), 6.0);
  CHECK(trade.fastest_rate == Approx(1e6).epsilon(1e-3));
  const TradeRow& erk = row_of(trade, Method::erk5, 1e-2);
  CHECK(erk.verdict == TradeVerdict::too_costly);
  CHECK_THAT(erk.why, Contains("stability holds an explicit method's steps"));
  CHECK(row_of(trade, Method::dirk4, 1e-4).verdict == TradeVerdict::stable);
  CHECK(row_of(trade, Method::bdf, 1e-4).verdict == TradeVerdict::stable);
  bool unstable = false;
  for (const TradeRow& row : trade.rows) {
    if (row.setting.method != Method::euler || row.verdict != TradeVerdict::unstable) continue;
    unstable = true;
    CHECK_THAT(row.why, Contains("times what the fastest mode takes"));
  }
  CHECK(unstable);
  const auto picked = pick_row(trade, 1e-4);
  REQUIRE(picked);
  CHECK(facts_of(trade.rows[*picked].setting.method).implicit());
}

TEST_CASE("a setting found for an accuracy has it against the exact solution") {
  CompiledModel model = compile_text(kStiff);
  TradeOptions options;
  options.budget = 5.0;
  for (const double accuracy : {1e-3, 1e-6}) {
    const TradePick pick = find_setting(model.program, model.inputs, accuracy, options);
    CHECK(pick.error <= accuracy);
    CHECK(pick.reference.error < accuracy / 2.0);
    CHECK(facts_of(pick.setting.method).implicit());
    CompiledModel found = model;
    found.inputs = with_setting(model.inputs, pick.setting);
    const RunResult run = found.run();
    const std::vector<double> v = column(run, "v");
    // both capacitors together discharge as one, but for terms of the size 1e-6
    double error = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double exact = i == 0 ? 1.0 : std::exp(-run.trace.times[i] / (1.0 + 1e-6)) / (1.0 + 1e-6);
      error = std::max(error, std::abs(v[i] - exact));
    }
    CHECK(error <= accuracy + 3e-6);
  }
}

/// q' = -q, q(0) = 1, and a small output that is the difference of q and a closed form.
std::string discharge(const std::string& small) {
  return R"json({ "bgsim": 1, "name": "discharge",
    "elements": { "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
      "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "n", "to": "c" }, { "from": "n", "to": "r" } ],
    "outputs": { "q": "c.q", "small": ")json" +
         small + R"json(" }, "scenes": { "main": { "stop": 5, "samples": 21 } } })json";
}

TEST_CASE(
    "an output far below the others has the accuracy too: what a loose reference shows of it is not taken for zero") {
  CompiledModel model = compile_text(discharge("c.q - (1 + 1e-7)*exp(-t)"));
  TradeOptions options;
  options.budget = 5.0;
  const double accuracy = 1e-2;
  const TradePick pick = find_setting(model.program, model.inputs, accuracy, options);
  CHECK(pick.reference.unresolved.empty());
  CompiledModel found = model;
  found.inputs = with_setting(model.inputs, pick.setting);
  const RunResult run = found.run();
  const std::vector<double> small = column(run, "small");
  const double range = 1e-7 * (1.0 - std::exp(-5.0));
  for (std::size_t i = 0; i < small.size(); ++i) {
    CAPTURE(run.trace.times[i]);
    CHECK(std::abs(small[i] + 1e-7 * std::exp(-run.trace.times[i])) <= accuracy * range);
  }
}

TEST_CASE("an output that is zero except for rounding is not judged, and prevents no accuracy", "[long]") {
  const CompiledModel model = compile_text(discharge("c.q - exp(-t)"));
  const Trade trade = trade_of(model, 5.0);
  CHECK(trade.outputs[0].judged());
  CHECK_THAT(trade.outputs[1].why_not, Contains("not distinguishable from zero"));
  CHECK_FALSE(trade.outputs[1].unresolved);
  CHECK(pick_row(trade, 1e-4));
  TradeOptions options;
  options.budget = 5.0;
  CHECK(find_setting(model.program, model.inputs, 1e-4, options).error <= 1e-4);
}

TEST_CASE("a setting that is asked for is measured to its end, whatever the limit of a run", "[long]") {
  std::string text = kStiff;
  text.replace(text.find("\"stop\": 5"), 9, "\"stop\": 0.2");
  const CompiledModel model = compile_text(text);
  TradeOptions options;
  options.budget = 2.0;
  options.also = {{Method::erk5, 0, 1e-9, 0.0}};  // held by stability at some 1e5 steps
  const Trade trade = measure_trade(model.program, model.inputs, options);
  const TradeRow& asked = row_of(trade, Method::erk5, 1e-9);
  CHECK(asked.verdict == TradeVerdict::stable);
  CHECK(asked.steps > 40'000);
}

TEST_CASE("tolerances that leave more than a hundredth of error are passed over, and the curve goes on below",
          "[long]") {
  // a hundred periods: each adds its error
  std::string text = oscillator("");
  text.replace(text.find("\"stop\": 6"), 9, "\"stop\": 628.32");
  const Trade trade = trade_of(compile_text(text), 4.0);
  std::vector<const TradeRow*> rows;
  for (const TradeRow& row : trade.rows)
    if (row.setting.method == Method::erk3) rows.push_back(&row);
  REQUIRE(rows.size() >= 2);
  CHECK(rows[0]->setting.relative == 1e-2);
  CHECK(rows[0]->max_error > 0.1);
  CHECK(rows[1]->setting.relative <= 1e-2 * 1e-2 / rows[0]->max_error);
}

namespace {

/// A mass that coasts past a magnet of a width: dv/dx = -b(x), so half of the speed is lost there.
std::string past_a_magnet(const std::string& width) {
  return R"json({ "bgsim": 1, "name": "magnet", "parameters": { "w": )json" + width + R"json( },
    "signals": { "x": { "integral": "b.f" } },
    "elements": { "b": { "kind": "1" }, "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } },
      "magnet": { "kind": "MR", "resistance": "0.5/(sqrt(pi)*w)*exp(-((x - 1.2345)/w)^2)" } },
    "bonds": [ { "from": "b", "to": "m" }, { "from": "b", "to": "magnet" } ],
    "outputs": { "v": "b.f" }, "scenes": { "main": { "stop": 3, "samples": 61 } } })json";
}

/// A body at @p level with a ripple of @p size: T' = level + size*cos(50 t) - T.
std::string ripple(const std::string& level, const std::string& size) {
  return R"json({ "bgsim": 1, "name": "ripple", "elements": { "a": { "kind": "Se", "effort": )json" + level +
         R"json( }, "h": { "kind": "MSf", "flow": ")json" + size + R"json(*cos(50*t)" }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "n": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 1, "initial": { "q": )json" +
         level + R"json( } } },
    "bonds": [ { "from": "a", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "n" },
      { "from": "h", "to": "n" }, { "from": "n", "to": "c" } ],
    "outputs": { "T": "c.e" }, "scenes": { "main": { "stop": 5, "samples": 201 } } })json";
}

RunResult run_with(const CompiledModel& model, const TradePick& pick) {
  CompiledModel found = model;
  found.inputs = with_setting(model.inputs, pick.setting);
  return found.run();
}

}  // namespace

TEST_CASE("a setting found for an accuracy has seen a law that is narrower than loose runs know their states") {
  // Two runs that both pass over it agree, and so does a second method: v = 1 with "error 0".
  for (const std::string width : {"3e-3", "3e-5", "1e-7"})
    for (const double accuracy : {1e-2, 1e-3, 1e-5}) {
      INFO(width << ", " << accuracy);
      const CompiledModel model = compile_text(past_a_magnet(width));
      const TradePick pick = find_setting(model.program, model.inputs, accuracy, {});
      CHECK(std::abs(column(run_with(model, pick), "v").back() - 0.5) <= 0.5 * accuracy);  // the range is 0.5
    }
}

TEST_CASE("a run that passes over a law narrower than its states are known says so, whatever its tolerance") {
  for (const Method method : {Method::automatic, Method::radau, Method::bdf, Method::erk5, Method::dirk5})
    for (const double relative : {1e-2, 1e-3, 1e-4, 1e-5}) {
      INFO(method_name(method) << ", " << relative);
      CompiledModel model = compile_text(past_a_magnet("3e-5"));
      model.inputs.method = method;
      model.inputs.relative = relative;
      const RunResult run = model.run();
      CHECK((std::abs(column(run, "v").back() - 0.5) < 0.05 || !run.report.undecided.empty()));
      for (const std::string& note : run.report.undecided)
        CHECK(std::count(run.report.notes.begin(), run.report.notes.end(), note) == 1);
    }
}

TEST_CASE("a setting found for an accuracy has it where the steps are those of a source, whatever the tolerance") {
  // Radau makes the same steps from 1e-3 to 1e-7: two such runs agree to rounding, and are wrong by 1.5e-5 of the
  // range.
  for (const auto& [level, size] : {std::pair("300", "1"), std::pair("300", "0.01"), std::pair("20000", "3")})
    for (const double accuracy : {1e-3, 1e-5, 1e-6}) {
      INFO(level << ", " << size << ", " << accuracy);
      const CompiledModel model = compile_text(ripple(level, size));
      const RunResult run = run_with(model, find_setting(model.program, model.inputs, accuracy, {}));
      const std::vector<double> found = column(run, "T");
      double error = 0.0;
      for (std::size_t i = 0; i < found.size(); ++i) {
        const double t = run.trace.times[i];
        const double exact = (std::cos(50.0 * t) + 50.0 * std::sin(50.0 * t) - std::exp(-t)) / 2501.0;
        error = std::max(error, std::abs(found[i] - std::stod(level) - std::stod(size) * exact));
      }
      CHECK(error <= accuracy * std::stod(size) * 0.04);  // the range is 2*50/2501
    }
}

TEST_CASE("a search whose runs all have the same steps goes on by leaps, and judges no run by itself") {
  // Radau makes the same 80 steps from 1e-7 to 1e-10: q = 1e6 - 100 t + sin(30 t)/100.
  const CompiledModel model = compile_text(R"json({ "bgsim": 1, "name": "descent",
    "signals": { "y": { "integral": "0.3*cos(30*t) - 100", "initial": 1e6 } },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": 1 }, "j": { "kind": "1" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "z": "y + 100*t" }, "scenes": { "main": { "stop": 2, "samples": 301 } } })json");
  for (const double accuracy : {1e-3, 5e-5, 3e-5, 1e-5}) {
    INFO(accuracy);
    const TradePick pick = find_setting(model.program, model.inputs, accuracy, {});
    CHECK(pick.reference.setting.relative < 0.9 * pick.setting.relative);
    const RunResult run = run_with(model, pick);
    double error = 0.0;
    for (std::size_t i = 0; i < run.trace.times.size(); ++i)
      error = std::max(error, std::abs(column(run, "z")[i] - 1e6 - 0.01 * std::sin(30.0 * run.trace.times[i])));
    CHECK(error <= 0.02 * accuracy);  // the range is 0.02
  }
}

TEST_CASE("an output that only loose runs take for zero is one that moves") {
  // y' is a pulse where a decay passes 0.3; loose runs pass over it, and y is 0 at all times.
  const CompiledModel model = compile_text(R"json({ "bgsim": 1, "name": "pulse",
    "signals": { "x": { "integral": "-x", "initial": 1 }, "y": { "integral": "exp(-((x - 0.3)/1e-4)^2)" } },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": 1 }, "j": { "kind": "1" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "y": "y" }, "scenes": { "main": { "stop": 5, "samples": 61 } } })json");
  for (const double accuracy : {1e-2, 1e-3, 1e-5}) {
    // The integral of exp(-((x - 0.3)/w)^2)/x by x: sqrt(pi) w/0.3 (1 + (w/0.3)^2/2).
    const double exact = std::sqrt(std::acos(-1.0)) * 1e-4 / 0.3 * (1.0 + 0.5e-8 / 0.09);
    const RunResult run = run_with(model, find_setting(model.program, model.inputs, accuracy, {}));
    CHECK(std::abs(column(run, "y").back() / exact - 1.0) <= accuracy);
  }
}

TEST_CASE("what cannot be measured is refused with the reason") {
  const auto words = [](const std::string& text, double accuracy) {
    const CompiledModel model = compile_text(text);
    TradeOptions options;
    options.budget = 1.0;
    try {
      find_setting(model.program, model.inputs, accuracy, options);
    } catch (const TradeFailure& failure) {
      CHECK(failure.what() == failure.diagnostic.code + ": " + failure.diagnostic.situation);
      return failure.diagnostic.code + " " + failure.diagnostic.situation;
    }
    return std::string();
  };
  const std::string no_states = R"json({ "bgsim": 1, "name": "divider",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "f": "r.f" }, "scenes": { "main": { "stop": 1, "samples": 3 } } })json";
  CHECK_THAT(words(no_states, 1e-3), Contains("BG611 the model has no states"));
  std::string nothing_moves = oscillator("0.2");
  nothing_moves.replace(nothing_moves.find("\"q\": 1 }"), 8, "\"q\": 0 }");
  CHECK_THAT(words(nothing_moves, 1e-3), Contains("BG611 no output of the scene moves"));
  CHECK_THAT(words(oscillator("0.2"), 1e-15), Contains("BG612 the accuracy 1e-15 cannot be verified"));
  // A quotient of two states that die out is known to no digit at the end.
  const std::string drowned = R"json({ "bgsim": 1, "name": "quotient",
    "signals": { "x": { "integral": "-30*x", "initial": 1 }, "y": { "integral": "-30*y + 0.1*x", "initial": 1 } },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": 1 }, "j": { "kind": "1" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "q": "y/x" }, "scenes": { "main": { "stop": 2, "samples": 21 } } })json";
  CHECK_THAT(words(drowned, 1e-3),
             Contains("BG612 the accuracy 0.001 cannot be verified") && Contains("by as much as \"q\" varies"));
}

TEST_CASE("a search for an accuracy ends with its limits of time and steps") {
  const CompiledModel model = compile_text(oscillator("0.2"));
  const auto words = [&](const TradeOptions& options) {
    try {
      find_setting(model.program, model.inputs, 1e-6, options);
    } catch (const TradeFailure& failure) {
      return failure.diagnostic.code + " " + failure.diagnostic.situation +
             (failure.diagnostic.notes.empty() ? "" : "; " + failure.diagnostic.notes.front().text);
    }
    return std::string();
  };
  TradeOptions late, few;
  late.time_limit = 1e-9;
  few.max_steps = 3;
  CHECK(words(late) ==
        "BG618 the limit of wall time was reached before a setting for the accuracy 1e-06 was found; "
        "runs so far: 1");
  CHECK_THAT(words(few), Contains("BG611 no method comes to the end") && Contains("the limit of 3 steps was reached"));
}
