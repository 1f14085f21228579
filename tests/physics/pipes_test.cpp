// Networks of pipes without inertia: turbulent laws, whose slope is 0 or has no bound where the flow is 0. All laws
// rise, so there is one solution; it is held against the laws, the balance of every node, and the potentials.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "support/circuit.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// The same turbulent pipe e = k f |f|, in several ways; and with a laminar part.
enum class Writing { effort, root, root_of_quotient, power, sign, laminar_too };
constexpr Writing kWritings[] = {Writing::effort, Writing::root, Writing::root_of_quotient,
                                 Writing::power,  Writing::sign, Writing::laminar_too};

struct Pipe {
  std::string name, from, to;
  double k = 1.0;
  Writing writing = Writing::effort;
};

std::string law(const Pipe& pipe) {
  const std::string k = std::to_string(pipe.k);
  switch (pipe.writing) {
    case Writing::effort:
      return "e = " + k + "*f*abs(f)";
    case Writing::root:
      return "f = 1/sqrt(" + k + ")*sign(e)*sqrt(abs(e))";
    case Writing::root_of_quotient:
      return "f = sign(e)*sqrt(abs(e)/" + k + ")";
    case Writing::power:
      return "f = sign(e)*(abs(e)/" + k + ")^0.5";
    case Writing::sign:
      return "e = " + k + "*sign(f)*f^2";
    case Writing::laminar_too:
      break;
  }
  return "e = " + k + "*f*abs(f) + 0.1*f";
}

double drop(const Pipe& pipe, double f) {
  const double k = std::stod(std::to_string(pipe.k));
  return k * f * std::abs(f) + (pipe.writing == Writing::laminar_too ? 0.1 * f : 0.0);
}

struct Tolerances {
  double laws = 1e-12, balances = 1e-12;  ///< of the largest effort and flow: Newton's iteration ends at 1e-13
};

/// Runs pipes and what else there is with a source from the reference to "a", and checks each record.
void check(const std::vector<Pipe>& pipes, const std::string& kind, const std::string& value,
           std::vector<Part> parts = {}, const Tolerances& tolerances = {}, const std::string& samples = "21") {
  for (const Pipe& pipe : pipes)
    parts.push_back({pipe.name, "R", pipe.from, pipe.to, "\"law\": \"" + law(pipe) + "\""});
  parts.push_back({"s", kind, "a", "0", (kind == "Se" ? "\"effort\": \"" : "\"flow\": \"") + value + "\""});
  std::string outputs;
  for (const Part& part : parts)
    for (const std::string variable : {"e", "f"})
      outputs +=
          (outputs.empty() ? "\"" : ", \"") + part.name + "_" + variable + "\": \"" + part.name + "." + variable + "\"";
  const RunResult run = run_text(circuit(parts, outputs, R"("stop": 2, "samples": )" + samples));
  REQUIRE(run.stop == StopReason::completed);
  std::map<std::string, std::vector<double>> e, f;
  double most_e = 0.0, most_f = 0.0;
  for (const Part& part : parts) {
    e[part.name] = column(run, part.name + "_e");
    f[part.name] = column(run, part.name + "_f");
    most_e = std::max(most_e, largest_magnitude(e[part.name]));
    most_f = std::max(most_f, largest_magnitude(f[part.name]));
  }
  for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
    INFO("t = " << run.trace.times[k]);
    std::map<std::string, double> balance, potential{{"0", 0.0}};
    double worst_law = 0.0, worst_ring = 0.0, worst_balance = 0.0;
    for (const Pipe& pipe : pipes)
      worst_law = std::max(worst_law, std::abs(e[pipe.name][k] - drop(pipe, f[pipe.name][k])));
    for (const Part& part : parts) {
      // A source's flow leaves it for the first node.
      const double flow = (part.name == "s" ? -1.0 : 1.0) * f[part.name][k];
      balance[part.from] -= flow;
      balance[part.to] += flow;
    }
    for (std::size_t known = 0; known != potential.size();) {
      known = potential.size();
      for (const Part& part : parts) {
        const double drop = e[part.name][k];
        if (potential.count(part.from) != 0) potential.try_emplace(part.to, potential[part.from] - drop);
        if (potential.count(part.to) != 0) potential.try_emplace(part.from, potential[part.to] + drop);
      }
    }
    for (const Part& part : parts)
      worst_ring = std::max(worst_ring, std::abs(potential[part.from] - potential[part.to] - e[part.name][k]));
    for (const auto& [node, sum] : balance)
      if (node != "0") worst_balance = std::max(worst_balance, std::abs(sum));
    CHECK(worst_law <= tolerances.laws * most_e);
    CHECK(worst_ring <= tolerances.balances * most_e);
    CHECK(worst_balance <= tolerances.balances * most_f);
  }
}

