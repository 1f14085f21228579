// The engine against the tableau of the same graph by collocation, over random graphs with nonlinear laws, modulated
// two-ports and fields. Some tens of graphs here; BGSIM_RANDOM_ROUNDS=2000 for more (BGSIM_RANDOM_SEED: the first).

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>

#include "bgsim/bgsim.hpp"
#include "support/nonlinear_graph.hpp"
#include "support/rounds.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Tally {
  std::size_t compared = 0, refused = 0, unsure = 0, constant = 0;
  double largest = 0.0;
  std::map<std::string, std::size_t> codes;
};

/// The largest error of any output, relative to its range, with the output's name.
std::pair<double, std::string> worst_output(const NonlinearGraph& graph, const Trace& ours, const OracleTrace& theirs) {
  std::pair<double, std::string> worst{0.0, ""};
  for (const auto& [name, values] : theirs.columns) {
    const std::span<const double> column = ours[name];
    const auto [least, most] = std::minmax_element(column.begin(), column.end());
    // What is constant has no range: then all that moves by less than a thousandth of its own value is judged by that
    // value.
    const double range = std::max({*most - *least, 1e-3 * std::abs(*most), 1e-6});
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double t = ours.times[i + 1];
      if (std::abs(t - graph.jump_time) < 1e-9) continue;  // the oracle has the value before the jump there
      const double error = std::abs(column[i + 1] - values[i]) / range;
      if (!(error <= worst.first)) worst = {error, name + " at t = " + std::to_string(t)};
    }
  }
  return worst;
}

/// Leaves out the initial value that the message of BG405 names: "the initial value I_14.p = ...".
bool leave_out(NonlinearGraph& graph, const std::string& message) {
  for (auto& [name, value] : graph.initial) {
    std::string shown = name + ".";
    for (const NonlinearGraph::Field& field : graph.fields) {
      if (field.one == name) shown = field.name + ".a.";
      if (field.two == name) shown = field.name + ".b.";
    }
    if (value == 0.0 || message.find(" " + shown) == std::string::npos) continue;
    value = 0.0;
    return true;
  }
  return false;
}

/// A run of the graph. Where stores depend on each other, the initial values that contradict the others are left out.
RunResult run_consistently(NonlinearGraph& graph) {
  for (;;) {
    try {
      const Study study = Study::from_text(graph.json(), "random.json");
      SimulateOptions options;
      options.time_limit = 20.0;
      return study.scene("", {}, {.keep_all = true}).simulate(options);
    } catch (const ModelError& error) {
      if (error.diagnostics.front().code != "BG405") throw;
      if (!leave_out(graph, error.diagnostics.front().situation)) throw;
    }
  }
}

void compare(std::uint64_t seed, NonlinearGraph graph, Tally& tally) {
  INFO("seed " << seed);
  if (graph.initial.empty()) return;
  RunResult result;
  try {
    result = run_consistently(graph);
  } catch (const ModelError& error) {
    ++tally.refused;
    ++tally.codes[error.diagnostics.front().code];
    const std::string& code = error.diagnostics.front().code;
    INFO(graph.json() << error.what());
    CHECK((code.starts_with("BG3") || code == "BG207" || code == "BG205" || code == "BG402" || code == "BG411"));
    return;
  }
  INFO(graph.json());
  if (result.trace.times.empty()) {
    FAIL_CHECK(result.failure->code << ": " << result.failure->situation);
    return;
  }
  std::map<std::string, double> start;
  for (const std::string& name : result.trace.names)
    if (name.ends_with("_x")) start[name.substr(0, name.size() - 2)] = result.trace[name][0];
  const std::optional<OracleTrace> oracle = solve(graph, start, 1e-5);
  if (result.stop != StopReason::completed) {
    // Moduli that follow stores that depend on them can leave the equations without a solution.
    ++tally.codes[result.failure->code];
    INFO(result.failure->code << ": " << result.failure->situation);
    CHECK_FALSE(oracle);
    return;
  }
  if (!oracle) {
    ++tally.unsure;
    UNSCOPED_INFO("unsure");
    return;
  }
  const auto [error, where] = worst_output(graph, result.trace, *oracle);
  ++tally.compared;
  tally.largest = std::max(tally.largest, error);
  if (std::getenv("BGSIM_RANDOM_DETAILS") != nullptr && error > 1e-4)
    std::cout << "seed " << seed << ": " << error << " " << where << ", " << result.report.notes.size() << " notes\n";
  std::string notes;
  for (const std::string& note : result.report.notes) notes += "\n  " + note;
  INFO("error " << error << " of the range, " << where << "; oracle " << oracle->uncertainty << notes);
  CHECK((error <= 1e-3 || !result.report.notes.empty()));
}

bool starts_alike(const Trace& one, const Trace& two) {
  if (one.times.empty() || two.times.empty()) return false;
  for (const std::string& name : one.names)
    if (name.ends_with("_x") && std::abs(one[name][0] - two[name][0]) > 1e-9 * std::max(1.0, std::abs(one[name][0])))
      return false;
  return true;
}

