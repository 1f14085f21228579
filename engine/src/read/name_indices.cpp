#include "read/name_indices.hpp"

#include <charconv>

#include "base/text.hpp"

namespace bgsim {

std::string index_text(const IndexValues& indices) {
  std::string text;
  for (std::size_t d = 0; d < kMostIndices; ++d)
    if (indices.used[d]) text += "[" + std::to_string(indices.value[d]) + "]";
  return text;
}

std::int64_t IndexSum::at(const IndexValues& indices) const {
  std::int64_t sum = constant;
  for (std::size_t d = 0; d < kMostIndices; ++d) sum += factor[d] * indices.value[d];
  return sum;
}

std::optional<IndexSum> read_index(std::string_view text) {
  constexpr std::size_t kMostDigits = 9, kMostTerms = 20;  // no sum of products overflows
  IndexSum sum;
  std::size_t at = 0;
  const auto skip = [&] {
    while (at < text.size() && text[at] == ' ') ++at;
  };
  const auto number = [&]() -> std::optional<std::int64_t> {
    const std::size_t begin = at;
    while (at < text.size() && is_digit(text[at])) ++at;
    if (at == begin || at - begin > kMostDigits) return std::nullopt;
    std::int64_t value = 0;
    std::from_chars(text.data() + begin, text.data() + at, value);
    return value;
  };
  const auto variable = [&]() -> std::optional<std::size_t> {
    const std::size_t which = at < text.size() ? kIndexNames.find(text[at]) : std::string_view::npos;
    if (which == std::string_view::npos) return std::nullopt;
    ++at;
    return which;
  };
  std::int64_t sign = 1;
  skip();
  for (std::size_t term = 0; term < kMostTerms; ++term) {
    if (at < text.size() && is_digit(text[at])) {
      const auto value = number();
      if (!value) return std::nullopt;
      skip();
      if (at < text.size() && text[at] == '*') {
        ++at;
        skip();
        const auto which = variable();
        if (!which) return std::nullopt;
        sum.factor[*which] += sign * *value;
      } else {
        sum.constant += sign * *value;
      }
    } else {
      const auto which = variable();
      if (!which) return std::nullopt;
      sum.factor[*which] += sign;
    }
    skip();
    if (at == text.size()) return sum;
    if (text[at] != '+' && text[at] != '-') return std::nullopt;
    sign = text[at] == '+' ? 1 : -1;
    ++at;
    skip();
  }
  return std::nullopt;
}

std::vector<WrittenIndex> indices_in(std::string_view name) {
  std::vector<WrittenIndex> found;
  for (std::size_t open = name.find('['); open != std::string_view::npos; open = name.find('[', open + 1)) {
    const std::size_t close = name.find(']', open);
    if (close == std::string_view::npos) break;
    const bool further = !found.empty() && found.back().begin + found.back().text.size() + 1 == open;
    found.push_back({further ? found.back().base : name.substr(0, open), further ? found.back().dimension + 1 : 0,
                     name.substr(open + 1, close - open - 1), open + 1});
    open = close;
  }
  return found;
}

std::optional<std::string> indices_put_in(std::string_view name, const IndexValues& indices) {
  std::string text;
  std::size_t copied = 0;
  for (const WrittenIndex& index : indices_in(name)) {
    const auto sum = read_index(index.text);
    if (!sum) return std::nullopt;
    for (std::size_t d = 0; d < kMostIndices; ++d)
      if (sum->uses(d) && !indices.used[d]) return std::nullopt;
    text.append(name.substr(copied, index.begin - copied));
    text += std::to_string(sum->at(indices));
    copied = index.begin + index.text.size();
  }
  text.append(name.substr(copied));
  return text;
}

}  // namespace bgsim
