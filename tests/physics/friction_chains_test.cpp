// Dry frictions between many bodies: which of them hold is decided for all at once, and what holds does not move.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using nlohmann::json;

namespace {

/// Blocks in a row. Block i may rub on the ground, and on block i + 1, to which a spring may tie it.
struct Chain {
  std::vector<double> mass, ground;     ///< by block; limit of the friction, 0: none
  std::vector<double> between, spring;  ///< by pair of neighbours; limit, stiffness
  std::size_t pushed = 0;
  double amplitude = 0.0, frequency = 0.0;
  int shape = 0;              ///< of the force on the pushed block, over 1 s
  std::vector<double> speed;  ///< by block, at the start

  [[nodiscard]] double force(double t) const {
    return amplitude * (shape == 0 ? t : shape == 1 ? std::sin(frequency * t) : std::cos(frequency * t));
  }
  [[nodiscard]] std::string law() const {
    const std::string a = json(amplitude).dump(), w = json(frequency).dump();
    return shape == 0 ? a + "*t" : a + (shape == 1 ? "*sin(" : "*cos(") + w + "*t)";
  }
};

std::string model_of(const Chain& chain) {
  json elements = json::object(), bonds = json::array(), outputs = json::object();
  const auto friction = [](double limit) {
    return json{{"kind", "R"}, {"law", "e = " + json(limit).dump() + "*sign(f)"}};
  };
  const auto bond = [&](const std::string& from, const std::string& to) {
    bonds.push_back({{"from", from}, {"to", to}});
  };
  for (std::size_t i = 0; i < chain.mass.size(); ++i) {
    const std::string n = std::to_string(i);
    elements["v" + n] = {{"kind", "1"}};
    elements["m" + n] = {{"kind", "I"}, {"inertance", chain.mass[i]}, {"initial", {{"f", chain.speed[i]}}}};
    bond("v" + n, "m" + n);
    outputs["v" + n] = "m" + n + ".f";
    if (chain.ground[i] > 0.0) {
      elements["g" + n] = friction(chain.ground[i]);
      bond("v" + n, "g" + n);
    }
  }
  for (std::size_t i = 0; i + 1 < chain.mass.size(); ++i) {
    if (chain.between[i] == 0.0 && chain.spring[i] == 0.0) continue;
    const std::string n = std::to_string(i);
    elements["j" + n] = {{"kind", "0"}};
    elements["k" + n] = {{"kind", "1"}};
    bond("v" + std::to_string(i + 1), "j" + n);
    bond("j" + n, "v" + n);
    bond("j" + n, "k" + n);
    if (chain.between[i] > 0.0) {
      elements["n" + n] = friction(chain.between[i]);
      bond("k" + n, "n" + n);
    }
    if (chain.spring[i] > 0.0) {
      elements["s" + n] = {{"kind", "C"}, {"capacitance", 1.0 / chain.spring[i]}};
      bond("k" + n, "s" + n);
    }
  }
  elements["push"] = {{"kind", "Se"}, {"effort", chain.law()}};
  bond("push", "v" + std::to_string(chain.pushed));
  return json{{"bgsim", 1},     {"name", "chain"},    {"elements", elements},
              {"bonds", bonds}, {"outputs", outputs}, {"scenes", {{"main", {{"stop", 1}, {"samples", 11}}}}}}
      .dump();
}

/// Speeds every 0.1 s by time stepping: each step's impulses of friction are within their limits and take the speed
/// that they rub at, or what of it they can (Moreau's scheme; Gauss-Seidel over the frictions). Of first order.
std::vector<std::vector<double>> by_time_stepping(const Chain& chain, std::size_t steps) {
  const std::size_t n = chain.mass.size();
  const double h = 1.0 / static_cast<double>(steps);
  struct Friction {
    std::size_t above;
    int below;  ///< -1: the ground
    double limit, impulse = 0.0;
  };
  std::vector<Friction> frictions;
  for (std::size_t i = 0; i < n; ++i) {
    if (chain.ground[i] > 0.0) frictions.push_back({i, -1, h * chain.ground[i]});
    if (i + 1 < n && chain.between[i] > 0.0) frictions.push_back({i + 1, static_cast<int>(i), h * chain.between[i]});
  }
  std::vector<double> v = chain.speed, way(n, 0.0);
  std::vector<std::vector<double>> speeds{v};
  for (std::size_t step = 1; step <= steps; ++step) {
    std::vector<double> w = v;
    w[chain.pushed] += h * chain.force((static_cast<double>(step) - 0.5) * h) / chain.mass[chain.pushed];
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const double pull = h * chain.spring[i] * (way[i] + 0.5 * h * (v[i + 1] - v[i]));
      w[i] += pull / chain.mass[i];
      w[i + 1] -= pull / chain.mass[i + 1];
    }
    const auto give = [&](const Friction& at, double impulse) {
      w[at.above] -= impulse / chain.mass[at.above];
      if (at.below >= 0)
        w[static_cast<std::size_t>(at.below)] += impulse / chain.mass[static_cast<std::size_t>(at.below)];
    };
    for (const Friction& each : frictions) give(each, each.impulse);
    for (int round = 0; round < 1000; ++round) {
      double change = 0.0;
      for (Friction& each : frictions) {
        const std::size_t below = each.below < 0 ? n : static_cast<std::size_t>(each.below);
        const double rubs = w[each.above] - (below < n ? w[below] : 0.0);
        const double mobility = 1.0 / chain.mass[each.above] + (below < n ? 1.0 / chain.mass[below] : 0.0);
        const double next = std::clamp(each.impulse + rubs / mobility, -each.limit, each.limit);
        change = std::max(change, std::abs(next - each.impulse) / each.limit);
        give(each, next - each.impulse);
        each.impulse = next;
      }
      if (change < 1e-9) break;
    }
    for (std::size_t i = 0; i + 1 < n; ++i) way[i] += 0.5 * h * (v[i + 1] - v[i] + w[i + 1] - w[i]);
    v = w;
    if (step % (steps / 10) == 0) speeds.push_back(v);
  }
  return speeds;
}

