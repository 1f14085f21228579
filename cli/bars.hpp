/// Pictures of bars that lie, one row for each quantity (gnuplot).
#pragma once

#include <string>
#include <vector>

namespace bgsim::cli {

/// A bar of a row. Those of colour 1 are thin and lie upon the others.
struct Bar {
  double from = 0.0, to = 0.0;
  double within = 0.0;  ///< a whisker at its end; 0: none
  int colour = 0;       ///< of kBarColours
};

struct BarRow {
  std::string label;
  std::vector<Bar> bars;
};

struct BarPanel {
  std::string title;
  std::vector<BarRow> rows;         ///< from above
  std::vector<std::string> legend;  ///< by colour
};

/// Panels below each other. @throws UsageError if gnuplot is missing or fails.
std::string bars_svg(const std::string& title, const std::vector<BarPanel>& panels);

}  // namespace bgsim::cli
