// Rodas5P: its formula, inputs of time, events, loops. What it reaches is in stiff_methods_test.cpp.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <set>

#include "run/integrate/rodas_formula.hpp"
#include "support/fed_states.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr std::size_t kStages = rodas::kStages;
using Row = std::array<long double, kStages>;
using Matrix = std::array<Row, kStages>;

/// The method as k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j, which the form without products is made of by
/// U = Gamma k.
struct Formula {
  Matrix alpha{}, beta{};
  Row b{}, embedded{};
  Matrix gamma{};

  Formula() {
    Matrix inverse{};  // of Gamma: lower triangular
    for (std::size_t i = 0; i < kStages; ++i) {
      inverse[i][i] = 1.0L / static_cast<long double>(rodas::kGamma);
      for (std::size_t j = 0; j < i; ++j) inverse[i][j] = -static_cast<long double>(rodas::kRight[i][j]);
    }
    for (std::size_t j = 0; j < kStages; ++j)
      for (std::size_t i = j; i < kStages; ++i) {
        long double rest = i == j ? 1.0L : 0.0L;
        for (std::size_t k = j; k < i; ++k) rest -= inverse[i][k] * gamma[k][j];
        gamma[i][j] = rest / inverse[i][i];
      }
    for (std::size_t i = 0; i < kStages; ++i) {
      Row state{};
      for (std::size_t j = 0; j < i; ++j) state[j] = rodas::kState[i][j];
      alpha[i] = by_increments(state);
      for (std::size_t j = 0; j < kStages; ++j) beta[i][j] = alpha[i][j] + gamma[i][j];
    }
    embedded = alpha[kStages - 1];
    for (std::size_t j = 0; j < kStages; ++j) b[j] = embedded[j] + gamma[kStages - 1][j];
  }

  /// Weights of k for weights of U.
  [[nodiscard]] Row by_increments(const Row& weights) const {
    Row result{};
    for (std::size_t k = 0; k < kStages; ++k)
      for (std::size_t j = 0; j < kStages; ++j) result[j] += weights[k] * gamma[k][j];
    return result;
  }
  [[nodiscard]] Row dense(long double u) const {
    Row weights{};
    for (std::size_t j = 0; j < kStages; ++j) {
      const long double end = j + 1 < kStages ? static_cast<long double>(rodas::kState[kStages - 1][j]) : 1.0L;
      const long double bend = rodas::kDense[0][j] + u * (rodas::kDense[1][j] + u * rodas::kDense[2][j]);
      weights[j] = u * end + u * (1.0L - u) * bend;
    }
    return by_increments(weights);
  }
};

/// A rooted tree, by what hangs on its root, in order.
struct Tree {
  std::vector<Tree> branches;
  friend bool operator<(const Tree& a, const Tree& b) {
    return std::lexicographical_compare(a.branches.begin(), a.branches.end(), b.branches.begin(), b.branches.end());
  }
  [[nodiscard]] int order() const {
    int sum = 1;
    for (const Tree& branch : branches) sum += branch.order();
    return sum;
  }
  [[nodiscard]] long double density() const {
    long double product = order();
    for (const Tree& branch : branches) product *= branch.density();
    return product;
  }
};

/// Those that have a node more.
std::set<Tree> grown_from(const Tree& tree) {
  std::set<Tree> grown;
  const auto add = [&grown](Tree one) {
    std::sort(one.branches.begin(), one.branches.end());
    grown.insert(std::move(one));
  };
  Tree with = tree;
  with.branches.emplace_back();
  add(with);
  for (std::size_t i = 0; i < tree.branches.size(); ++i)
    for (const Tree& other : grown_from(tree.branches[i])) {
      Tree changed = tree;
      changed.branches[i] = other;
      add(changed);
    }
  return grown;
}
std::set<Tree> trees_of(int order) {
  std::set<Tree> all{Tree{}};
  for (int n = 1; n < order; ++n) {
    std::set<Tree> next;
    for (const Tree& tree : all) next.merge(grown_from(tree));
    all = std::move(next);
  }
  return all;
}

/// By stage. A root with one branch has the coefficients with the Jacobian's part, one with several those without.
/// (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.7.)
Row elementary_weight(const Formula& formula, const Tree& tree) {
  const Matrix& coefficients = tree.branches.size() == 1 ? formula.beta : formula.alpha;
  Row result;
  result.fill(1.0L);
  for (const Tree& branch : tree.branches) {
    const Row of_branch = elementary_weight(formula, branch);
    for (std::size_t i = 0; i < kStages; ++i) {
      long double sum = 0.0L;
      for (std::size_t j = 0; j < kStages; ++j) sum += coefficients[i][j] * of_branch[j];
      result[i] *= sum;
    }
  }
  return result;
}

