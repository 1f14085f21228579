#include "expression/text_form.hpp"

#include <optional>
#include <vector>

#include "base/text.hpp"
#include "expression/language.hpp"
#include "expression/parse.hpp"

namespace bgsim {

namespace {

std::string_view side_of_law(std::string_view text, std::size_t& begin) {
  while (!text.empty() && is_space(text.front())) {
    text.remove_prefix(1);
    ++begin;
  }
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace

bool is_condition_text(std::string_view text) {
  std::size_t functions = 0;      // open parentheses that belong to a function
  std::vector<bool> of_function;  // by open parenthesis
  char quote = '\0';
  std::string_view word;  // the last, if nothing has followed it
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
      continue;
    }
    if (is_space(c)) continue;
    if (begins_name(c)) {
      std::size_t end = i;
      while (end < text.size() && (begins_name(text[end]) || is_digit(text[end]) || text[end] == '.')) ++end;
      word = text.substr(i, end - i);
      if (functions == 0 && (word == "and" || word == "or" || word == "not")) return true;
      if (word == "and" || word == "or" || word == "not") word = {};
      i = end - 1;
      continue;
    }
    if (c == '"' || c == '\'') quote = c;
    if (c == '(') {
      if (functions == 0 && word == "mode") return true;
      of_function.push_back(!word.empty());
      if (!word.empty()) ++functions;
    } else if (c == ')' && !of_function.empty()) {
      if (of_function.back()) --functions;
      of_function.pop_back();
    }
    if (functions == 0 && (c == '<' || c == '>' || c == '!' || (c == '=' && i + 1 < text.size() && text[i + 1] == '=')))
      return true;
    word = {};
  }
  return false;
}

LawText split_law(std::string_view text) {
  std::optional<std::size_t> equals;
  char quote = '\0';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '=' && i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (c == '=' && (i == 0 || (text[i - 1] != '<' && text[i - 1] != '>' && text[i - 1] != '!'))) {
      if (equals)
        throw ExpressionError("BG126", "a law has one equals sign, this has a second", i, i + 1, "write == to compare");
      equals = i;
    }
  }
  if (!equals)
    throw ExpressionError("BG126", "a law has an equals sign, this has none", 0, text.size(),
                          "write the law as an equation, such as e = R*f");
  LawText law{{}, {}, 0, *equals + 1};
  law.left = side_of_law(text.substr(0, *equals), law.left_begin);
  law.right = side_of_law(text.substr(*equals + 1), law.right_begin);
  return law;
}

}  // namespace bgsim
