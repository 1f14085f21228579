/// Indices of sensitivity from a sweep's records: as a table for people, as CSV, and as a picture.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "bgsim/indices.hpp"
#include "sweep_picture.hpp"

namespace bgsim::cli {

/// The indices of each result, for a sweep whose sample is made for them.
class SweepIndices {
 public:
  /// Whether the sweep is sampled so that there are any.
  static bool has(const nlohmann::ordered_json& identity);
  SweepIndices(const nlohmann::ordered_json& identity, const SweepTable& table);

  [[nodiscard]] std::string table() const;
  [[nodiscard]] std::string csv() const;
  /// @throws UsageError if gnuplot is missing or fails.
  [[nodiscard]] std::string svg() const;
  /// What is not to be believed, each with its result's name.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  void note_missing(const std::string& result, std::uint64_t present, const std::string& what);

  std::string title_;
  bool variance_ = false;  ///< of the sample of Saltelli, not of Morris
  std::uint64_t samples_ = 0;
  std::vector<std::string> quantities_, results_;
  std::vector<VarianceShares> shares_;                  ///< by result
  std::vector<std::vector<ElementaryEffect>> effects_;  ///< by result
  std::vector<std::string> notes_;
};

}  // namespace bgsim::cli
