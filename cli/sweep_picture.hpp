/// A sweep's records as numbers, and as a picture (gnuplot).
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace bgsim::cli {

/// The columns of the completed runs.
struct SweepTable {
  std::vector<std::uint64_t> runs;
  std::vector<std::string> names;            ///< varied quantities, then results
  std::vector<std::vector<double>> columns;  ///< by name; NaN: no value
  std::uint64_t failed = 0, noted = 0;
  std::vector<std::pair<std::string, std::uint64_t>>
      messages;  ///< the most frequent of failures and notes, and how often

  /// @throws std::out_of_range
  [[nodiscard]] const std::vector<double>& column(const std::string& name) const;
};
SweepTable sweep_table(const nlohmann::ordered_json& identity, const std::map<std::uint64_t, std::string>& records);

/// One quantity that is varied: each result over it. A grid of two: each result as colours over both. Else each result
/// over each quantity.
std::string sweep_svg(const nlohmann::ordered_json& identity, const SweepTable& table);

}  // namespace bgsim::cli
