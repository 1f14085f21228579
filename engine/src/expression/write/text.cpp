#include "base/text.hpp"

#include <array>
#include <charconv>
#include <stdexcept>

#include "bgsim/expression.hpp"
#include "expression/graph.hpp"
#include "expression/write/layout.hpp"

namespace bgsim {

namespace {

constexpr double kLongestTree = 100'000.0;

/// The factor with which a written product begins.
ExprId leading_factor(const ExprPool& pool, ExprId id) {
  while (pool[id].op == Op::mul || pool[id].op == Op::div) id = written_order(pool, id).left;
  return id;
}

}  // namespace

Binding binding_of(Op op) {
  switch (op) {
    case Op::logical_or:
      return Binding::either;
    case Op::logical_and:
      return Binding::both;
    case Op::logical_not:
      return Binding::negation;
    case Op::lt:
    case Op::le:
    case Op::gt:
    case Op::ge:
    case Op::eq:
    case Op::ne:
      return Binding::comparison;
    case Op::add:
    case Op::sub:
      return Binding::sum;
    case Op::mul:
    case Op::div:
      return Binding::product;
    case Op::neg:
      return Binding::minus;
    case Op::pow:
      return Binding::power;
    default:
      return Binding::atom;
  }
}

OperandOrder written_order(const ExprPool& pool, ExprId id) {
  const ExprNode& node = pool[id];
  const OperandOrder stored{ExprId(node.a), ExprId(node.b)};
  if (node.op != Op::add && node.op != Op::mul && node.op != Op::logical_and && node.op != Op::logical_or)
    return stored;
  const Binding own = binding_of(node.op);
  const bool left_alike = binding_of(pool[stored.left].op) == own;
  const bool right_alike = binding_of(pool[stored.right].op) == own;
  const bool turn = right_alike && !left_alike && !pool.is_constant(stored.left);
  return turn ? OperandOrder{stored.right, stored.left} : stored;
}

bool bare_after_minus(const ExprPool& pool, ExprId operand) {
  if (pool[operand].op != Op::mul && pool[operand].op != Op::div) return false;
  const Op first = pool[leading_factor(pool, operand)].op;
  return first != Op::constant && first != Op::neg && first != Op::sub;
}

bool bare_after_factor(const ExprPool& pool, ExprId product) {
  while (pool[product].op == Op::mul) product = written_order(pool, product).left;
  return pool[product].op != Op::div && pool[product].op != Op::constant;
}

void check_written_size(const ExprPool& pool, ExprId root) {
  IdMap<double> sizes;
  for (const ExprId id : reachable(pool, {&root, 1})) {
    double size = 1.0;
    for_each_argument(pool[id], [&](ExprId a) { size += *sizes.find(a); });
    if (size > kLongestTree)
      throw std::length_error("an expression of more than 100,000 operators and operands is too long to be written");
    sizes.insert(id, size);
  }
}

std::string ExpressionWriter::write(ExprId root, Binding least) {
  push(root, least);
  while (!rest_.empty()) {
    const Piece piece = std::move(rest_.back());
    rest_.pop_back();
    if (piece.id.valid())
      begin(piece.id, piece.least);
    else
      text_ += piece.literal;
  }
  return std::move(text_);
}

namespace {

class TextWriter : public ExpressionWriter {
 public:
  using ExpressionWriter::ExpressionWriter;

 private:
  void begin(ExprId id, Binding least) override {
    const ExprNode& node = pool_[id];
    Binding own = binding_of(node.op);
    if (node.op == Op::constant && node.constant < 0.0) own = Binding::minus;
    const bool bare = node.op == Op::neg && bare_after_minus(pool_, ExprId(node.a));
    if (bare) own = Binding::product;
    if (own < least) {
      text_ += "(";
      push(")");
    }
    switch (own) {
      case Binding::atom:
      case Binding::minus:
        if (node.op == Op::neg)
          minus(ExprId(node.a), Binding::power);
        else
          atom(id);
        return;
      case Binding::negation:
        text_ += "not ";
        push(ExprId(node.a), Binding::negation);
        return;
      default:
        if (bare)
          minus(ExprId(node.a), Binding::product);
        else
          binary(id, own);
    }
  }

  void minus(ExprId operand, Binding least) {
    text_ += "-";
    push(operand, least);
  }

  void binary(ExprId id, Binding own) {
    const Op op = pool_[id].op;
    const auto [left, right] = written_order(pool_, id);
    Binding left_least = own, right_least = stronger(own);
    if (op == Op::mul || op == Op::div) {
      right_least = Binding::power;
      if (op == Op::mul && pool_.is_constant(left) && pool_[right].op == Op::mul && bare_after_factor(pool_, right))
        right_least = Binding::product;
    } else if (op == Op::pow) {
      left_least = Binding::atom;
      right_least = Binding::minus;
    } else if (own == Binding::comparison) {
      left_least = Binding::sum;
    }
    const bool tight = own >= Binding::product;
    const std::string sign(name_of(op));
    push(right, right_least);
    push(tight ? sign : " " + sign + " ");
    push(left, left_least);
  }

  void atom(ExprId id) {
    const ExprNode& node = pool_[id];
    if (node.op == Op::constant) {
      text_ += shortest_number(node.constant);
    } else if (node.op == Op::symbol) {
      text_ += name_(SymbolId(node.a));
    } else {
      const bool delayed = is_table(node.op) && pool_.table(TableId(node.b)).delayed;
      if (is_table(node.op) && pool_.table(TableId(node.b)).inverse) text_ += "inverse_";
      const std::string name(name_of(node.op));
      text_ += delayed ? "delayed" + name.substr(std::string("table").size()) : name;  // delayed_slope
      text_ += "(";
      if (delayed)
        text_ += pool_.table(TableId(node.b)).column + ", ";
      else if (is_table(node.op))
        table_name(pool_.table(TableId(node.b)));
      push(")");
      if (is_table(node.op) && !delayed && pool_.table(TableId(node.b)).interpolation == Interpolation::spline)
        push(", spline");
      std::array<ExprId, 3> arguments;
      std::size_t n = 0;
      for_each_argument(node, [&](ExprId a) { arguments[n++] = a; });
      while (n-- > 0) {
        push(arguments[n], Binding::none);
        if (n > 0) push(", ");
      }
    }
  }

  void table_name(const Table& table) {
    for (const std::string& part : {table.file, table.column}) {
      const char quote = part.find('"') == std::string::npos ? '"' : '\'';
      text_ += quote + part + quote + ", ";
    }
  }
};

}  // namespace

std::string to_text(const ExprPool& pool, ExprId root, const SymbolName& name) {
  check_written_size(pool, root);
  return TextWriter(pool, name).write(root);
}

std::string readable_text(const ExprPool& pool, ExprId root, const SymbolName& name) {
  try {
    return to_text(pool, root, name);
  } catch (const std::length_error&) {
    return kTooLong;
  }
}

}  // namespace bgsim