Chain random_chain(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto chance = [&](double part) { return std::uniform_real_distribution<double>(0.0, 1.0)(random) < part; };
  const auto between = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
  };
  Chain chain;
  const auto n = static_cast<std::size_t>(2.0 * between(1.0, 2.99));
  for (std::size_t i = 0; i < n; ++i) {
    chain.mass.push_back(between(0.2, 5.0));
    chain.ground.push_back(i == 0 || chance(0.6) ? between(0.3, 3.0) : 0.0);
    if (i + 1 == n) break;
    chain.between.push_back(chance(0.8) ? between(0.3, 6.0) : 0.0);
    chain.spring.push_back(chain.between.back() == 0.0 || chance(0.3) ? between(1.0, 300.0) : 0.0);
  }
  chain.pushed = static_cast<std::size_t>(random() % n);
  chain.amplitude = chain.ground[0] * between(0.4, 5.0);
  chain.frequency = between(1.0, 30.0);
  chain.shape = static_cast<int>(random() % 3);
  const bool moves = chance(0.3);
  for (std::size_t i = 0; i < n; ++i) chain.speed.push_back(moves ? between(0.1, 2.0) - 0.7 : 0.0);
  return chain;
}

}  // namespace

TEST_CASE("stacked blocks stay at rest under a force that both frictions can take, by every method") {
  // Of the lower block the rate was what rounding leaves of a balance, and so its tolerance, too; the force on the
  // upper one was lost beside a step of that length: it ran against the force (dirk5), or for years.
  const Chain chain{{2.0, 1.0}, {1.0, 0.0}, {3.0}, {0.0}, 1, 0.5, 0.0, 0, {0.0, 0.0}};
  for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::radau,
                              Method::rodas5p, Method::dirk3, Method::dirk5, Method::erk5}) {
    INFO(method_name(method));
    const RunResult run = run_text(model_of(chain), with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(run.report.steps < 50);
    for (const std::string name : {"v0", "v1"})
      for (const double v : column(run, name)) CHECK(v == 0.0);
  }
}

