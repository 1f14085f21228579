/// Expressions as a hash-consed graph: equal subexpressions are one node, children have smaller ids than parents, so
/// that evaluation, substitution and differentiation are forward loops without recursion.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "bgsim/id.hpp"

namespace bgsim {

/// Operators. Booleans (results of comparisons and of and/or/not) are the numbers 0 and 1; the parser keeps the two
/// apart.
enum class Op : std::uint8_t {
  constant,  ///< value()
  symbol,    ///< symbol()
  // arithmetic
  neg,
  add,
  sub,
  mul,
  div,
  pow,
  // functions of one argument
  abs,
  sign,
  sqrt,
  cbrt,
  exp,
  log,
  log10,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  asinh,
  acosh,
  atanh,
  log1p,  ///< log(1 + a)
  expm1,  ///< exp(a) - 1
  floor,
  ceil,
  round,  ///< to the nearest integer, halves away from zero
  step,   ///< 0 for a < 0, 1 for a >= 0
  // functions of two arguments
  min,
  max,
  atan2,
  hypot,
  ssqrt,  ///< a / (a^2 + b^2)^(1/4)
  mod,    ///< a - b*floor(a/b): of the sign of b
  // comparisons and logic
  lt,
  le,
  gt,
  ge,
  eq,
  ne,
  logical_and,
  logical_or,
  logical_not,
  select,  ///< a != 0 ? b : c; written if(a, b, c)
  // data: argument a, table index in b
  table,            ///< interpolated value
  table_slope,      ///< derivative of the interpolation
  table_curvature,  ///< second derivative of the interpolation
  table_third,      ///< third derivative of the interpolation: one number in each cell
  der,              ///< total time derivative of a; only in models, resolved by derive_equations
};

/// Number of expression arguments of an operator (table: 1, select: 3).
int arity(Op op);
/// The operator's name in the expression language ("+", "sin", "if", ...).
std::string_view name_of(Op op);

struct ExprNode {
  Op op = Op::constant;
  std::uint32_t a = 0, b = 0, c = 0;  ///< argument ids; symbol/table index
  double constant = 0.0;
};

/// How measured data are interpolated.
enum class Interpolation : std::uint8_t { linear, spline };

/// A column of measured data over strictly increasing abscissae.
struct Table {
  std::string file, column;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> x, y;
  std::vector<double> slope2;  ///< second derivatives at the knots (spline only)
  bool inverse = false;        ///< with x and y exchanged: x is the column, and y what the file has first
  /// Not data: what a delayed signal was, as a run has it so far. Its knots come in pairs, each the ends of a cubic;
  /// and it is looked up between `first` and `last` of them alone, and beyond these by the cubics there.
  bool delayed = false;
  std::size_t first = 0, last = 0;
};
/// Value, or NaN outside [x.front(), x.back()].
double table_value(const Table& table, double x);
double table_slope(const Table& table, double x);
double table_curvature(const Table& table, double x);
double table_third(const Table& table, double x);
/// True for table and its derivatives.
[[nodiscard]] constexpr bool is_table(Op op) { return op >= Op::table && op <= Op::table_third; }
/// The one of the four that @p op asks for.
double apply_table(Op op, const Table& table, double x);
/// Fills slope2 (not-a-knot cubic spline; natural with fewer than four knots).
void prepare_spline(Table& table);

/// Owner of expressions. Constructors simplify locally (constants are folded, x+0, x*1, x*0, --x, ...), never across
/// domains in a way that hides an error for finite arguments.
class ExprPool {
 public:
  ExprId constant(double value);
  ExprId symbol(SymbolId symbol);
  ExprId make(Op op, ExprId a);
  ExprId make(Op op, ExprId a, ExprId b);
  ExprId select(ExprId condition, ExprId then, ExprId otherwise);
  ExprId table(Op op, ExprId argument, TableId table);
  TableId add_table(Table table);
  TableId add_table(const std::shared_ptr<const Table>& table);  ///< of another pool
  /// From here on this table is another one, of the same column.
  void replace_table(TableId id, std::shared_ptr<const Table> table) { tables_[id.index()] = std::move(table); }

  // Shorthands
  ExprId add(ExprId a, ExprId b) { return make(Op::add, a, b); }
  ExprId sub(ExprId a, ExprId b) { return make(Op::sub, a, b); }
  ExprId mul(ExprId a, ExprId b) { return make(Op::mul, a, b); }
  ExprId div(ExprId a, ExprId b) { return make(Op::div, a, b); }
  ExprId pow(ExprId a, ExprId b) { return make(Op::pow, a, b); }
  ExprId neg(ExprId a) { return make(Op::neg, a); }

  [[nodiscard]] const ExprNode& operator[](ExprId id) const { return nodes_[id.index()]; }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] bool is_constant(ExprId id) const { return nodes_[id.index()].op == Op::constant; }
  [[nodiscard]] bool is_constant(ExprId id, double value) const;
  [[nodiscard]] bool is_symbol(ExprId id) const { return nodes_[id.index()].op == Op::symbol; }
  [[nodiscard]] SymbolId symbol_of(ExprId id) const { return SymbolId(nodes_[id.index()].a); }
  [[nodiscard]] const Table& table(TableId id) const { return *tables_[id.index()]; }
  /// Data are never changed and never copied: pools that are copies of each other, or translated from each other, share
  /// them.
  [[nodiscard]] const std::vector<std::shared_ptr<const Table>>& tables() const { return tables_; }

