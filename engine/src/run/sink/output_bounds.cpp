#include "run/sink/output_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "expression/graph.hpp"
#include "run/watch/sharp_laws.hpp"

namespace bgsim {
namespace {

/// Of a state at points of a stretch. Between two points it leaves the line through them, and its slope theirs, by less
/// than what the slopes of neighbouring lines differ by.
Jet jet_of(double from, double to, std::span<const double> times, const std::vector<std::vector<double>>& states,
           std::size_t state) {
  const auto at = [&](std::size_t k) { return states[k][state]; };
  const auto slope = [&](std::size_t k) { return (at(k + 1) - at(k)) / (times[k + 1] - times[k]); };
  const std::size_t lines = times.size() - 1;
  double least = at(0), most = at(0), slowest = slope(0), fastest = slope(0), turns = 0.0, longest = 0.0;
  for (std::size_t k = 0; k < lines; ++k) {
    least = std::min(least, at(k + 1));
    most = std::max(most, at(k + 1));
    slowest = std::min(slowest, slope(k));
    fastest = std::max(fastest, slope(k));
    longest = std::max(longest, times[k + 1] - times[k]);
    if (k > 0) turns = std::max(turns, std::abs(slope(k) - slope(k - 1)));
  }
  const auto next = static_cast<std::size_t>(
      std::lower_bound(times.begin() + 1, times.end() - 1, from + 0.5 * (to - from)) - times.begin());
  Jet jet;
  jet.middle_slope = slope(next - 1);
  jet.middle = at(next - 1) + (from + 0.5 * (to - from) - times[next - 1]) * jet.middle_slope;
  jet.slope = Range(slowest - turns, fastest + turns);
  jet.value = Range(least - turns * longest, most + turns * longest);
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

void OutputBounds::keep(const std::vector<double>& x, std::vector<double>& kept) const {
  kept.clear();
  for (const std::uint32_t state : bounds_->states()) kept.push_back(x[state]);
}

bool OutputBounds::enclose(double from, double to, std::span<const double> times,
                           const std::vector<std::vector<double>>& states) {
  jets_.clear();
  for (std::size_t i = 0; i < bounds_->states().size(); ++i) jets_.push_back(jet_of(from, to, times, states, i));
  bounds_->evaluate(from, to, jets_, {});
  for (std::size_t i = 0; i < operators_; ++i)
    if (bounds_->bends(i)) return true;
  return false;
}

}  // namespace bgsim
