// Rodas5P: its formula, its order, published solutions of stiff problems, inputs of time, events, loops, dense output.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
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

TEST_CASE("Rodas5P is of order 5 with inputs of time, and of order 4 at least where one is stiff") {
  struct Problem {
    std::string name;
    std::vector<FedState> states;
    std::vector<std::function<double(double)>> exact;
    double order;  ///< held, of what is recorded within the steps
    double tight;  ///< reached at 1e-11
  };
  const auto growth = [](double t) { return 0.2 / (0.2 + 0.8 * std::exp(-t)); };
  const auto wave = [](double t) { return std::sin(t); };
  const std::vector<Problem> problems = {
      {"rotation",
       {{"x", "1", "y.q"}, {"y", "0", "-x.q"}},
       {[](double t) { return std::cos(t); }, [](double t) { return -std::sin(t); }},
       5.0,
       1e-10},
      {"logistic growth", {{"x", "0.2", "x.q*(1 - x.q)"}}, {growth}, 5.0, 1e-10},
      {"source of time", {{"x", "0", "cos(3*t)"}}, {[](double t) { return std::sin(3.0 * t) / 3.0; }}, 5.0, 1e-10},
      {"time times state",
       {{"x", "1", "-t*x.q*x.q"}},
       {[](double t) { return 1.0 / (1.0 + t * t / 2.0); }},
       5.0,
       1e-10},
      // Prothero and Robinson, from a moderate stiffness to one far beyond the steps. A method of a low stage order
      // comes down to that; this one is made not to.
      {"Prothero-Robinson, 1e2", {{"x", "0", "-1e2*(x.q - sin(t)) + cos(t)"}}, {wave}, 4.0, 1e-10},
      {"Prothero-Robinson, 1e3", {{"x", "0", "-1e3*(x.q - sin(t)) + cos(t)"}}, {wave}, 4.0, 1e-10},
      {"Prothero-Robinson, 1e6", {{"x", "0", "-1e6*(x.q - sin(t)) + cos(t)"}}, {wave}, 4.0, 1e-10}};
  for (const Problem& problem : problems) {
    std::vector<double> errors, steps;
    for (const double relative : {1e-5, 1e-8, 1e-11}) {
      const RunResult result = rodas_run(problem.states, R"("stop": 5, "samples": 201)", relative);
      double worst = 0.0;
      for (std::size_t k = 0; k < problem.exact.size(); ++k)
        for (std::size_t i = 0; i < result.trace.times.size(); ++i)
          worst = std::max(worst, std::abs(result.trace.columns[k][i] - problem.exact[k](result.trace.times[i])));
      errors.push_back(worst);
      steps.push_back(static_cast<double>(result.report.steps));
    }
    INFO(problem.name << ": errors " << errors[0] << ", " << errors[1] << ", " << errors[2] << "; steps " << steps[0]
                      << ", " << steps[1] << ", " << steps[2]);
    const double order = std::log(errors[0] / errors[2]) / std::log(steps[2] / steps[0]);
    // The steps are not of one length: some tenths of an order.
    CHECK(order > problem.order - 0.5);
    CHECK(errors[2] < problem.tight);
  }
  // Where the mode is beyond all steps, the solution is followed to the tolerance with steps of its own time scale.
  const RunResult stiff = rodas_run({{"x", "0", "-1e9*(x.q - sin(t)) + cos(t)"}}, R"("stop": 5, "samples": 51)", 1e-8);
  CHECK(stiff.report.steps < 150);
  for (std::size_t i = 0; i < stiff.trace.times.size(); ++i)
    CHECK(stiff.trace.columns[0][i] == Approx(std::sin(stiff.trace.times[i])).margin(1e-7));
}

// The same published solutions as in radau_test.cpp, which says where they are from.
TEST_CASE("Rodas5P reaches the published solutions of four stiff problems") {
  struct Published {
    std::string name;
    std::vector<FedState> states;
    std::string stop;
    std::vector<double> solution;
    std::uint64_t most_steps;  ///< at 1e-8
  };
  const std::vector<Published> problems = {
      {"van der Pol, 1e-6",
       {{"x", "2", "y.q"}, {"y", "0", "((1 - x.q^2)*y.q - x.q)/1e-6"}},
       "2",
       {0.1706167732170483e1, -0.8928097010247975e0},
       3000},
      {"Robertson",
       {{"x", "1", "-0.04*x.q + 1e4*y.q*z.q"},
        {"y", "0", "0.04*x.q - 1e4*y.q*z.q - 3e7*y.q^2"},
        {"z", "0", "3e7*y.q^2"}},
       "1e11",
       {0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050},
       3000},
      {"HIRES",
       {{"y1", "1", "-1.71*y1.q + 0.43*y2.q + 8.32*y3.q + 0.0007"},
        {"y2", "0", "1.71*y1.q - 8.75*y2.q"},
        {"y3", "0", "-10.03*y3.q + 0.43*y4.q + 0.035*y5.q"},
        {"y4", "0", "8.32*y2.q + 1.71*y3.q - 1.12*y4.q"},
        {"y5", "0", "-1.745*y5.q + 0.43*y6.q + 0.43*y7.q"},
        {"y6", "0", "-280*y6.q*y8.q + 0.69*y4.q + 1.71*y5.q - 0.43*y6.q + 0.69*y7.q"},
        {"y7", "0", "280*y6.q*y8.q - 1.81*y7.q"},
        {"y8", "0.0057", "-280*y6.q*y8.q + 1.81*y7.q"}},
       "321.8122",
       {0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4, 0.1175651343283149e-2,
        0.2386356198831331e-2, 0.6238968252742796e-2, 0.2849998395185769e-2, 0.2850001604814231e-2},
       800},
      {"Oregonator",
       {{"x", "1", "77.27*(y.q + x.q*(1 - 8.375e-6*x.q - y.q))"},
        {"y", "2", "(z.q - (1 + x.q)*y.q)/77.27"},
        {"z", "3", "0.161*(x.q - z.q)"}},
       "360",
       {0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3},
       3000}};
  for (const Published& problem : problems) {
    const RunResult result = rodas_run(problem.states, "\"stop\": " + problem.stop + ", \"samples\": 2", 1e-8);
    CAPTURE(problem.name, result.report.steps);
    CHECK(result.report.steps < problem.most_steps);
    // What errors of steps add up to: a thousand tolerances (Robertson over eleven decades of time; the others a
    // hundred).
    for (std::size_t k = 0; k < problem.solution.size(); ++k)
      CHECK(result.trace.columns[k].back() == Approx(problem.solution[k]).epsilon(1e-5));
  }
}

