/// Counts, lists and tables of names in words, as `bgsim check` prints them.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/text.hpp"

namespace bgsim {

// Lists longer than this are cut with a count; `show` lists everything.
inline constexpr std::size_t kMostLines = 60;
inline constexpr std::size_t kMostNames = 12;
inline constexpr std::size_t kWidestColumn = 44;

inline std::string plural(std::size_t count, const std::string& one, const std::string& many) {
  return count == 0 ? "no " + many : std::to_string(count) + " " + (count == 1 ? one : many);
}

using TextRow = std::pair<std::string, std::string>;

/// Rows of two columns under a heading.
inline void add_table(std::string& text, const std::string& heading, const std::vector<TextRow>& rows) {
  if (rows.empty()) return;
  text += heading + "\n";
  const std::size_t shown = std::min(rows.size(), kMostLines);
  std::size_t width = 0;
  for (std::size_t i = 0; i < shown; ++i)
    if (rows[i].first.size() <= kWidestColumn) width = std::max(width, rows[i].first.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const auto& [left, right] = rows[i];
    text += "  " + visible_line(left);
    if (!right.empty())
      text += std::string(left.size() < width ? width - left.size() : 0, ' ') + "  " + visible_line(right);
    text += "\n";
  }
  if (rows.size() > shown) text += "  ... and " + std::to_string(rows.size() - shown) + " more\n";
}

inline std::string join(const std::vector<std::string>& names, bool more = false) {
  std::string text;
  const std::size_t shown = std::min(names.size(), kMostNames);
  for (std::size_t i = 0; i < shown; ++i) {
    const bool last = i + 1 == names.size() && !more;
    text += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  if (names.size() > shown) return text + " and " + std::to_string(names.size() - shown) + " more";
  return more ? text + " and others" : text;
}

}  // namespace bgsim