 private:
  ExprId intern(const ExprNode& node);
  std::vector<ExprNode> nodes_;
  std::vector<std::shared_ptr<const Table>> tables_;
  std::vector<std::uint32_t> index_;  // open-addressing hash table of node ids
};

/// Value of one operator on numbers; the one place where semantics are pinned down (pow, sign(0), NaN in min/max, ...).
/// Domain errors give NaN.
double apply(Op op, double a, double b = 0.0, double c = 0.0);

/// The nodes that @p roots depend on, children before parents.
std::vector<ExprId> reachable(const ExprPool& pool, std::span<const ExprId> roots);

/// The symbols that @p roots depend on, in order of id.
std::vector<SymbolId> symbols_in(const ExprPool& pool, std::span<const ExprId> roots);

/// Evaluates @p root with symbol values by SymbolId. Reference semantics; allocates. Op::der gives NaN.
double evaluate(const ExprPool& pool, ExprId root, std::span<const double> symbol_values);

/// Copies expressions of one pool into another, replacing symbols. Keeps a memo, so that translating many expressions
/// of one model costs the size of the model.
class Translator {
 public:
  /// @p replace gives the expression in @p to for a symbol of @p from. @p on_der gives the expression in @p to that
  /// is used for der(argument), given the argument already translated; may be empty when there is no der.
  Translator(const ExprPool& from, ExprPool& to, std::function<ExprId(SymbolId)> replace,
             std::function<ExprId(ExprId)> on_der = {});
  ExprId operator()(ExprId expression);

 private:
  const ExprPool& from_;
  ExprPool& to_;
  std::function<ExprId(SymbolId)> replace_;
  std::function<ExprId(ExprId)> on_der_;
  std::vector<ExprId> memo_;
  std::vector<TableId> tables_;
};

/// Replaces symbols inside one pool. Symbols for which @p replacement is none stay.
ExprId substitute(ExprPool& pool, ExprId root, const std::unordered_map<SymbolId, ExprId>& replacement);

/// Partial derivatives of @p root with respect to each symbol it depends on for which @p wanted is true (reverse mode;
/// the result shares subexpressions). Derivatives are those almost everywhere: 0 for sign, step, floor, ceil, round and
/// comparisons; select, min, max, abs by branches; mod between its jumps.
/// @return pairs in order of symbol id; partials that are identically 0 are left out.
std::vector<std::pair<SymbolId, ExprId>> gradient(ExprPool& pool, ExprId root,
                                                  const std::function<bool(SymbolId)>& wanted);

/// The same with numbers and factors cancelled as they come up, before they are shared: of (x - y)^2/(2*c) it is
/// (x - y)/c by x and -((x - y)/c) by y. For laws that are derived once and computed often.
std::vector<std::pair<SymbolId, ExprId>> short_gradient(ExprPool& pool, ExprId root,
                                                        const std::function<bool(SymbolId)>& wanted);

/// Whether a table is constant between its knots in this derivative, and another constant beyond: the slope of a
/// linear one, the third derivative of a spline. Not of delayed signals, which are smooth where they were.
bool jumps_at_knots(const ExprPool& pool, const ExprNode& node);

/// True if the derivative of @p root by @p x hides a jump: x reaches a sign, step, floor, ceil, round, mod,
/// a comparison of an if, or a table that jumps at its knots.
bool jumps_with(const ExprPool& pool, ExprId root, const std::function<bool(SymbolId)>& x);

/// Solves  y = expression(x)  for x where x occurs once along a chain of invertible operators, or linearly.
/// @return x as an expression of @p y and the other symbols; none if there is no such closed form valid on the whole
/// real range of the law (x^2, sin x, abs x, if ... have none; exp, odd powers, tanh, a*x+b have).
std::optional<ExprId> invert(ExprPool& pool, ExprId expression, SymbolId x, ExprId y);

/// The coefficient a(others) if expression = a*x + b with a, b free of x.
struct LinearForm {
  ExprId slope, offset;
};
std::optional<LinearForm> linear_in(ExprPool& pool, ExprId expression, SymbolId x);

using SymbolName = std::function<std::string(SymbolId)>;
/// The expression in bgsim's own language, with as few parentheses as keep its meaning; parsing it gives the same
/// expression. Slopes and curvatures of tables, which come from derivatives only, have no form that can be parsed.
/// @throws std::length_error if the text would hold more than 100,000 operators and operands: expressions that share
///         much must be written in parts, by whoever can name the parts. The same holds for to_latex.
std::string to_text(const ExprPool& pool, ExprId root, const SymbolName& name);
/// The same for people to read: "(too long to print)" instead of an exception.
std::string readable_text(const ExprPool& pool, ExprId root, const SymbolName& name);
/// The expression as LaTeX (fractions, roots, cases). Names like "packet.wall.q" become q_{\mathrm{packet.wall}}.
std::string to_latex(const ExprPool& pool, ExprId root, const SymbolName& name);
/// The expression as presentation MathML (Core), one piece for each term of its outermost sum, each with its sign, so
/// that a line may be broken between them. A piece is the inside of one <math> element.
std::vector<std::string> to_mathml(const ExprPool& pool, ExprId root, const SymbolName& name);

}  // namespace bgsim