TEST_CASE("Rodas5P's dense output is as good within the steps as the tolerance, whoever looks") {
  // stiff beside smooth: x follows sin(t), y is known in closed form
  const std::vector<FedState> states = {{"x", "0", "-1e6*(x.q - sin(t)) + cos(t)"}, {"y", "0", "cos(3*t)"}};
  for (const double relative : {1e-4, 1e-6, 1e-8}) {
    const RunResult few = rodas_run(states, R"("stop": 10, "samples": 2)", relative);
    const RunResult many = rodas_run(states, R"("stop": 10, "samples": 5001)", relative);
    CHECK(few.report.steps == many.report.steps);
    CHECK(few.trace.columns[0].back() == many.trace.columns[0].back());
    double worst = 0.0;
    for (std::size_t i = 0; i < many.trace.times.size(); ++i) {
      const double t = many.trace.times[i];
      worst = std::max({worst, std::abs(many.trace.columns[0][i] - std::sin(t)),
                        std::abs(many.trace.columns[1][i] - std::sin(3.0 * t) / 3.0)});
    }
    INFO(relative << ": " << worst);
    CHECK(worst < 10.0 * relative);  // what a step's estimated error may be
  }
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

TEST_CASE("Rodas5P takes the slopes by time from the expressions, through loops and tables, and allocates none anew") {
  const CompiledModel compiled = compile_text(R"json({ "bgsim": 1, "name": "timed",
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
  REQUIRE(!compiled.program.blocks.empty());
  Evaluator evaluator(compiled.program, compiled.inputs.parameters);
  CHECK(evaluator.names_time());
  Branch branch = first_branch(compiled.program);
  const std::vector<double> x{0.3, 0.2};
  std::vector<double> slopes(2), before(2), after(2);
  for (const double t : {0.0, 0.4, 1.3}) {
    REQUIRE(evaluator.initialize_modes(t, x.data(), branch));
    REQUIRE(evaluator.time_slopes(t, x.data(), branch, slopes.data()));
    constexpr double kMove = 1e-5;
    REQUIRE(evaluator.rates(t - kMove, x.data(), branch, before.data()));
    REQUIRE(evaluator.rates(t + kMove, x.data(), branch, after.data()));
    // A central difference is wrong by its move's square times a third slope of some tens.
    for (std::size_t i = 0; i < 2; ++i) CHECK(slopes[i] == Approx((after[i] - before[i]) / (2.0 * kMove)).margin(1e-8));
  }
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

TEST_CASE("Rodas5P steps over stretches of some tens of roundings of the time") {
  CompiledModel compiled = compile_file("models/rlc.json", with_method(Method::rodas5p));
  for (const int roundings : {1, 2, 3, 4, 5, 6, 8, 12, 16, 27, 40, 60, 100, 200, 1000}) {
    INFO(roundings);
    compiled.inputs.start = 4.0;
    compiled.inputs.stop = 4.0 + roundings * std::numeric_limits<double>::epsilon() * 4.0;
    compiled.inputs.output_times = {compiled.inputs.start, compiled.inputs.stop};
    const RunResult result = compiled.run();
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.reached == compiled.inputs.stop);
    CHECK(result.report.steps < 20);
  }
}

TEST_CASE("Rodas5P sees when friction that is smoothed to the width of its tolerance breaks loose") {
  const std::string text = R"x({"bgsim": 1, "name": "friction", "elements": {"j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1}, "k": {"kind": "C", "capacitance": "1/2.33747"},
      "f": {"kind": "R", "law": "e = 0.706714*tanh(f/1e-6)"}, "s": {"kind": "Se", "effort": "2.06695*sin(0.588204*t)"}},
    "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "m"}, {"from": "j", "to": "k"}, {"from": "j", "to": "f"}],
    "outputs": {"v": "m.f", "x": "k.q"}, "scenes": {"s": {"stop": 9.94569, "samples": 81}}})x";
  const RunResult exact = run_text(text, with_method(Method::radau, 1e-9));
  const RunResult run = run_text(text, with_method(Method::rodas5p, 1e-6));
  for (const char* output : {"v", "x"}) {
    INFO(output);
    const std::vector<double> right = column(exact, output);
    // as radau_test.cpp asks of Radau IIA: two hundred tolerances, since x is known to one where it sticks
    CHECK(largest_difference(right, column(run, output)) < 2e-4 * 1.6);
  }
}
