/// Curves over a common abscissa as a picture, by gnuplot.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lanes.hpp"

namespace bgsim::cli {

struct PlotCurve {
  std::string name;
  std::vector<double> x, y;
  bool reference = false;  ///< drawn thin and dashed over the others
  bool named = true;       ///< in the key
  std::string colour;      ///< "#rrggbb"; empty: the next one
  /// Filled beneath, in a pale shade; as long as x, or empty.
  std::vector<double> low = {}, high = {};
};

/// One diagram: curves that share an ordinate.
struct PlotPanel {
  std::string unit;  ///< or another text beside the ordinate
  std::vector<PlotCurve> curves;
  bool low = false;                                ///< of half the height: differences
  std::optional<std::pair<double, double>> range;  ///< of the ordinate; none: as far as the curves go
  bool log_y = false;                              ///< by logarithms; all values are above zero
};

struct Plot {
  std::string title, x_label;
  bool log_x = false;               ///< the abscissa by logarithms; all values are above zero
  std::vector<PlotPanel> panels;    ///< from above; more than kMostStacked stand in several columns
  std::vector<Lane> lanes = {};     ///< under each column of panels
  std::string lanes_left_out = {};  ///< what is said of others
};

inline constexpr std::size_t kMostStacked = 8;

/// @throws UsageError if gnuplot is not there or fails.
std::string plot_svg(const Plot& plot);

}  // namespace bgsim::cli
