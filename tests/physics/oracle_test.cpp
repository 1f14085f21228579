// The engine against the tableau of the same graph, which knows nothing of causality, over random linear graphs.

#include <catch2/catch.hpp>

#include "graph/junction_rank.hpp"
#include "support/algebra.hpp"
#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"
#include "support/tableau.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd matrix(const std::vector<double>& row_major, std::size_t rows, std::size_t columns) {
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      row_major.data(), static_cast<Index>(rows), static_cast<Index>(columns));
}

/// The engine's view of a linear model: x' = a x + b u, outputs c x + d u (e, f, and q or p of every store).
struct EngineMotion {
  MatrixXd a, b, c, d;

  explicit EngineMotion(const CompiledModel& p) {
    std::vector<std::string> sources;
    for (const Parameter& parameter : p.model().parameters) sources.push_back(parameter.name);
    const std::vector<double> zero(p.system().states.size());
    const Linearization l = linear_at(p.study, p.inputs, 0.0, zero, sources);
    a = matrix(l.a, l.states, l.states);
    b = matrix(l.b, l.states, l.inputs);
    c = matrix(l.c, l.outputs, l.states);
    d = matrix(l.d, l.outputs, l.inputs);
  }

  [[nodiscard]] VectorXd outputs_at(double time, const VectorXd& start, const VectorXd& u) const {
    const Index n = a.rows();
    MatrixXd extended = MatrixXd::Zero(n + 1, n + 1);
    extended.topLeftCorner(n, n) = a * time;
    if (u.size() > 0) extended.topRightCorner(n, 1) = b * u * time;
    VectorXd x(n + 1);
    x << start, 1.0;
    x = (exponential(extended) * x).eval();
    return c * x.head(n) + d * u;
  }
};

/// e, f, and q or p of every store, as the outputs of random graphs have them.
VectorXd store_outputs(const CompiledModel& p, const Tableau& tableau, const Motion& motion, const VectorXd& x,
                       const VectorXd& u) {
  VectorXd bonds = motion.bonds_x * x;
  if (u.size() > 0) bonds += motion.bonds_u * u;
  const auto count = static_cast<Index>(p.study.graph().bonds.size());
  VectorXd outputs(3 * x.size());
  for (Index i = 0; i < x.size(); ++i) {
    const Port& port = p.study.graph()[tableau.stores[static_cast<std::size_t>(i)]];
    const auto bond = static_cast<Index>(port.bond.index());
    outputs(3 * i) = bonds(bond);
    outputs(3 * i + 1) = bonds(count + bond) * (port.head ? 1.0 : -1.0);
    outputs(3 * i + 2) = x(i);
  }
  return outputs;
}

/// The values of all sources, which are all parameters there are.
VectorXd inputs_of(const CompiledModel& p) {
  return Eigen::Map<const VectorXd>(p.inputs.parameters.data(), static_cast<Index>(p.inputs.parameters.size()));
}

VectorXd stored_of(const VectorXd& outputs) {
  VectorXd x(outputs.size() / 3);
  for (Index i = 0; i < x.size(); ++i) x(i) = outputs(3 * i + 2);
  return x;
}

double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

/// Largest distance between the two sets of poles, each pole of one matched with the nearest unused one of the other.
double pole_distance(Eigen::VectorXcd one, const Eigen::VectorXcd& two) {
  double distance = 0.0;
  Index left = one.size();
  for (Index i = 0; i < two.size(); ++i) {
    Index nearest = 0;
    for (Index k = 1; k < left; ++k)
      if (std::abs(one(k) - two(i)) < std::abs(one(nearest) - two(i))) nearest = k;
    distance = std::max(distance, std::abs(one(nearest) - two(i)));
    std::swap(one(nearest), one(--left));
  }
  return distance;
}

struct Tally {
  std::size_t compared = 0, with_dependent = 0, with_loops = 0;
  std::size_t refused = 0;   // no strokes keep all rules; the tableau is singular
  std::size_t singular = 0;  // strokes do, but the tableau is singular for these coefficients, and the engine says so
  std::size_t declined = 0;  // the tableau is regular, and the engine refuses it all the same
  std::size_t circulating = 0;  // something runs round a ring and takes part in nothing
  std::size_t by_rank = 0;      // the strokes are not right, and the rank of the ring's equations decides
};

