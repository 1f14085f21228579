#include <algorithm>
#include <array>

#include "bgsim/expression.hpp"
#include "expression_graph.hpp"
#include "expression_layout.hpp"

namespace bgsim {

namespace {

constexpr std::string_view kOpen = "<mrow><mo>(</mo>", kClose = "<mo>)</mo></mrow>";
constexpr std::string_view kMinusPrefix = "<mo form=\"prefix\">\u2212</mo>";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else
      result += c;
  }
  return result;
}

std::string number_element(std::string_view digits) {
  if (!digits.empty() && digits.front() == '-')
    return "<mrow>" + std::string(kMinusPrefix) + "<mn>" + std::string(digits.substr(1)) + "</mn></mrow>";
  return "<mn>" + std::string(digits) + "</mn>";
}

/// A word of a name: a Greek letter or one letter in italics, a longer word upright; <mi> sees to that.
std::string word_element(const std::string& word) {
  if (const std::string_view greek = greek_letter(word); !greek.empty()) return "<mi>" + std::string(greek) + "</mi>";
  if (is_number_word(word)) return number_element(word);
  return "<mi>" + escaped(word) + "</mi>";
}

/// "packet.wall.q" is q with the index packet.wall; a derivative has its dot over the letter.
std::string name_element(const std::string& name) {
  const NameParts parts = name_parts(name);
  std::string text = word_element(parts.base);
  for (std::size_t i = 0; i < parts.dots; ++i)
    text.insert(0, "<mover accent=\"true\">").append("<mo>\u02d9</mo></mover>");
  if (parts.indices.empty()) return text;
  text = "<msub>" + text + "<mrow>";
  for (std::size_t i = 0; i < parts.indices.size(); ++i)
    text += (i == 0 ? "" : "<mo>,</mo>") + word_element(parts.indices[i]);
  return text + "</mrow></msub>";
}

std::string value_element(double value) {
  const auto [mantissa, exponent] = typeset_number(value);
  if (exponent.empty()) return number_element(mantissa);
  std::string power = "<msup><mn>10</mn>" + number_element(exponent) + "</msup>";
  if (mantissa == "1") return power;
  if (mantissa == "-1") return "<mrow>" + std::string(kMinusPrefix) + power + "</mrow>";
  return "<mrow>" + number_element(mantissa) + "<mo>\u00b7</mo>" + power + "</mrow>";
}

/// How a function is written around its arguments.
struct Form {
  std::string before, between, after;
};

Form named_function(const std::string& name) {
  return {"<mrow>" + name + "<mo>\u2061</mo>" + std::string(kOpen), "<mo>,</mo>", std::string(kClose) + "</mrow>"};
}

Form fenced(const std::string& left, const std::string& right) {
  return {"<mrow><mo form=\"prefix\" stretchy=\"true\">" + left + "</mo>", "",
          "<mo form=\"postfix\" stretchy=\"true\">" + right + "</mo></mrow>"};
}

Form form_of(Op op) {
  switch (op) {
    case Op::abs:
      return fenced("|", "|");
    case Op::floor:
      return fenced("\u230a", "\u230b");
    case Op::sqrt:
      return {"<msqrt>", "", "</msqrt>"};
    case Op::cbrt:
      return {"<mroot><mrow>", "", "</mrow><mn>3</mn></mroot>"};
    case Op::div:
      return {"<mfrac><mrow>", "</mrow><mrow>", "</mrow></mfrac>"};
    case Op::log:
      return named_function("<mi>ln</mi>");
    case Op::log10:
      return named_function("<msub><mi>log</mi><mn>10</mn></msub>");
    case Op::asin:
      return named_function("<mi>arcsin</mi>");
    case Op::acos:
      return named_function("<mi>arccos</mi>");
    case Op::atan:
      return named_function("<mi>arctan</mi>");
    case Op::der:
      return named_function(
          "<mfrac><mi mathvariant=\"normal\">d</mi><mrow><mi mathvariant=\"normal\">d</mi><mi>t</mi>"
          "</mrow></mfrac>");
    default:
      return named_function("<mi>" + std::string(name_of(op)) + "</mi>");
  }
}

std::string_view sign_element(Op op) {
  switch (op) {
    case Op::le:
      return "<mo>\u2264</mo>";
    case Op::ge:
      return "<mo>\u2265</mo>";
    case Op::eq:
      return "<mo>=</mo>";
    case Op::ne:
      return "<mo>\u2260</mo>";
    case Op::lt:
      return "<mo>&lt;</mo>";
    case Op::gt:
      return "<mo>&gt;</mo>";
    case Op::logical_and:
      return "<mo>\u2227</mo>";
    case Op::logical_or:
      return "<mo>\u2228</mo>";
    case Op::add:
      return "<mo form=\"infix\">+</mo>";
    case Op::sub:
      return "<mo form=\"infix\">\u2212</mo>";
    default:
      return "";
  }
}

