#include <algorithm>

#include "bgsim/expression.hpp"
#include "bgsim/xml.hpp"
#include "expression/write/typeset.hpp"

namespace bgsim {

namespace {

constexpr std::string_view kOpen = "<mrow><mo>(</mo>", kClose = "<mo>)</mo></mrow>";
constexpr std::string_view kMinusPrefix = "<mo form=\"prefix\">\u2212</mo>";

std::string number_element(std::string_view digits) {
  if (!digits.empty() && digits.front() == '-')
    return xml_element("mrow", std::string(kMinusPrefix) + xml_element("mn", digits.substr(1)));
  return xml_element("mn", digits);
}

/// A word of a name: a Greek letter or one letter in italics, a longer word upright; <mi> sees to that.
std::string word_element(const std::string& word) {
  if (const std::string_view greek = greek_letter(word); !greek.empty()) return xml_element("mi", greek);
  if (is_number_word(word)) return number_element(word);
  return xml_text_element("mi", word);
}

/// "packet.wall.q" is q with the index packet.wall; a derivative has its dot over the letter.
std::string name_element(const std::string& name) {
  const NameParts parts = name_parts(name);
  std::string text = word_element(parts.base);
  for (std::size_t i = 0; i < parts.dots; ++i) {
    text += "<mo>\u02d9</mo>";
    text = xml_element("mover", {{"accent", "true"}}, text);
  }
  if (parts.indices.empty()) return text;
  std::string indices;
  for (std::size_t i = 0; i < parts.indices.size(); ++i)
    indices += (i == 0 ? "" : "<mo>,</mo>") + word_element(parts.indices[i]);
  return xml_element("msub", text + xml_element("mrow", indices));
}

std::string value_element(double value) {
  const auto [mantissa, exponent] = typeset_number(value);
  if (exponent.empty()) return number_element(mantissa);
  std::string power = xml_element("msup", "<mn>10</mn>" + number_element(exponent));
  if (mantissa == "1") return power;
  if (mantissa == "-1") return xml_element("mrow", std::string(kMinusPrefix) + power);
  return xml_element("mrow", number_element(mantissa) + "<mo>\u00b7</mo>" + power);
}

TypesetForm named_function(const std::string& name) {
  return {"<mrow>" + name + "<mo>\u2061</mo>" + std::string(kOpen), "<mo>,</mo>", std::string(kClose) + "</mrow>"};
}

TypesetForm fenced(const std::string& left, const std::string& right) {
  return {"<mrow><mo form=\"prefix\" stretchy=\"true\">" + left + "</mo>", "",
          "<mo form=\"postfix\" stretchy=\"true\">" + right + "</mo></mrow>"};
}

TypesetForm function_element(Op op) {
  switch (op) {
    case Op::abs:
      return fenced("|", "|");
    case Op::floor:
      return fenced("\u230a", "\u230b");
    case Op::ceil:
      return fenced("\u2308", "\u2309");
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
    case Op::asinh:
      return named_function("<mi>arsinh</mi>");
    case Op::acosh:
      return named_function("<mi>arcosh</mi>");
    case Op::atanh:
      return named_function("<mi>artanh</mi>");
    case Op::der:
      return named_function(
          "<mfrac><mi mathvariant=\"normal\">d</mi><mrow><mi mathvariant=\"normal\">d</mi><mi>t</mi>"
          "</mrow></mfrac>");
    default:
      return named_function(xml_element("mi", name_of(op)));
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

TypesetForm table_element(const Table& table, std::size_t derivatives) {
  std::string name = xml_text(table.column);
  if (table.inverse) name += "\u207b\u00b9";
  for (std::size_t i = 0; i < derivatives; ++i) name += "\u2032";
  return named_function(xml_element("mi", name));
}

constexpr Typesetting kMathml{kOpen,
                              kClose,
                              kMinusPrefix,
                              "<mo form=\"prefix\">\u00ac</mo>",
                              "<mo>\u00b7</mo>",
                              "<mo>\u2062</mo><mspace width=\"0.17em\"/>",
                              {"<msup><mrow>", "</mrow><mrow>", "</mrow></msup>"},
                              {"<mrow><mo form=\"prefix\" stretchy=\"true\">{</mo><mtable class=\"cases\"><mtr><mtd>",
                               "</mtd><mtd><mtext>if\u00a0</mtext>", "</mtd></mtr><mtr><mtd>",
                               "</mtd><mtd><mtext>otherwise</mtext></mtd></mtr></mtable></mrow>"},
                              value_element,
                              name_element,
                              sign_element,
                              function_element,
                              table_element};

}  // namespace

std::vector<std::string> to_mathml(const ExprPool& pool, ExprId root, const SymbolName& name) {
  check_written_size(pool, root);
  std::vector<std::string> terms;
  const auto add = [&](ExprId term, Op sign) {
    const Binding least = sign != Op::constant ? stronger(Binding::sum) : terms.empty() ? Binding::none : Binding::sum;
    const std::string text = typeset(pool, term, name, kMathml, least);
    terms.push_back(xml_element("mrow", std::string(sign_element(sign)) + text));
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
