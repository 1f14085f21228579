#include "program/denominators.hpp"

#include "expression/graph.hpp"

namespace bgsim {

namespace {

enum Trait : char { kVaries = 1, kJumps = 2 };

bool is_jump(Op op) {
  return is_logical(op) || op == Op::sign || op == Op::step || is_rounding(op) || op == Op::mod || op == Op::select;
}

/// Whether a division belongs to an element whose coefficient alone makes its law.
bool is_structural(const Model& model, const Origin& origin) {
  if (!origin.element.valid()) return false;
  const Element& element = model.elements[origin.element.index()];
  return element.coefficient.valid() && !is_source(element.kind);
}

class DenominatorSearch {
 public:
  DenominatorSearch(const Model& model, const BlockOrder& order, const std::vector<ExprId>& roots,
                    const std::vector<bool>& varies)
      : model_(model), order_(order), nodes_(reachable(order.pool, roots)), position_(positions(nodes_)) {
    traits_.resize(nodes_.size(), 0);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const ExprNode& node = order.pool[nodes_[i]];
      if (node.op == Op::symbol) {
        traits_[i] = varies[order.pool.symbol_of(nodes_[i]).index()] ? kVaries : 0;
        continue;
      }
      for_each_argument(node, [&](ExprId a) { traits_[i] |= traits_[*position_.find(a)]; });
      if (is_jump(node.op) && (traits_[i] & kVaries) != 0) traits_[i] |= kJumps;
    }
  }

  std::vector<DenominatorFactor> run() {
    for (const ExprId e : nodes_) {
      const ExprNode& node = order_.pool[e];
      if (node.op == Op::div) split(ExprId(node.b), order_.origins[e.index()]);
      if (node.op == Op::pow && is_negative(ExprId(node.b))) split(ExprId(node.a), order_.origins[e.index()]);
    }
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool is_negative(ExprId e) const { return order_.pool.is_constant(e) && order_.pool[e].constant < 0.0; }

  /// Adds the factors of a denominator.
  void split(ExprId denominator, const Origin& where) {
    std::vector<ExprId> stack{denominator};
    while (!stack.empty()) {
      const ExprId e = stack.back();
      stack.pop_back();
      if (traits_[*position_.find(e)] != kVaries || !seen_.insert(e, 1)) continue;
      const ExprNode& node = order_.pool[e];
      switch (node.op) {
        case Op::mul:
          stack.emplace_back(node.b);
          [[fallthrough]];
        case Op::neg:
        case Op::div:
        case Op::pow:
        case Op::abs:
        case Op::cbrt:  // from here on: zero where the argument is, and only there
        case Op::sinh:
        case Op::tanh:
        case Op::asin:
        case Op::atan:
        case Op::asinh:
        case Op::atanh:
        case Op::log1p:
        case Op::expm1:
          stack.emplace_back(node.a);
          break;
        case Op::constant:  // functions without a zero, or whose zeros are touched rather than passed
        case Op::exp:
        case Op::sqrt:
        case Op::cosh:
        case Op::acos:
        case Op::acosh:
        case Op::hypot:
          break;
        default:
          if (!is_positive(e)) found_.push_back({e, where, is_structural(model_, where)});
          break;
      }
    }
  }

  /// A sum of squares and constants above zero.
  [[nodiscard]] bool is_positive(ExprId e) const {
    std::vector<ExprId> stack{e};
    while (!stack.empty()) {
      const ExprId part = stack.back();
      stack.pop_back();
      const ExprNode& node = order_.pool[part];
      if (node.op == Op::add) {
        stack.emplace_back(node.a);
        stack.emplace_back(node.b);
        continue;
      }
      const bool square = (node.op == Op::mul && node.a == node.b) ||
                          (node.op == Op::pow && order_.pool.is_constant(ExprId(node.b), 2.0)) || node.op == Op::exp ||
                          node.op == Op::cosh || node.op == Op::hypot || node.op == Op::abs || node.op == Op::sqrt;
      const bool above = node.op == Op::constant && node.constant > 0.0;
      if (!square && !above) return false;
    }
    return true;
  }

  const Model& model_;
  const BlockOrder& order_;
  std::vector<ExprId> nodes_;
  IdMap<std::uint32_t> position_;
  std::vector<char> traits_;  ///< by position
  IdMap<char> seen_;
  std::vector<DenominatorFactor> found_;
};

}  // namespace

std::vector<DenominatorFactor> denominator_factors(const Model& model, const BlockOrder& order,
                                                   const std::vector<ExprId>& roots, const std::vector<bool>& varies) {
  return DenominatorSearch(model, order, roots, varies).run();
}

}  // namespace bgsim