/// How far weights are from what the trees of an order ask for at @p u of the step, relative to that at its end.
long double defect(const Formula& formula, const Row& weights, int order, long double u = 1.0L) {
  long double worst = 0.0L;
  for (const Tree& tree : trees_of(order)) {
    const Row of_tree = elementary_weight(formula, tree);
    long double sum = 0.0L;
    for (std::size_t i = 0; i < kStages; ++i) sum += weights[i] * of_tree[i];
    worst = std::max(worst, std::abs(sum * tree.density() - std::pow(u, static_cast<long double>(order))));
  }
  return worst;
}

RunResult rodas_run(const std::vector<FedState>& states, const std::string& scene, double relative) {
  RunResult result = run_text(fed_states(states, scene), with_method(Method::rodas5p, relative));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

}  // namespace

TEST_CASE(
    "Rodas5P satisfies all order conditions up to order 5, its embedded formula and its dense output to order 4") {
  const Formula formula;
  CHECK(trees_of(5).size() == 9);
  // Coefficients of up to 150 are given with the digits of a double.
  constexpr long double kDigits = 1e-12L;
  for (int order = 1; order <= 5; ++order) {
    CAPTURE(order);
    CHECK(defect(formula, formula.b, order) < kDigits);
    for (const long double u : {0.1L, 0.3L, 0.5L, 0.8L, 1.0L})
      if (order <= 4) CHECK(defect(formula, formula.dense(u), order, u) < kDigits);
    if (order <= 4) CHECK(defect(formula, formula.embedded, order) < kDigits);
  }
  CHECK(defect(formula, formula.embedded, 5) > 0.1L);
  CHECK(defect(formula, formula.b, 6) > 0.1L);
  for (std::size_t i = 0; i < kStages; ++i) {
    long double at = 0.0L, by_time = 0.0L;
    for (std::size_t j = 0; j < kStages; ++j) {
      at += formula.alpha[i][j];
      by_time += formula.gamma[i][j];
    }
    CHECK(std::abs(at - rodas::kAt[i]) < kDigits);
    CHECK(std::abs(by_time - rodas::kTime[i]) < kDigits);
  }
  CHECK(formula.dense(0.0L)[0] == 0.0L);
}

TEST_CASE("the correction that Rodas5P's dense output is checked with has the slope that its matrix asks for") {
  constexpr double u = rodas::kCheckedAt, h = 1e-5;  // a central difference, wrong by h^2
  const double slope = (rodas::bubble(u + h) - rodas::bubble(u - h)) / (2.0 * h);
  CHECK(slope / rodas::bubble(u) == Approx(rodas::kShift).epsilon(1e-7));
  CHECK(rodas::bubble(0.5) == rodas::kLargestBubble);
}

TEST_CASE("Rodas5P sees pulses and fast drives that come and go within its steps") {
  // y is at rest, or slow, until the input acts. Stiffly accurate Rosenbrock methods step over what happens between
  // their stages where nothing but the embedded formula is asked.
  struct Driven {
    std::string name, rate;
    std::function<double(double)> exact;
  };
  const double root_pi = std::sqrt(std::numbers::pi);
  const auto bell = [&](double width) {
    return [=](double t) { return 0.5 * root_pi * width * (std::erf((t - 5.0) / width) + std::erf(5.0 / width)); };
  };
  const std::vector<Driven> problems = {
      {"a bell of 0.1", "exp(-((t - 5)/0.1)^2)", bell(0.1)},
      {"a bell of 0.02", "exp(-((t - 5)/0.02)^2)", bell(0.02)},
      {"a fast sine", "sin(300*t)", [](double t) { return (1.0 - std::cos(300.0 * t)) / 300.0; }},
      {"a burst", "cos(200*t)*exp(-(t - 5)^2)", [=](double) { return root_pi * std::exp(-1e4) * std::cos(1000.0); }},
      {"held stiffly to a fast sine", "-1e5*(y.q - sin(300*t)) + 300*cos(300*t)",
       [](double t) { return std::sin(300.0 * t); }}};
  for (const Driven& problem : problems)
    for (const double relative : {1e-4, 1e-6, 1e-8}) {
      const RunResult result = rodas_run({{"y", "0", problem.rate}}, R"("stop": 10, "samples": 2)", relative);
      double largest = 0.0;
      for (int i = 0; i <= 1000; ++i) largest = std::max(largest, std::abs(problem.exact(0.01 * i)));
      // The burst leaves nothing behind; its height is a cycle's half.
      if (problem.name == "a burst") largest = 1.0 / 200.0;
      CAPTURE(problem.name, relative, result.report.steps);
      // Some tens of tolerances; the errors of nearly five hundred periods of the fast sine add up.
      CHECK(std::abs(result.trace.columns[0].back() - problem.exact(10.0)) < 100.0 * relative * largest);
    }
}

