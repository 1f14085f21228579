#include "base/latex_text.hpp"
#include "base/text.hpp"
#include "bgsim/expression.hpp"
#include "expression/write/typeset.hpp"

namespace bgsim {

namespace {

/// A word of a name: a Greek letter, one letter in italics, or upright.
std::string word_latex(const std::string& word) {
  if (!greek_letter(word).empty()) return "\\" + word;
  if ((word.size() == 1 && is_letter(word[0])) || is_number_word(word)) return word;
  return latex_text(word);
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

TypesetForm function_latex(Op op) {
  switch (op) {
    case Op::abs:
      return {"\\left|", "", "\\right|"};
    case Op::sqrt:
      return {"\\sqrt{", "", "}"};
    case Op::cbrt:
      return {"\\sqrt[3]{", "", "}"};
    case Op::floor:
      return {"\\left\\lfloor ", "", "\\right\\rfloor"};
    case Op::ceil:
      return {"\\left\\lceil ", "", "\\right\\rceil"};
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
    case Op::asinh:
      return {"\\operatorname{arsinh}\\left(", "", "\\right)"};
    case Op::acosh:
      return {"\\operatorname{arcosh}\\left(", "", "\\right)"};
    case Op::atanh:
      return {"\\operatorname{artanh}\\left(", "", "\\right)"};
    case Op::min:
      return {"\\min\\left(", ", ", "\\right)"};
    case Op::max:
      return {"\\max\\left(", ", ", "\\right)"};
    case Op::der:
      return {"\\frac{\\mathrm{d}}{\\mathrm{d}t}\\left(", "", "\\right)"};
    case Op::div:
      return {"\\frac{", "}{", "}"};
    default:
      return {"\\operatorname{" + std::string(name_of(op)) + "}\\left(", ", ", "\\right)"};
  }
}

TypesetForm table_latex(const Table& table, std::size_t derivatives) {
  const std::string name = table.inverse ? "{" + word_latex(table.column) + "^{-1}}" : word_latex(table.column);
  return {name + std::string(derivatives, '\'') + "\\left(", ", ", "\\right)"};
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

constexpr Typesetting kLatex{"\\left(",
                             "\\right)",
                             "-",
                             "\\lnot ",
                             " \\cdot ",
                             " \\, ",
                             {"", "^{", "}"},
                             {"\\begin{cases} ", " & \\text{if } ", " \\\\ ", " & \\text{otherwise} \\end{cases}"},
                             number_latex,
                             name_latex,
                             sign_latex,
                             function_latex,
                             table_latex};

}  // namespace

std::string to_latex(const ExprPool& pool, ExprId root, const SymbolName& name) {
  check_written_size(pool, root);
  return typeset(pool, root, name, kLatex);
}

}  // namespace bgsim
