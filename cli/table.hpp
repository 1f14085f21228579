/// Tables of words and numbers for people to read.
#pragma once

#include <string>
#include <vector>

namespace bgsim::cli {

/// Columns as wide as their widest entry, two spaces between them, the last one free. Entries may be any names: they
/// are made visible, and short but in the last column.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> heads) : rows_{std::move(heads)} {}
  void add(std::vector<std::string> row);
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

std::string percent_text(double share);  ///< "12.3 %"

}  // namespace bgsim::cli
