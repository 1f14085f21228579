#include "linear/pencil.hpp"

#include <unordered_map>
#include <utility>

namespace bgsim {

namespace {

class PencilBuilder {
 public:
  PencilBuilder(const SignalFlow& flow, const SymbolicSystem& symbolic) : flow_(flow) {
    for (const std::uint32_t s : symbolic.states) add_variable(symbolic.system.states[s].symbol.value);
    pencil_.states = pencil_.nodes.size();
    find_cuts();
    for (std::size_t v = 0; v < pencil_.nodes.size(); ++v) {
      Sum sum = sum_into(pencil_.nodes[v]);
      if (v < pencil_.states) {  // the edges into states have 1/s
        for (auto& [column, value] : sum.row) value = shifted(value, kLaplace, 1);
        sum.input = shifted(sum.input, kLaplace, 1);
      }
      pencil_.rows.push_back(std::move(sum.row));
      pencil_.input.push_back(std::move(sum.input));
    }
    Sum output = sum_into(flow.output);
    pencil_.output = std::move(output.row);
    pencil_.direct = std::move(output.input);
  }
  Pencil result() { return std::move(pencil_); }

 private:
  struct Sum {
    SparseRow row;
    PowerSum input;
  };

  void add_variable(SignalFlow::Node node) {
    column_[node] = static_cast<std::uint32_t>(pencil_.nodes.size());
    pencil_.nodes.push_back(node);
  }

  /// Depth first against the edges: where it comes back to an open node, that one is a variable.
  void find_cuts() {
    enum : char { fresh, open, done };
    std::vector<char> mark(flow_.in.size(), fresh);
    for (SignalFlow::Node root = 0; root < flow_.in.size(); ++root) {
      std::vector<std::pair<SignalFlow::Node, std::size_t>> path;
      const auto enter = [&](SignalFlow::Node node) {
        mark[node] = open;
        path.emplace_back(node, 0);
      };
      if (mark[root] == fresh) enter(root);
      while (!path.empty()) {
        auto& [node, next] = path.back();
        if (next == flow_.in[node].size()) {
          mark[node] = done;
          path.pop_back();
          continue;
        }
        const SignalFlow::Node from = flow_.edges[flow_.in[node][next++]].from;
        if (column_.contains(from)) continue;
        if (mark[from] == open) add_variable(from);
        if (mark[from] == fresh) enter(from);
      }
    }
  }

  /// What the edges into a node bring, over variables and the input.
  Sum sum_into(SignalFlow::Node goal) {
    std::vector<SignalFlow::Node> path{goal};
    const auto ready = [&](SignalFlow::Node node) {
      return node == flow_.input || column_.contains(node) || known_.contains(node);
    };
    while (true) {
      const SignalFlow::Node node = path.back();
      const std::size_t before = path.size();
      for (const std::uint32_t edge : flow_.in[node])
        if (!ready(flow_.edges[edge].from)) path.push_back(flow_.edges[edge].from);
      if (path.size() > before) continue;
      Sum sum = gathered(node);
      path.pop_back();
      if (path.empty()) return sum;
      known_.try_emplace(node, std::move(sum));
      while (path.size() > 1 && ready(path.back())) path.pop_back();
    }
  }

  Sum gathered(SignalFlow::Node node) {
    Sum sum;
    for (const std::uint32_t number : flow_.in[node]) {
      const SignalFlow::Edge& edge = flow_.edges[number];
      if (edge.from == flow_.input) {
        add_to(sum.input, edge.gain);
      } else if (const auto found = column_.find(edge.from); found != column_.end()) {
        add_to(sum.row[found->second], edge.gain);
      } else {
        const Sum& from = known_.at(edge.from);
        for (const auto& [column, value] : from.row) add_to(sum.row[column], product(value, edge.gain));
        add_to(sum.input, product(from.input, edge.gain));
      }
    }
    std::erase_if(sum.row, [](const auto& entry) { return entry.second.empty(); });
    return sum;
  }

  const SignalFlow& flow_;
  Pencil pencil_;
  std::unordered_map<SignalFlow::Node, std::uint32_t> column_;
  std::unordered_map<SignalFlow::Node, Sum> known_;
};

}  // namespace

Pencil pencil_of(const SignalFlow& flow, const SymbolicSystem& symbolic) {
  return PencilBuilder(flow, symbolic).result();
}

}  // namespace bgsim
