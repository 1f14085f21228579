#include <array>

#include "bgsim/expression.hpp"
#include "expression_graph.hpp"
#include "expression_layout.hpp"

namespace bgsim {

namespace {

/// A word of a name: a Greek letter, one letter in italics, or upright.
std::string word_latex(const std::string& word) {
  if (!greek_letter(word).empty()) return "\\" + word;
  if (word.size() == 1 || is_number_word(word)) return word;
  std::string escaped;
  for (const char c : word) escaped += c == '_' ? std::string("\\_") : std::string(1, c);
  return "\\mathrm{" + escaped + "}";
}

/// "packet.wall.q" is q_{\mathrm{packet.wall}}, "R_b" is R_{b}, "C2" is C_{2}, "omega" is \omega.
std::string name_latex(const std::string& name) {
  const NameParts parts = name_parts(name);
  std::string text = word_latex(parts.base);
  for (std::size_t i = 0; i < parts.indices.size(); ++i) text += (i == 0 ? "_{" : ",") + word_latex(parts.indices[i]);
  if (!parts.indices.empty()) text += "}";
  for (std::size_t i = 0; i < parts.dots; ++i) text.insert(0, "\\dot{").append("}");
  return text;
}

/// 1.5e-07 is 1.5 \cdot 10^{-7}.
std::string number_latex(double value) {
  const auto [mantissa, exponent] = typeset_number(value);
  if (exponent.empty()) return mantissa;
  std::string power = "10^{" + exponent + "}";
  if (mantissa == "1") return power;
  if (mantissa == "-1") return "-" + power;
  return mantissa + " \\cdot " + power;
}

/// How a function is written around its arguments.
struct Form {
  std::string_view before, between, after;
};
Form form_of(Op op) {
  switch (op) {
    case Op::abs:
      return {"\\left|", "", "\\right|"};
    case Op::sqrt:
      return {"\\sqrt{", "", "}"};
    case Op::cbrt:
      return {"\\sqrt[3]{", "", "}"};
    case Op::floor:
      return {"\\left\\lfloor ", "", "\\right\\rfloor"};
    case Op::exp:
      return {"\\exp\\left(", "", "\\right)"};
    case Op::log:
      return {"\\ln\\left(", "", "\\right)"};
    case Op::log10:
      return {"\\log_{10}\\left(", "", "\\right)"};
    case Op::sin:
      return {"\\sin\\left(", "", "\\right)"};
    case Op::cos:
      return {"\\cos\\left(", "", "\\right)"};
    case Op::tan:
      return {"\\tan\\left(", "", "\\right)"};
    case Op::asin:
      return {"\\arcsin\\left(", "", "\\right)"};
    case Op::acos:
      return {"\\arccos\\left(", "", "\\right)"};
    case Op::atan:
      return {"\\arctan\\left(", "", "\\right)"};
    case Op::sinh:
      return {"\\sinh\\left(", "", "\\right)"};
    case Op::cosh:
      return {"\\cosh\\left(", "", "\\right)"};
    case Op::tanh:
      return {"\\tanh\\left(", "", "\\right)"};
    case Op::min:
      return {"\\min\\left(", ", ", "\\right)"};
    case Op::max:
      return {"\\max\\left(", ", ", "\\right)"};
    case Op::der:
      return {"\\frac{\\mathrm{d}}{\\mathrm{d}t}\\left(", "", "\\right)"};
    case Op::div:
      return {"\\frac{", "}{", "}"};
    default:
      return {"", ", ", "\\right)"};
  }
}

std::string_view sign_latex(Op op) {
  switch (op) {
    case Op::le:
      return " \\le ";
    case Op::ge:
      return " \\ge ";
    case Op::eq:
      return " = ";
    case Op::ne:
      return " \\ne ";
    case Op::lt:
      return " < ";
    case Op::gt:
      return " > ";
    case Op::logical_and:
      return " \\land ";
    case Op::logical_or:
      return " \\lor ";
    case Op::add:
      return " + ";
    case Op::sub:
      return " - ";
    default:
      return "";
  }
}

class LatexWriter : public ExpressionWriter {
 public:
  using ExpressionWriter::ExpressionWriter;

 private:
  using ExpressionWriter::push;

  void begin(ExprId id, Binding least) override {
    const ExprNode& node = pool_[id];
    const Binding own = typeset_binding(node);
    if (own < least) {
      text_ += "\\left(";
      push("\\right)");
    }
    const ExprId a(node.a), b(node.b), c(node.c);
    switch (node.op) {
      case Op::constant:
        text_ += number_latex(node.constant);
        return;
      case Op::symbol:
        text_ += name_latex(name_(SymbolId(node.a)));
        return;
      case Op::neg:
        text_ += "-";
        push(a, Binding::product);
        return;
      case Op::logical_not:
        text_ += "\\lnot ";
        push(a, Binding::atom);
        return;
      case Op::pow:
        push("}");
        push(b, Binding::none);
        push("^{");
        push(a, Binding::atom);
        return;
      case Op::mul:
        product(id);
        return;
      case Op::select:
        push("\\begin{cases} ", b, " & \\text{if } ", a, " \\\\ ", c, " & \\text{otherwise} \\end{cases}");
        return;
      case Op::der:
        if (pool_.is_symbol(a)) {
          text_ += "\\dot{";
          push("}");
          push(a, Binding::none);
          return;
        }
        function(node);
        return;
      default:
        if (own == Binding::sum || is_logical(node.op))
          binary(id, own);
        else
          function(node);
    }
  }

  void push(std::string_view s0, ExprId x0, std::string_view s1, ExprId x1, std::string_view s2, ExprId x2,
            std::string_view s3) {
    push(s3);
    push(x2, Binding::none);
    push(s2);
    push(x1, Binding::none);
    push(s1);
    push(x0, Binding::none);
    push(s0);
  }

  void binary(ExprId id, Binding own) {
    const auto [left, right] = written_order(pool_, id);
    push(right, stronger(own));
    push(sign_latex(pool_[id].op));
    push(left, own == Binding::comparison ? Binding::sum : own);
  }

  void product(ExprId id) {
    const auto [left, right] = written_order(pool_, id);
    // Before a factor that begins with a digit a thin space would be misread.
    const bool digits =
        pool_.is_constant(right) || (pool_[right].op == Op::pow && pool_.is_constant(ExprId(pool_[right].a)));
    const bool gather = pool_.is_constant(left) && pool_[right].op == Op::mul;
    push(right, gather ? Binding::product : Binding::power);
    push(digits ? " \\cdot " : " \\, ");
    push(left, Binding::product);
  }

  void function(const ExprNode& node) {
    const Form form = form_of(node.op);
    if (is_table(node.op)) {
      const std::string primes(static_cast<std::size_t>(node.op) - static_cast<std::size_t>(Op::table), '\'');
      text_ += word_latex(pool_.tables()[node.b].column) + primes + "\\left(";
    } else if (form.before.empty()) {
      text_ += "\\operatorname{" + std::string(name_of(node.op)) + "}\\left(";
    } else {
      text_ += form.before;
    }
    push(form.after);
    std::array<ExprId, 3> arguments;
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId a) { arguments[n++] = a; });
    while (n-- > 0) {
      push(arguments[n], Binding::none);
      if (n > 0) push(form.between);
    }
  }
};

}  // namespace

std::string to_latex(const ExprPool& pool, ExprId root, const SymbolName& name) {
  check_written_size(pool, root);
  return LatexWriter(pool, name).write(root);
}

}  // namespace bgsim