/// A grid of nodes, from "a" in one corner to the reference in the other, and to it from some others.
std::vector<Pipe> grid(int side, const std::vector<Writing>& writings, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> decade(-1.0, 1.0);
  std::vector<Pipe> pipes;
  const auto node = [](int i, int j) { return i + j == 0 ? "a" : "n" + std::to_string(i) + "_" + std::to_string(j); };
  const auto pipe = [&](const std::string& from, const std::string& to) {
    const std::string name = "p" + std::to_string(pipes.size());
    pipes.push_back({name, from, to, std::pow(10.0, decade(random)), writings[random() % writings.size()]});
  };
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      if (i + 1 < side) pipe(node(i, j), node(i + 1, j));
      if (j + 1 < side) pipe(node(i, j), node(i, j + 1));
    }
  pipe(node(side - 1, side - 1), "0");
  pipe(node(side / 2, 1), "0");
  pipe(node(1, side - 1), "0");
  return pipes;
}

struct Source {
  std::string kind, value;
};
const std::vector<Source> kSources{{"Se", "10"}, {"Se", "10*sin(3*t)"},  {"Sf", "2*sin(3*t)"},
                                   {"Se", "t"},  {"Sf", "1e-3*(1 - t)"}, {"Se", "0"}};

}  // namespace

TEST_CASE(
    "turbulent pipes in series, in parallel and in bridges have the solution of their laws, however these are "
    "written",
    "[long]") {
  for (const Writing writing : kWritings)
    for (const Source& source : kSources) {
      INFO(source.kind << " " << source.value);
      const std::vector<Pipe> series{
          {"p1", "a", "b", 2, writing}, {"p2", "b", "c", 3, writing}, {"p3", "c", "0", 5, writing}};
      const std::vector<Pipe> parallel{{"p1", "a", "0", 2, writing},
                                       {"p2", "a", "0", 3, writing},
                                       {"p3", "a", "b", 1, writing},
                                       {"p4", "b", "0", 4, writing}};
      const auto bridge = [writing](double k) {
        return std::vector<Pipe>{{"p1", "a", "b", 2, writing},
                                 {"p2", "a", "c", 3, writing},
                                 {"p3", "b", "c", 1, writing},
                                 {"p4", "b", "0", 4, writing},
                                 {"p5", "c", "0", k, writing}};
      };
      for (const std::vector<Pipe>& pipes : {series, parallel, bridge(1), bridge(6)})  // the last one is balanced
        check(pipes, source.kind, source.value);
    }
}

TEST_CASE("grids of pipes, laminar and turbulent, have the solution of their laws at sources that pass through zero",
          "[long]") {
  for (unsigned seed = 0; seed < 6; ++seed)
    for (const Source& source : {Source{"Se", "10*sin(3*t)"}, Source{"Sf", "2*sin(3*t)"}}) {
      INFO("seed " << seed << ", " << source.kind);
      check(grid(3 + static_cast<int>(seed), {std::begin(kWritings), std::end(kWritings)}, seed), source.kind,
            source.value);
    }
}

TEST_CASE("a grid of a thousand turbulent pipes has the solution of its laws", "[long]") {
  const std::vector<Pipe> pipes = grid(23, {Writing::effort, Writing::root, Writing::laminar_too}, 1);
  REQUIRE(pipes.size() > 1000);
  check(pipes, "Se", "10 + t", {}, {}, "3");
}

TEST_CASE("a grid of pipes with stores at nodes has the solution of its laws at every moment", "[long]") {
  std::vector<Part> stores;
  for (int k = 0; k < 3; ++k)
    stores.push_back({"c" + std::to_string(k), "C", "n" + std::to_string(k + 1) + "_1", "0",
                      "\"capacitance\": 0.5, \"initial\": { \"q\": " + std::to_string(k + 1) + " }"});
  // The loop has fewer than 64 variables and is solved inside the rates.
  check(grid(5, {Writing::effort, Writing::laminar_too}, 7), "Se", "10*sin(3*t)", stores);
  // Here IDA knows the variables of the loop to 1e-6.
  check(grid(9, {Writing::effort, Writing::laminar_too}, 7), "Se", "10*sin(3*t)", stores, {1e-4, 1e-5});
}