namespace {

/// Slopes by time against central differences of the rates: these are wrong by the square of their move times a third
/// slope of some tens.
void hold_time_slopes(const CompiledModel& compiled, const std::vector<double>& x, const std::vector<double>& times) {
  constexpr double kMove = 1e-5;
  Evaluator evaluator(compiled.program, compiled.inputs.parameters);
  CHECK(evaluator.names_time());
  Branch branch = first_branch(compiled.program);
  std::vector<double> slopes(x.size()), before(x.size()), after(x.size());
  for (const double t : times) {
    INFO("t = " << t);
    REQUIRE(evaluator.initialize_modes(t, x.data(), branch));
    REQUIRE(evaluator.time_slopes(t, x.data(), branch, slopes.data()));
    REQUIRE(evaluator.rates(t - kMove, x.data(), branch, before.data()));
    REQUIRE(evaluator.rates(t + kMove, x.data(), branch, after.data()));
    for (std::size_t i = 0; i < x.size(); ++i)
      CHECK(slopes[i] == Approx((after[i] - before[i]) / (2.0 * kMove)).margin(1e-8));
  }
}

}  // namespace

TEST_CASE("slopes of rates by time alone are those of differences, through loops and tables") {
  const CompiledModel loops = compile_text(R"json({ "bgsim": 1, "name": "timed",
    "elements": {
      "source": { "kind": "Se", "effort": "sin(3*t) + t^2" }, "loop": { "kind": "1" },
      "diode": { "kind": "R", "law": "f = 1e-1*(exp(e) - 1)" }, "r": { "kind": "R", "resistance": 2 },
      "node": { "kind": "0" }, "c": { "kind": "C", "law": "e = q*(1 + 0.1*cos(t))" },
      "branch": { "kind": "1" }, "l": { "kind": "I", "inertance": 1 }
    },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "diode" }, { "from": "loop", "to": "r" },
      { "from": "loop", "to": "node" }, { "from": "node", "to": "c" }, { "from": "node", "to": "branch" },
      { "from": "branch", "to": "l" } ],
    "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 1, "samples": 3 } } })json");
  REQUIRE(!loops.program.blocks.empty());
  hold_time_slopes(loops, {0.3, 0.2}, {0.0, 0.4, 1.3});

  const std::filesystem::path file = std::filesystem::temp_directory_path() / "bgsim_time_slopes.csv";
  std::ofstream(file) << "t,u\n0,1\n1,3\n2,2\n3,5\n";
  const std::string table = "table('" + file.string() + "', 'u', ";
  const CompiledModel tables = compile_text(
      fed_states({{"x", "0", table + "t)*(1 + t) - x.q"}, {"y", "0", table + "t - 0.1*x.q, spline)*sin(t)"}},
                 R"("stop": 2, "samples": 3)"));
  std::filesystem::remove(file);
  hold_time_slopes(tables, {0.3, 0.2}, {0.4, 1.3, 2.6});

  const CompiledModel still = compile_text(fed_states({{"x", "1", "-x.q"}}, R"("stop": 1, "samples": 2)"));
  Evaluator of_still(still.program, still.inputs.parameters);
  CHECK(!of_still.names_time());
}

TEST_CASE("Rodas5P goes on behind events at full order") {
  // A relay that heats to 1 and cools to 0 with a time constant of 1: events at known times.
  const std::string text =
      fed_states({{"x", "0", "if(sin(2*pi*t/0.7) > 0, 1, 0) - x.q"}, {"y", "0", "if(x.q > 0.5, 1, -1)"}},
                 R"("stop": 20, "samples": 201)");
  const RunResult exact = run_text(text, with_method(Method::radau, 1e-11));
  for (const double relative : {1e-4, 1e-6, 1e-8}) {
    const RunResult result = run_text(text, with_method(Method::rodas5p, relative));
    REQUIRE(result.stop == StopReason::completed);
    CAPTURE(relative, result.report.steps);
    CHECK(largest_difference(exact, result) < 100.0 * relative);  // tolerances, of some thirty stretches
    CHECK(result.report.steps < 1500);
  }
}

TEST_CASE("Rodas5P takes large systems with sparse matrices to the same solution as small ones with dense") {
  const auto chain = [](int cells) {
    std::vector<FedState> states;
    for (int i = 0; i < cells; ++i) {
      const auto cell = [](int k) { return "x" + std::to_string(k) + ".q"; };
      const std::string left = i > 0 ? cell(i - 1) : "sin(1e3*t)", right = i + 1 < cells ? cell(i + 1) : "0";
      states.push_back({"x" + std::to_string(i), "0", "1e4*(" + left + " - 2*" + cell(i) + " + " + right + ")"});
    }
    return states;
  };
  const std::string scene = R"("stop": 0.002, "samples": 11)";
  for (const auto& [cells, form] : {std::pair(6, "dense"), std::pair(40, "dense"), std::pair(120, "sparse")}) {
    CAPTURE(cells);
    const RunResult result = rodas_run(chain(cells), scene, 1e-7);
    CHECK(result.report.method == std::string("Rodas5P of order 5, ") + form);
    const RunResult bdf = run_text(fed_states(chain(cells), scene), with_method(Method::bdf, 1e-10));
    // a hundred tolerances; the far cells are still small, and are held to their own scale
    for (int i = 0; i < 3; ++i)
      CHECK(largest_difference(bdf.trace.columns[static_cast<std::size_t>(i)],
                               result.trace.columns[static_cast<std::size_t>(i)]) < 1e-5);
  }
}