/// The largest distance of any output from the same in another writing, relative to its range.
std::pair<double, std::string> distance(const Trace& plain, const Trace& other, const Writing& writing) {
  std::pair<double, std::string> worst{0.0, ""};
  for (const std::string& name : plain.names) {
    const bool stores_effort = name.starts_with("I");  // p is an effort times the time, q a flow
    const double unit = name.ends_with("_e") || (name.ends_with("_x") && stores_effort) ? writing.effort : writing.flow;
    const std::span<const double> one = plain[name], two = other[name];
    const auto [least, most] = std::minmax_element(one.begin(), one.end());
    const double range = std::max({*most - *least, 1e-3 * std::abs(*most), 1e-6});
    for (std::size_t i = 0; i < one.size(); ++i) {
      const double error = std::abs(one[i] - two[i] / unit) / range;
      if (!(error <= worst.first)) worst = {error, name + " at t = " + std::to_string(plain.times[i])};
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("Runs of random graphs with nonlinear laws are those of the tableau") {
  NonlinearGraphOptions options;
  options.graph.most_rings = 1;
  options.graph.most_junctions = 4;
  options.graph.sources = 0.25;
  Tally tally;
  const std::uint64_t rounds = from_environment("BGSIM_RANDOM_ROUNDS", share_of(40)),
                      first = from_environment("BGSIM_RANDOM_SEED", 1);
  for (std::uint64_t seed = first; seed < first + rounds; ++seed)
    compare(seed, random_nonlinear_graph(seed, options), tally);
  std::string codes;
  for (const auto& [code, count] : tally.codes) codes += " " + code + ": " + std::to_string(count);
  if (rounds > 40)
    std::cout << "compared " << tally.compared << ", refused " << tally.refused << ", unsure " << tally.unsure
              << ", largest error " << tally.largest << codes << "\n";
  CHECK(tally.compared > rounds / 2);
  CHECK(10 * tally.unsure < rounds);
}

TEST_CASE("The same graph written otherwise gives the same run") {
  NonlinearGraphOptions options;
  options.graph.most_rings = 1;
  options.graph.most_junctions = 4;
  options.graph.sources = 0.25;
  const std::uint64_t rounds = from_environment("BGSIM_RANDOM_ROUNDS", share_of(15)),
                      first = from_environment("BGSIM_RANDOM_SEED", 1);
  std::size_t compared = 0;
  std::map<std::string, double> largest;
  for (std::uint64_t seed = first; seed < first + rounds; ++seed) {
    NonlinearGraph graph = random_nonlinear_graph(seed, options);
    if (graph.initial.empty()) continue;
    RunResult plain;
    try {
      plain = run_consistently(graph);
    } catch (const ModelError&) {
      continue;
    }
    if (plain.stop != StopReason::completed) continue;
    const std::pair<const char*, Writing> others[]{{"in another order", {.order = seed + 1}},
                                                   {"with other names", {.renamed = true}},
                                                   {"with half-arrows reversed", {.reversed = true}},
                                                   {"in other units", {.effort = 0x1p20, .flow = 0x1p-10}},
                                                   {"in units that round", {.effort = 1e-7, .flow = 1e3}}};
    for (const auto& [words, writing] : others) {
      INFO("seed " << seed << " " << words);
      const std::string text = graph.json(writing);
      INFO(text);
      RunResult other;
      try {
        other = Study::from_text(text, "random.json").scene("", {}, {.keep_all = true}).simulate();
      } catch (const ModelError& error) {
        // The order decides which of equal stores is independent, and so which may be given an initial value.
        const bool may_differ = writing.order != 0 && error.diagnostics.front().code == "BG405";
        if (!may_differ) FAIL_CHECK(error.what());
        continue;
      }
      // Where stores depend on each other and not all have an initial value, the order decides which one follows.
      if (writing.order != 0 && !starts_alike(plain.trace, other.trace)) continue;
      if (other.failure) {
        FAIL_CHECK(other.failure->situation);
        continue;
      }
      const auto [error, where] = distance(plain.trace, other.trace, writing);
      if (std::getenv("BGSIM_RANDOM_DETAILS") != nullptr && error > 1e-5)
        std::cout << "seed " << seed << " " << words << ": " << error << " " << where << "\n";
      largest[words] = std::max(largest[words], error);
      ++compared;
      INFO("apart by " << error << " of the range, " << where << ", of" << graph.json());
      // Each is within some 1e-4 of the exact solution: the order decides which stores are independent and which loops
      // are torn where, and so where steps end.
      CHECK(error <= 1e-3);
    }
  }
  if (rounds > 15)
    for (const auto& [words, error] : largest) std::cout << words << ": apart by " << error << " at most\n";
  CHECK(compared > rounds);
}