void compare_poles(const EngineMotion& engine, const Motion& motion) {
  const Eigen::VectorXcd theirs = motion.poles();
  REQUIRE(engine.a.rows() == theirs.size());
  if (theirs.size() == 0) return;
  const Eigen::VectorXcd ours = eigenvalues(engine.a);
  // The two matrices differ by rounding, some 1e-14; 1e-8 leaves room for pairs of poles that nearly coincide.
  REQUIRE(pole_distance(ours, theirs) <= 1e-8 * std::max(theirs.cwiseAbs().maxCoeff(), 1e-3));
}

void compare_response(const CompiledModel& p, const EngineMotion& engine, const Tableau& tableau,
                      const Motion& motion) {
  VectorXd start(engine.a.rows());
  for (Index i = 0; i < start.size(); ++i) start(i) = std::cos(1.0 + 2.0 * static_cast<double>(i));
  const VectorXd u = inputs_of(p);
  const VectorXd x0 = stored_of(engine.outputs_at(0.0, start, u));
  VectorXd off = motion.constraint_x * x0;
  if (u.size() > 0) off += motion.constraint_u * u;
  REQUIRE(largest(off) <= 1e-9 * std::max(1.0, largest(x0)));
  for (const double time : {0.0, 0.1, 0.7, 2.0}) {
    const VectorXd ours = engine.outputs_at(time, start, u);
    const VectorXd theirs = store_outputs(p, tableau, motion, motion.at(time, x0, u), u);
    INFO("time " << time);
    REQUIRE(largest(ours - theirs) <= 1e-8 * std::max(1.0, largest(theirs)));
  }
}

/// The engine's motion, or none if it refuses the model for its numbers (BG403, BG411).
std::optional<EngineMotion> engine_motion(const std::shared_ptr<const Model>& model) {
  try {
    return EngineMotion(compile_model(model));
  } catch (const ModelError& error) {
    const std::string& code = error.diagnostics.front().code;
    INFO(error.what());
    REQUIRE((code == "BG403" || code == "BG411"));
    return std::nullopt;
  }
}

void compare(const RandomGraph& random, Tally& tally) {
  auto model = std::make_shared<const Model>(read_model_text("random.json", random.json()));
  const RunInputs inputs = prepare_scene(*model, "");
  const Study study(model);
  const BondGraph& graph = study.graph();
  const Tableau tableau = form_tableau(*model, graph, inputs.parameters);
  Motion motion = motion_of(tableau);
  const bool determined = motion.regular;
  if (!determined) {
    motion = motion_without_circulation(tableau);
    if (motion.regular) ++tally.circulating;
  }
  try {
    static_cast<void>(study.causality());
  } catch (const ModelError& error) {
    // What is refused has no solution, or more than one. In a tree that includes junctions at a dead end, whose effort
    // or flow nothing determines; in a ring only what is asked for must be determined.
    INFO(error.what());
    REQUIRE_FALSE(determined);
    REQUIRE((!motion.regular || ring_parts(graph).empty()));
    ++tally.refused;
    return;
  }
  const std::optional<EngineMotion> engine = engine_motion(model);
  if (!motion.regular) {
    // These coefficients of stores and resistors make the system singular. The engine has to say so if anything is
    // asked of it.
    REQUIRE((!engine || model->outputs.empty()));
    ++tally.singular;
    return;
  }
  REQUIRE(motion.index_two);
  if (!engine) {
    ++tally.declined;
    return;
  }
  const CompiledModel p = compile_model(model);
  compare_poles(*engine, motion);
  compare_response(p, *engine, tableau, motion);
  ++tally.compared;
  if (!p.study.causality().dependent.empty()) ++tally.with_dependent;
  if (!p.study.order().blocks.empty()) ++tally.with_loops;
  if (!p.study.causality().ranked.empty()) ++tally.by_rank;
}

/// Of how many graphs something must be true; small samples vary, so that a share of them must have half as many.
std::uint64_t at_least(std::uint64_t count) {
  const std::uint64_t share = share_of(count);
  return share == count ? count : share / 2;
}

/// @param count  of graphs, or the share of it that is asked for.
Tally compare_many(std::uint64_t first, std::uint64_t count, const RandomGraphOptions& options) {
  Tally tally;
  const std::uint64_t last = first + share_of(count) - 1;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const RandomGraph random = random_graph(seed, options);
    INFO("seed " << seed << "\n" << random.json());
    compare(random, tally);
  }
  INFO("refused " << tally.refused << ", singular " << tally.singular << ", declined " << tally.declined);
  CHECK(tally.compared + tally.refused + tally.singular + tally.declined == last - first + 1);
  return tally;
}

}  // namespace

