#include <algorithm>
#include <array>

#include "base/text.hpp"
#include "expression/write/layout.hpp"

namespace bgsim {

namespace {

struct Greek {
  std::string_view name, letter;
};
constexpr std::array<Greek, 36> kGreek{
    {{"alpha", "\u03b1"},   {"beta", "\u03b2"},  {"gamma", "\u03b3"},   {"delta", "\u03b4"}, {"epsilon", "\u03f5"},
     {"zeta", "\u03b6"},    {"eta", "\u03b7"},   {"theta", "\u03b8"},   {"iota", "\u03b9"},  {"kappa", "\u03ba"},
     {"lambda", "\u03bb"},  {"mu", "\u03bc"},    {"nu", "\u03bd"},      {"xi", "\u03be"},    {"rho", "\u03c1"},
     {"sigma", "\u03c3"},   {"tau", "\u03c4"},   {"upsilon", "\u03c5"}, {"phi", "\u03d5"},   {"chi", "\u03c7"},
     {"psi", "\u03c8"},     {"omega", "\u03c9"}, {"Gamma", "\u0393"},   {"Delta", "\u0394"}, {"Theta", "\u0398"},
     {"Lambda", "\u039b"},  {"Xi", "\u039e"},    {"Pi", "\u03a0"},      {"Sigma", "\u03a3"}, {"Upsilon", "\u03a5"},
     {"Phi", "\u03a6"},     {"Psi", "\u03a8"},   {"Omega", "\u03a9"},   {"ell", "\u2113"},   {"varphi", "\u03c6"},
     {"vartheta", "\u03d1"}}};

}  // namespace

std::string_view greek_letter(std::string_view word) {
  const auto* const found =
      std::find_if(kGreek.begin(), kGreek.end(), [&](const Greek& greek) { return greek.name == word; });
  return found == kGreek.end() ? std::string_view() : found->letter;
}

bool is_number_word(std::string_view word) { return std::all_of(word.begin(), word.end(), is_digit); }

std::string as_written(const std::string& name) { return '"' + name + '"'; }

NameParts name_parts(std::string name) {
  NameParts parts;
  for (; name.rfind("der(", 0) == 0 && name.back() == ')'; ++parts.dots) name = name.substr(4, name.size() - 5);
  if (name.size() > 2 && name.front() == '"' && name.back() == '"') {
    parts.base = name.substr(1, name.size() - 2);
    return parts;
  }
  std::string owner;
  if (const std::size_t dot = name.rfind('.'); dot != std::string::npos) {
    owner = name.substr(0, dot);
    name = name.substr(dot + 1);
  }
  if (const std::size_t bar = name.find('_'); bar != std::string::npos && bar > 0 && bar + 1 < name.size()) {
    parts.indices.push_back(name.substr(bar + 1));
    name.resize(bar);
  }
  std::size_t letters = name.size();
  while (letters > 0 && is_digit(name[letters - 1])) --letters;
  if (letters > 0 && letters < name.size()) {
    parts.indices.insert(parts.indices.begin(), name.substr(letters));
    name.resize(letters);
  }
  if (!owner.empty()) parts.indices.push_back(owner);
  parts.base = name;
  return parts;
}

Binding typeset_binding(const ExprNode& node) {
  if (node.op == Op::constant) {
    if (node.constant < 0.0) return Binding::minus;
    return shortest_number(node.constant).find('e') == std::string::npos ? Binding::atom : Binding::product;
  }
  if (node.op == Op::neg) return Binding::product;  // -a b needs no parentheses in print
  if (node.op == Op::select) return Binding::none;
  return node.op == Op::div ? Binding::power : binding_of(node.op);
}

TypesetNumber typeset_number(double value) {
  const std::string text = shortest_number(value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return {text, {}};
  std::string exponent = text.substr(e + 1);
  const bool negative = exponent.front() == '-';
  exponent.erase(0, std::min(exponent.find_first_not_of("+-0"), exponent.size() - 1));
  return {text.substr(0, e), (negative ? "-" : "") + exponent};
}

}  // namespace bgsim
