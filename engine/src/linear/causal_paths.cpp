// The signal-flow graph of a model's equations: its paths from the input to the output, and its loops.
#include <algorithm>
#include <limits>

#include "bgsim/transfer.hpp"
#include "linear/symbolic_system.hpp"

namespace bgsim {

namespace {

using Node = SignalFlow::Node;
using Flow = SignalFlow;

/// Depth first through nodes that lead on, each node once.
class Walk {
 public:
  Walk(const Flow& flow, const SymbolicSystem& symbolic, std::size_t most)
      : flow_(flow), symbolic_(symbolic), most_(most), on_path_(flow.out.size(), 0) {}

  /// @param from  the first node; all later ones are above it unless it is the input
  /// @return false if there are more than wanted
  bool go(Node from, Node goal, bool loop, std::vector<CausalPath>& found) {
    leads_ = leading_to(goal, loop ? from : 0);
    struct Step {
      Node node;
      std::size_t next;
    };
    std::vector<Step> path{{from, 0}};
    on_path_[from] = 1;
    bool all = true;
    while (!path.empty()) {
      Step& top = path.back();
      const auto& edges = flow_.out[top.node];
      if (top.next == edges.size() || !all) {
        on_path_[top.node] = 0;
        path.pop_back();
        continue;
      }
      const Flow::Edge& edge = flow_.edges[edges[top.next++]];
      if (edge.to == goal) {
        gains_.resize(path.size() - 1);
        gains_.push_back(&edge.gain);
        std::vector<Node> nodes;
        for (const Step& step : path) nodes.push_back(step.node);
        if (!loop) nodes.push_back(goal);
        if (found.size() == most_)
          all = false;
        else
          found.push_back(made(nodes));
        continue;
      }
      if (++steps_ > kMostSteps) all = false;
      if (!all || on_path_[edge.to] != 0 || leads_[edge.to] == 0) continue;
      gains_.resize(path.size() - 1);
      gains_.push_back(&edge.gain);
      on_path_[edge.to] = 1;
      path.push_back({edge.to, 0});
    }
    return all;
  }
  [[nodiscard]] const std::vector<PowerSum>& gains() const { return used_; }

 private:
  static constexpr std::size_t kMostSteps = 5'000'000;

  /// Nodes from @p least on from which @p goal can be reached through such nodes.
  [[nodiscard]] std::vector<char> leading_to(Node goal, Node least) const {
    std::vector<std::vector<Node>> back(flow_.out.size());
    for (const Flow::Edge& edge : flow_.edges)
      if (edge.from >= least && edge.to >= least) back[edge.to].push_back(edge.from);
    std::vector<char> leads(flow_.out.size(), 0);
    std::vector<Node> open{goal};
    while (!open.empty()) {
      const Node node = open.back();
      open.pop_back();
      for (const Node before : back[node])
        if (leads[before] == 0) {
          leads[before] = 1;
          open.push_back(before);
        }
    }
    return leads;
  }

  CausalPath made(const std::vector<Node>& nodes) {
    PowerSum gain{{Powers{}, 1}};
    for (const PowerSum* factor : gains_) gain = product(gain, *factor);
    CausalPath path;
    path.gain = symbolic_.ring->text(gain, symbolic_.names());
    std::map<int, PowerSum> by_power;
    for (const auto& [powers, coefficient] : gain) {
      const bool laplace = !powers.empty() && powers.front().first == kLaplace;
      Powers rest(powers.begin() + (laplace ? 1 : 0), powers.end());
      by_power[laplace ? powers.front().second : 0].emplace(std::move(rest), coefficient);
    }
    for (const auto& [power, part] : by_power) path.values.emplace_back(power, symbolic_.ring->value(part));
    path.nodes = nodes;
    for (const Node node : nodes) {
      const std::string& element = flow_.element_of[node];
      if (!element.empty() && (path.elements.empty() || path.elements.back() != element))
        path.elements.push_back(element);
    }
    if (path.elements.size() > 1 && path.elements.front() == path.elements.back()) path.elements.pop_back();
    used_.push_back(std::move(gain));
    return path;
  }

  const Flow& flow_;
  const SymbolicSystem& symbolic_;
  std::size_t most_, steps_ = 0;
  std::vector<char> on_path_, leads_;
  std::vector<const PowerSum*> gains_;
  std::vector<PowerSum> used_;
};

}  // namespace

std::complex<double> CausalPath::at(std::complex<double> s) const {
  std::complex<double> value = 0.0;
  for (const auto& [power, coefficient] : values) value += coefficient * std::pow(s, power);
  return value;
}

CausalPaths causal_paths(const std::shared_ptr<const Model>& model, const RunInputs& point, const std::string& input,
                         std::size_t most) {
  linear_system(model, point, {input});  // kinks and the like are refused
  const std::unique_ptr<SymbolicSystem> symbolic = symbolic_system(model, point, input);
  CausalPaths result;
  std::vector<PowerSum> used;
  try {
    const Flow flow = signal_flow(*symbolic);
    Walk walk(flow, *symbolic, most);
    result.all = walk.go(flow.input, flow.output, false, result.paths);
    for (Node node = 0; node < flow.out.size() && result.all; ++node)
      if (!flow.out[node].empty()) result.all = walk.go(node, node, true, result.loops);
    used = walk.gains();
  } catch (const TooManyTerms&) {
    result.all = false;
  }
  result.values = symbolic->values_in(used);
  return result;
}

}  // namespace bgsim