TEST_CASE("Poles and responses of random trees of junctions are those of the tableau") {
  RandomGraphOptions options;
  options.most_rings = 0;
  options.most_junctions = 5;
  options.sources = 0.1;
  const Tally tally = compare_many(1, 1000, options);
  CHECK(tally.compared > at_least(900));
  CHECK(tally.with_dependent > at_least(400));
  CHECK(tally.with_loops > at_least(300));
  // In a tree strokes say all there is to say.
  CHECK(tally.singular == 0);
  CHECK(tally.declined == 0);
}

TEST_CASE("Poles and responses of random graphs with rings are those of the tableau") {
  RandomGraphOptions options;
  options.most_rings = 2;
  options.most_junctions = 5;
  options.sources = 0.08;
  const Tally tally = compare_many(5001, 1000, options);
  CHECK(tally.compared > at_least(750));
  CHECK(tally.with_dependent > at_least(400));
  CHECK(tally.with_loops > at_least(400));
  // Where power runs round a ring and the terms cancel whatever the moduli (two bonds side by side, two gyrators in
  // opposite senses), strokes would choose states that are not free, or a store whose rate seems to depend on itself.
  CHECK(tally.by_rank > at_least(20));
  CHECK(tally.declined == 0);
}

TEST_CASE("Rings of TF and GY whose moduli often cancel are solved, or refused where the tableau is singular") {
  RandomGraphOptions options;
  options.most_rings = 3;
  options.most_junctions = 5;
  options.sources = 0.1;
  options.two_ports = 0.75;
  options.simple_moduli = true;
  const Tally tally = compare_many(30001, 600, options);
  CHECK(tally.compared > at_least(400));
  CHECK(tally.by_rank > at_least(50));
  CHECK(tally.circulating > at_least(10));
  CHECK(tally.declined == 0);
}

TEST_CASE("Graphs full of sources are refused only where the tableau is singular") {
  RandomGraphOptions options;
  options.most_rings = 1;
  options.most_junctions = 4;
  options.sources = 0.5;
  const Tally tally = compare_many(9001, 500, options);
  CHECK(tally.refused > at_least(150));
  CHECK(tally.compared > at_least(250));
  CHECK(tally.declined == 0);
}

TEST_CASE("Poles and responses of random graphs with mixed fields are those of the tableau") {
  RandomGraphOptions options;
  options.most_rings = 1;
  options.most_junctions = 5;
  options.sources = 0.1;
  options.mixed_fields = 0.3;
  const Tally tally = compare_many(40001, 800, options);
  CHECK(tally.compared > at_least(600));
  CHECK(tally.with_dependent > at_least(300));
  CHECK(tally.with_loops > at_least(200));
  CHECK(tally.declined == 0);
}

TEST_CASE("Runs of random graphs follow the tableau's exponential") {
  RandomGraphOptions options;
  options.most_rings = 1;
  options.most_junctions = 4;
  options.sources = 0.25;
  SceneOverrides tight;
  tight.relative = 1e-11;
  tight.absolute = 1e-13;
  std::size_t compared = 0;
  for (std::uint64_t seed = 20001; seed <= 20060; ++seed) {
    auto model = std::make_shared<const Model>(read_model_text("random.json", random_graph(seed, options).json()));
    if (model->outputs.empty()) continue;
    const Motion motion = [&] {
      return motion_of(form_tableau(*model, Study(model).graph(), prepare_scene(*model, "").parameters));
    }();
    if (!motion.regular || !engine_motion(model)) continue;
    INFO("seed " << seed);
    const CompiledModel p = compile_model(model, tight);
    const Tableau tableau = form_tableau(*model, p.study.graph(), p.inputs.parameters);
    const RunResult result = p.run();
    REQUIRE(result.stop == StopReason::completed);
    const auto row = [&](std::size_t i) {
      VectorXd values(static_cast<Index>(result.trace.columns.size()));
      for (Index c = 0; c < values.size(); ++c) values[c] = result.trace.columns[static_cast<std::size_t>(c)][i];
      return values;
    };
    const VectorXd u = inputs_of(p);
    double scale = 1.0;
    for (std::size_t i = 0; i < result.trace.times.size(); ++i) scale = std::max(scale, largest(row(i)));
    for (std::size_t i = 0; i < result.trace.times.size(); ++i) {
      const VectorXd x = motion.at(result.trace.times[i], stored_of(row(0)), u);
      // A few hundred steps, each within 1e-11 of the largest.
      REQUIRE(largest(row(i) - store_outputs(p, tableau, motion, x, u)) <= 1e-8 * scale);
    }
    ++compared;
  }
  CHECK(compared > 30);
}
