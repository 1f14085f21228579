#include <algorithm>
#include <array>

#include "bgsim/expression.hpp"
#include "expression_graph.hpp"
#include "expression_layout.hpp"

namespace bgsim {

namespace {

constexpr std::array<std::string_view, 36> kGreek{
    "alpha", "beta",   "gamma", "delta", "epsilon", "zeta",    "eta", "theta", "iota",  "kappa", "lambda", "mu",
    "nu",    "xi",     "rho",   "sigma", "tau",     "upsilon", "phi", "chi",   "psi",   "omega", "Gamma",  "Delta",
    "Theta", "Lambda", "Xi",    "Pi",    "Sigma",   "Upsilon", "Phi", "Psi",   "Omega", "ell",   "varphi", "vartheta"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A word of a name: a Greek letter, one letter in italics, or upright.
std::string word_latex(const std::string& word) {
  if (std::find(kGreek.begin(), kGreek.end(), word) != kGreek.end()) return "\\" + word;
  if (word.size() == 1 || std::all_of(word.begin(), word.end(), is_digit)) return word;
  std::string escaped;
  for (const char c : word) escaped += c == '_' ? std::string("\\_") : std::string(1, c);
  return "\\mathrm{" + escaped + "}";
}

/// "packet.wall.q" is q_{\mathrm{packet.wall}}, "R_b" is R_{b}, "C2" is C_{2}, "omega" is \omega.
std::string name_latex(std::string name) {
  if (name.rfind("der(", 0) == 0 && name.back() == ')')
    return "\\dot{" + name_latex(name.substr(4, name.size() - 5)) + "}";
  std::vector<std::string> indices;
  std::string owner;
  if (const std::size_t dot = name.rfind('.'); dot != std::string::npos) {
    owner = name.substr(0, dot);
    name = name.substr(dot + 1);
  }
  if (const std::size_t bar = name.find('_'); bar != std::string::npos && bar > 0 && bar + 1 < name.size()) {
    indices.push_back(word_latex(name.substr(bar + 1)));
    name.resize(bar);
  }
  std::size_t letters = name.size();
  while (letters > 0 && is_digit(name[letters - 1])) --letters;
  if (letters > 0 && letters < name.size()) {
    indices.insert(indices.begin(), name.substr(letters));
    name.resize(letters);
  }
  if (!owner.empty()) indices.push_back(word_latex(owner));
  std::string text = word_latex(name);
  if (indices.empty()) return text;
  text += "_{";
  for (std::size_t i = 0; i < indices.size(); ++i) text += (i == 0 ? "" : ",") + indices[i];
  return text + "}";
}

/// 1.5e-07 is 1.5 \cdot 10^{-7}.
std::string number_latex(double value) {
  std::string text = number_text(value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  std::string mantissa = text.substr(0, e), exponent = text.substr(e + 1);
  const bool negative = exponent.front() == '-';
  exponent.erase(0, std::min(exponent.find_first_not_of("+-0"), exponent.size() - 1));
  std::string power = "10^{" + std::string(negative ? "-" : "") + exponent + "}";
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

  [[nodiscard]] Binding own_binding(const ExprNode& node) const {
    if (node.op == Op::constant) {
      if (node.constant < 0.0) return Binding::minus;
      return number_text(node.constant).find('e') == std::string::npos ? Binding::atom : Binding::product;
    }
    if (node.op == Op::neg) return Binding::product;  // -a b needs no parentheses in print
    if (node.op == Op::select) return Binding::none;
    return node.op == Op::div ? Binding::power : binding_of(node.op);
  }

  void begin(ExprId id, Binding least) override {
    const ExprNode& node = pool_[id];
    const Binding own = own_binding(node);
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
