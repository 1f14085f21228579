#include "run/sink/output_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "expression/graph.hpp"
#include "run/watch/sharp_laws.hpp"

namespace bgsim {
namespace {

/// Of a state at points of a stretch: what lies between them leaves what they span by less than that.
Jet jet_of(double from, double to, std::span<const double> times, const std::vector<std::vector<double>>& states,
           std::size_t state) {
  const auto at = [&](std::size_t k) { return states[k][state]; };
  const auto slope = [&](std::size_t k) { return (at(k + 1) - at(k)) / (times[k + 1] - times[k]); };
  double least = at(0), most = at(0), slowest = slope(0), fastest = slope(0);
  for (std::size_t k = 0; k < times.size(); ++k) {
    least = std::min(least, at(k));
    most = std::max(most, at(k));
    if (k + 1 == times.size()) break;
    slowest = std::min(slowest, slope(k));
    fastest = std::max(fastest, slope(k));
  }
  const std::size_t next = static_cast<std::size_t>(
      std::lower_bound(times.begin() + 1, times.end() - 1, from + 0.5 * (to - from)) - times.begin());
  Jet jet;
  jet.middle_slope = slope(next - 1);
  jet.middle = at(next - 1) + (from + 0.5 * (to - from) - times[next - 1]) * jet.middle_slope;
  const double spread = fastest - slowest, moved = most - least;
  jet.slope = Range(slowest - spread, fastest + spread);
  jet.value = Range(least - moved, most + moved);
  return jet;
}

}  // namespace

OutputBounds::OutputBounds(const Program& program, std::span<const double> parameters) {
  const ExprPool& pool = program.pool;
  std::vector<ExprId> roots;
  for (const std::uint32_t slot : program.outputs.results) roots.push_back(program.slot_expression[slot]);
  const std::vector<ExprId> nodes = reachable(pool, roots);
  const IdMap<std::uint32_t> position = positions(nodes);
  const VaryingSymbols varying = varying_symbols(program);
  const auto depend = [&](const std::vector<char>& on) {
    return depends_on(pool, nodes, position, [&](SymbolId symbol) { return on[symbol.index()] != 0; });
  };
  const std::vector<char> moves = depend(varying.any), of_loops = depend(varying.tears);
  std::vector<char> sharp(nodes.size(), 0);
  std::vector<ExprId> watched;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    for_each_argument(node, [&](ExprId a) { sharp[i] |= sharp[*position.find(a)]; });
    if (moves[i] == 0 || of_loops[i] != 0 || arity(node.op) == 0 || !may_be_sharp(pool, node)) continue;
    if (node.op == Op::div && moves[*position.find(ExprId(node.b))] == 0) continue;
    sharp[i] = 1;
    watched.push_back(nodes[i]);
  }
  operators_ = watched.size();
  for (std::uint32_t i = 0; i < roots.size(); ++i) {
    const std::uint32_t root = *position.find(roots[i]);
    if (sharp[root] == 0 || of_loops[root] != 0) continue;
    outputs_.push_back(i);
    watched.push_back(roots[i]);
  }
  if (any()) bounds_.emplace(program, parameters, watched);
}

void OutputBounds::set_modes(std::span<const double> modes) { bounds_->set_modes(modes); }

bool OutputBounds::enclose(double from, double to, std::span<const double> times,
                           const std::vector<std::vector<double>>& states) {
  jets_.clear();
  for (const std::uint32_t state : bounds_->states()) jets_.push_back(jet_of(from, to, times, states, state));
  bounds_->evaluate(from, to, jets_, {});
  for (std::size_t i = 0; i < operators_; ++i)
    if (bounds_->bends(i)) return true;
  return false;
}

}  // namespace bgsim
