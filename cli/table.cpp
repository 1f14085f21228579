#include "table.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "bgsim/text.hpp"

namespace bgsim::cli {

void TextTable::add(std::vector<std::string> row) {
  for (std::size_t c = 0; c < row.size(); ++c) row[c] = c + 1 < row.size() ? short_name(row[c]) : visible_line(row[c]);
  rows_.push_back(std::move(row));
}

std::string TextTable::text() const {
  std::vector<std::size_t> width(rows_.front().size(), 0);
  for (const auto& row : rows_)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], character_count(row[c]));
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c)
      line += row[c] + (c + 1 < row.size() ? std::string(width[c] - character_count(row[c]) + 2, ' ') : "");
    text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return text;
}

std::string percent_text(double share) { return number_text(100.0 * share, 3) + " %"; }

}  // namespace bgsim::cli
