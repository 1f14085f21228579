/// What the ways of writing an expression, text, LaTeX and MathML, have in common: which operand is written first, and
/// where parentheses are needed so that reading gives the same expression again.
#pragma once

#include <string>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// How strongly an operator binds its operands, weakest first. The parser and the writers share it.
enum class Binding : std::uint8_t {
  none,
  either,      ///< or
  both,        ///< and
  negation,    ///< not
  comparison,  ///< < <= > >= == !=
  sum,         ///< + -
  product,     ///< * /
  minus,       ///< unary -
  power,       ///< ^
  atom,        ///< number, name, function, parentheses
};
[[nodiscard]] constexpr Binding stronger(Binding binding) {
  return static_cast<Binding>(static_cast<std::uint8_t>(binding) + 1);
}
/// The binding of an operator; functions are atoms.
Binding binding_of(Op op);

/// The arguments of an operator with two in the order in which they are written: of x + (y + z) and (y + z) + x, which
/// are one expression, the second needs no parentheses.
struct OperandOrder {
  ExprId left, right;
};
OperandOrder written_order(const ExprPool& pool, ExprId id);

/// True if the operand of unary minus may be written without parentheses: -a*b reads as (-a)*b, which is built as
/// -(a*b) unless a itself absorbs the sign.
bool bare_after_minus(const ExprPool& pool, ExprId operand);

/// True if c*(a*b) may be written c*a*b: products gather their constant factor outside, unless a is a quotient.
bool bare_after_factor(const ExprPool& pool, ExprId product);

/// What stands for an expression that shares too much to be written out.
inline constexpr const char* kTooLong = "(too long to print)";

/// Counts the nodes of the expression written out as a tree.
/// @throws std::length_error if there are more than 100,000: a graph that shares much has no text of bearable length.
void check_written_size(const ExprPool& pool, ExprId root);

/// Writes an expression left to right with a stack of what is still to be written, so that depth costs no recursion.
class ExpressionWriter {
 public:
  ExpressionWriter(const ExprPool& pool, const SymbolName& name) : pool_(pool), name_(name) {}
  virtual ~ExpressionWriter() = default;
  ExpressionWriter(const ExpressionWriter&) = delete;
  ExpressionWriter& operator=(const ExpressionWriter&) = delete;

  /// @param least  what binds weaker than this is put into parentheses.
  std::string write(ExprId root, Binding least = Binding::none);

 protected:
  /// Appends the beginning of the expression to text_ and pushes the rest, last piece first.
  /// @param least  what binds weaker than this needs parentheses.
  virtual void begin(ExprId id, Binding least) = 0;

  void push(ExprId id, Binding least) { rest_.push_back({id, least, {}}); }
  void push(std::string_view literal) { rest_.push_back({ExprId(), Binding::none, std::string(literal)}); }

  const ExprPool& pool_;
  const SymbolName& name_;
  std::string text_;

 private:
  struct Piece {
    ExprId id;  ///< none: literal
    Binding least = Binding::none;
    std::string literal;
  };
  std::vector<Piece> rest_;
};

/// A name as it is typeset: "packet.wall.q" is q with the index packet.wall, "R_b" is R with b, "C2" is C with 2;
/// "der(x)" is x with a dot.
struct NameParts {
  std::string base;
  std::vector<std::string> indices;
  std::size_t dots = 0;
};
NameParts name_parts(std::string name);

/// The same name, to be typeset as it is: where its parts would look like those of another one ("R_1" beside "R1").
std::string as_written(const std::string& name);

/// The Greek letter that a word names ("omega", "Delta") in UTF-8; empty if it names none.
std::string_view greek_letter(std::string_view word);
bool is_number_word(std::string_view word);

/// The binding of an operator where quotients are fractions and powers of ten are written out.
Binding typeset_binding(const ExprNode& node);

/// 1.5e-07 is 1.5 times 10 to the -7; without an exponent where the shortest text has none.
struct TypesetNumber {
  std::string mantissa, exponent;
};
TypesetNumber typeset_number(double value);

}  // namespace bgsim
