#include <algorithm>
#include <cctype>

#include "bgsim/diagnostic.hpp"

namespace bgsim {

namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

/// Edits that make one name of the other: insert, delete, replace, or swap neighbours; capitals cost half an edit.
/// Counted in halves; more than @p limit counts as limit + 1.
std::size_t edits(const std::string& from, const std::string& to, std::size_t limit) {
  const std::size_t longer = std::max(from.size(), to.size()), shorter = std::min(from.size(), to.size());
  if (2 * (longer - shorter) > limit) return limit + 1;
  std::vector<std::size_t> before(to.size() + 1), above(to.size() + 1), row(to.size() + 1);
  for (std::size_t j = 0; j <= to.size(); ++j) above[j] = 2 * j;
  for (std::size_t i = 1; i <= from.size(); ++i) {
    row[0] = 2 * i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const char x = from[i - 1], y = to[j - 1];
      const std::size_t replace = x == y ? 0 : lower(x) == lower(y) ? 1 : 2;
      row[j] = std::min({above[j] + 2, row[j - 1] + 2, above[j - 1] + replace});
      if (i > 1 && j > 1 && x == to[j - 2] && from[i - 2] == y) row[j] = std::min(row[j], before[j - 2] + 2);
    }
    if (*std::min_element(row.begin(), row.end()) > limit) return limit + 1;
    before.swap(above);
    above.swap(row);
  }
  return above.back();
}

}  // namespace

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
  // A third of the letters may be wrong, two letters at most; of a name of one or two letters only the case.
  std::size_t limit = name.size() < 3 ? 1 : name.size() < 6 ? 2 : 4;
  const std::string* nearest = nullptr;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edits(name, candidate, limit);
    if (distance > limit) continue;
    nearest = &candidate;
    if (distance == 0) break;
    limit = distance - 1;  // the first of equally near ones stays
  }
  return nearest == nullptr ? std::string() : *nearest;
}

}  // namespace bgsim