TEST_CASE("frictions that hold two blocks three ways let go where the force exceeds what they can take together") {
  // Both blocks rub on the ground and on each other. The first is pushed by 2 t: its ground takes 0.3, the second block
  // what goes on to its own ground, 0.2 at most, of the 0.6 between them: both start as one at t = 0.25.
  const Chain chain{{1.0, 2.0}, {0.3, 0.2}, {0.6}, {0.0}, 0, 2.0, 0.0, 0, {0.0, 0.0}};
  json model = json::parse(model_of(chain));
  model["outputs"]["F"] = "g1.e";
  model["outputs"]["a"] = "der(m1.f)";
  const RunResult run = run_text(model.dump(), with_relative(1e-8));
  REQUIRE(run.stop == StopReason::completed);
  // What each friction takes before that is one of many shares, which a force shows and an acceleration does not.
  CHECK(std::count_if(run.report.notes.begin(), run.report.notes.end(),
                      [](const std::string& note) { return note.find("\"F\" is indefinite") != note.npos; }) == 1);
  for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
    // 3 v' = 2 t - 0.5 = 2 s, for which the friction between them gives 2 v' + 0.2: its 0.6 at s = 0.3. From there on
    // the first has 2 t - 0.9 and the second 0.4.
    const double s = std::max(0.0, run.trace.times[i] - 0.25), sliding = std::max(0.0, s - 0.3);
    const double together = std::pow(s - sliding, 2) / 3.0;
    const double v1 = together + 0.2 * sliding + sliding * sliding, v2 = together + 0.2 * sliding;
    CHECK(column(run, "v0")[i] == Approx(v1).margin(1e-7));  // ten tolerances
    CHECK(column(run, "v1")[i] == Approx(v2).margin(1e-7));
  }
}

TEST_CASE("a block whose velocity an event turns slides on") {
  // It was held at the velocity that the event gave it.
  const RunResult run = run_text(R"x({"bgsim": 1, "name": "kick",
    "elements": {"v": {"kind": "1"}, "m": {"kind": "I", "inertance": 1, "initial": {"f": 1}}, "F": {"kind": "R", "law": "e = 0.5*sign(f)"}},
    "bonds": [{"from": "v", "to": "m"}, {"from": "v", "to": "F"}], "outputs": {"v": "m.f"},
    "events": {"kick": {"when": "t >= 0.5", "set": {"m.p": "-pre(m.p)"}}},
    "scenes": {"run": {"stop": 3, "samples": 7}}})x");
  REQUIRE(run.stop == StopReason::completed);
  const std::vector<double> v = column(run, "v");
  const double right[] = {1.0, -0.75, -0.5, -0.25, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < v.size(); ++i) CHECK(v[i] == Approx(right[i]).margin(1e-12));  // straight lines
}

TEST_CASE("random chains of blocks that rub on each other move as by time stepping") {
  const std::uint64_t first = from_environment("BGSIM_RANDOM_SEED", 1), rounds = share_of(40);
  for (std::uint64_t seed = first; seed < first + from_environment("BGSIM_RANDOM_ROUNDS", rounds); ++seed) {
    const Chain chain = random_chain(seed);
    INFO(seed << ' ' << model_of(chain));
    const std::vector<std::vector<double>> speeds = by_time_stepping(chain, 10'000);
    double largest = 1e-3;
    for (const std::vector<double>& row : speeds)
      for (const double v : row) largest = std::max(largest, std::abs(v));
    for (const Method method : {Method::automatic, Method::dirk5}) {
      INFO(method_name(method));
      const RunResult run = run_text(model_of(chain), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < chain.mass.size(); ++k) {
        const std::vector<double> v = column(run, "v" + std::to_string(k));
        // The error of the time stepping: of first order in 1e-4 s, with a friction's whole impulse where it turns.
        for (std::size_t i = 0; i < v.size(); ++i) CHECK(std::abs(v[i] - speeds[i][k]) <= 2e-3 * largest);
      }
    }
  }
}
