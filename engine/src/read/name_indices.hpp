/// Indices of what is repeated, as in "cell[i+1].out" and "node[i][j]".
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bgsim {

inline constexpr std::string_view kIndexNames = "ijk";
inline constexpr std::size_t kMostIndices = kIndexNames.size();

/// What i, j and k are in one copy.
struct IndexValues {
  std::array<std::int64_t, kMostIndices> value{};
  std::array<bool, kMostIndices> used{};
  [[nodiscard]] bool any() const { return used[0] || used[1] || used[2]; }
};

/// "[3][4]": those that are used.
std::string index_text(const IndexValues& indices);

/// An index as it is written: a sum of multiples of i, j, k and a whole number.
struct IndexSum {
  std::array<std::int64_t, kMostIndices> factor{};
  std::int64_t constant = 0;

  [[nodiscard]] bool uses(std::size_t index) const { return factor[index] != 0; }
  [[nodiscard]] std::int64_t at(const IndexValues& indices) const;
};

/// Reads "3", "i", "i+1", "2*i - 1", "11-i"; none for anything else, or numbers of more than nine digits.
std::optional<IndexSum> read_index(std::string_view text);

/// One bracket in a name.
struct WrittenIndex {
  std::string_view base;      ///< what is before the first bracket of these: "cell", "left.cell"
  std::size_t dimension = 0;  ///< 0 for the first bracket behind the base
  std::string_view text;      ///< inside
  std::size_t begin = 0;      ///< of the text, in the name
};

/// The brackets of a name, in their order. A bracket that does not end is not among them.
std::vector<WrittenIndex> indices_in(std::string_view name);

/// The name with numbers for its indices: "cell[3].out".
/// @return none if an index is not written as read_index() wants it, or uses one of i, j, k that has no value.
std::optional<std::string> indices_put_in(std::string_view name, const IndexValues& indices);

}  // namespace bgsim