class MathmlWriter : public ExpressionWriter {
 public:
  using ExpressionWriter::ExpressionWriter;

 private:
  void begin(ExprId id, Binding least) override {
    const ExprNode& node = pool_[id];
    const Binding own = typeset_binding(node);
    if (own < least) {
      text_ += kOpen;
      push(kClose);
    }
    const ExprId a(node.a);
    switch (node.op) {
      case Op::constant:
        text_ += value_element(node.constant);
        return;
      case Op::symbol:
        text_ += name_element(name_(SymbolId(node.a)));
        return;
      case Op::neg:
        text_ += kMinusPrefix;
        push(a, Binding::product);
        return;
      case Op::logical_not:
        text_ += "<mo form=\"prefix\">\u00ac</mo>";
        push(a, Binding::atom);
        return;
      case Op::pow:
        text_ += "<msup><mrow>";
        push("</mrow></msup>");
        push(ExprId(node.b), Binding::none);
        push("</mrow><mrow>");
        push(a, Binding::atom);
        return;
      case Op::mul:
        product(id);
        return;
      case Op::select:
        cases(node);
        return;
      case Op::der:
        if (pool_.is_symbol(a))
          text_ += name_element("der(" + name_(pool_.symbol_of(a)) + ")");
        else
          function(node);
        return;
      default:
        if (own == Binding::sum || is_logical(node.op))
          binary(id, own);
        else
          function(node);
    }
  }

  void cases(const ExprNode& node) {
    text_ += "<mrow><mo form=\"prefix\" stretchy=\"true\">{</mo><mtable class=\"cases\"><mtr><mtd>";
    push("</mtd><mtd><mtext>otherwise</mtext></mtd></mtr></mtable></mrow>");
    push(ExprId(node.c), Binding::none);
    push("</mtd></mtr><mtr><mtd>");
    push(ExprId(node.a), Binding::none);
    push("</mtd><mtd><mtext>if\u00a0</mtext>");
    push(ExprId(node.b), Binding::none);
  }

  void binary(ExprId id, Binding own) {
    const auto [left, right] = written_order(pool_, id);
    push(right, stronger(own));
    push(sign_element(pool_[id].op));
    push(left, own == Binding::comparison ? Binding::sum : own);
  }

  void product(ExprId id) {
    const auto [left, right] = written_order(pool_, id);
    // Before a factor that begins with a digit a thin space would be misread.
    const bool digits =
        pool_.is_constant(right) || (pool_[right].op == Op::pow && pool_.is_constant(ExprId(pool_[right].a)));
    const bool gather = pool_.is_constant(left) && pool_[right].op == Op::mul;
    push(right, gather ? Binding::product : Binding::power);
    push(digits ? "<mo>\u00b7</mo>" : "<mo>\u2062</mo><mspace width=\"0.17em\"/>");
    push(left, Binding::product);
  }

  void function(const ExprNode& node) {
    Form form = form_of(node.op);
    if (is_table(node.op)) {
      const auto order = static_cast<std::size_t>(node.op) - static_cast<std::size_t>(Op::table);
      std::string name = escaped(pool_.tables()[node.b].column);
      for (std::size_t i = 0; i < order; ++i) name += "\u2032";
      form = named_function("<mi>" + name + "</mi>");
    }
    text_ += form.before;
    push(form.after);
    std::array<ExprId, 3> arguments;
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId argument) { arguments[n++] = argument; });
    while (n-- > 0) {
      push(arguments[n], Binding::none);
      if (n > 0) push(form.between);
    }
  }
};

}  // namespace

std::vector<std::string> to_mathml(const ExprPool& pool, ExprId root, const SymbolName& name) {
  check_written_size(pool, root);
  std::vector<std::string> terms;
  const auto add = [&](ExprId term, Op sign) {
    const Binding least = sign != Op::constant ? stronger(Binding::sum) : terms.empty() ? Binding::none : Binding::sum;
    const std::string text = MathmlWriter(pool, name).write(term, least);
    terms.push_back("<mrow>" + std::string(sign_element(sign)) + text + "</mrow>");
  };
  while (pool[root].op == Op::add || pool[root].op == Op::sub) {
    const auto [left, right] = written_order(pool, root);
    add(right, pool[root].op);
    root = left;
  }
  add(root, Op::constant);
  std::reverse(terms.begin(), terms.end());
  return terms;
}

}  // namespace bgsim
