#include "plot_picture.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

#include "bgsim/text.hpp"
#include "gnuplot.hpp"
#include "thinning.hpp"

namespace bgsim::cli {

namespace {

constexpr std::size_t kBuckets = 1000;  // about the pixels of a panel's width
constexpr double kWidth = 860.0, kPanelHeight = 230.0, kLowHeight = 150.0;
// Okabe and Ito's colours, which the colour-blind can tell apart.
constexpr std::array<const char*, 7> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                              "#e69f00", "#56b4e9", "#555555"};

/// A length or a share on the page, which wants no exponent.
std::string fixed_number(double value, int decimals) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

void add_data(std::ostringstream& script, const std::string& block, const PlotCurve& curve) {
  script << "$" << block << " << EOD\n";
  for (const std::size_t i : thinned(curve.x, curve.y, kBuckets))
    script << number_text(curve.x[i], 12) << ' ' << number_text(curve.y[i], 9) << '\n';
  script << "EOD\n";
}

/// Both edges keep their extremes.
void add_band(std::ostringstream& script, const std::string& block, const PlotCurve& curve) {
  std::vector<std::size_t> kept = thinned(curve.x, curve.low, kBuckets);
  const std::vector<std::size_t> upper = thinned(curve.x, curve.high, kBuckets);
  kept.insert(kept.end(), upper.begin(), upper.end());
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  script << "$" << block << " << EOD\n";
  for (const std::size_t i : kept)
    script << number_text(curve.x[i], 12) << ' ' << number_text(curve.low[i], 9) << ' ' << number_text(curve.high[i], 9)
           << '\n';
  script << "EOD\n";
}

/// Where panels stand: heights, and how many side by side.
struct Grid {
  std::size_t columns = 1, rows = 1;
  double width = kWidth, height = 0.0;
  std::vector<double> tops;  ///< of rows, from above, and the end of the last
};

Grid grid_of(const Plot& plot) {
  Grid grid;
  const std::size_t count = plot.panels.size();
  grid.columns = (count + kMostStacked - 1) / kMostStacked;
  grid.rows = (count + grid.columns - 1) / grid.columns;
  grid.width = kWidth * (grid.columns == 1 ? 1.0 : 0.7 * static_cast<double>(grid.columns));
  double at = 34.0;  // the title
  for (std::size_t row = 0; row < grid.rows; ++row) {
    grid.tops.push_back(at);
    bool low = true;
    for (std::size_t column = 0; column < grid.columns; ++column) {
      const std::size_t panel = row * grid.columns + column;
      low = low && (panel >= count || plot.panels[panel].low);
    }
    at += low ? kLowHeight : kPanelHeight;
  }
  grid.tops.push_back(at);
  grid.height = at + 42.0;  // numbers and label of the abscissa
  return grid;
}

void add_panel(std::ostringstream& script, const Plot& plot, const Grid& grid, std::size_t index) {
  const PlotPanel& panel = plot.panels[index];
  const std::size_t row = index / grid.columns, column = index % grid.columns;
  const bool lowest = index + grid.columns >= plot.panels.size();
  const double span = 1.0 / static_cast<double>(grid.columns), left = static_cast<double>(column) * span;
  const auto screen = [&](double y) { return fixed_number(1.0 - y / grid.height, 5); };
  script << "set lmargin at screen " << fixed_number(left + 86.0 / grid.width, 5) << "\nset rmargin at screen "
         << fixed_number(left + span - 30.0 / grid.width, 5) << "\nset tmargin at screen "
         << screen(grid.tops[row] + 26.0) << "\nset bmargin at screen " << screen(grid.tops[row + 1] - 12.0) << "\n"
         << "set label 2 " << gnuplot_string(panel.unit)
         << " at graph 0, graph 1 right offset character -1, character 0.9\n"
         << (lowest ? "set xlabel " + gnuplot_string(plot.x_label) + "\nset format x '%g'\n"
                    : std::string("unset xlabel\nset format x ''\n"))
         << (panel.range ? "set yrange [" + number_text(panel.range->first, 12) + ":" +
                               number_text(panel.range->second, 12) + "]\n"
                         : std::string("set yrange [*:*]\n"))
         << (panel.log_y  ? "set logscale y\nset format y '%g'\n"
             : plot.log_x ? "unset logscale y\n"
                          : "")
         << "plot ";
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const PlotCurve& curve = panel.curves[i];
    if (!curve.low.empty())
      script << (i == 0 ? "" : ", ") << "$b" << index << "_" << i
             << " with filledcurves fs transparent solid 0.25 lc rgb '" << kColours[i % kColours.size()] << "' notitle";
    script << (i == 0 && curve.low.empty() ? "" : ", ") << "$d" << index << "_" << i << " with "
           << (curve.x.size() == 1 ? "points pt 7" : "lines") << " lc rgb '"
           << (curve.colour.empty() ? kColours[i % kColours.size()] : curve.colour.c_str())
           << (curve.reference ? "' lw 1.2 dashtype 2" : "' lw 1.7")
           << (curve.named ? " title " + gnuplot_string(curve.name) : std::string(" notitle"));
  }
  script << "\n";
}

}  // namespace

std::string plot_svg(const Plot& plot) {
  const Grid grid = grid_of(plot);
  std::ostringstream script;
  script << "set terminal svg size " << fixed_number(grid.width, 0) << "," << fixed_number(grid.height, 0)
         << " dynamic noenhanced font 'Helvetica,12' background '#ffffff'\n";
  double x_low = plot.panels.front().curves.front().x.front(), x_high = x_low;
  for (std::size_t p = 0; p < plot.panels.size(); ++p)
    for (std::size_t c = 0; c < plot.panels[p].curves.size(); ++c) {
      const PlotCurve& curve = plot.panels[p].curves[c];
      add_data(script, "d" + std::to_string(p) + "_" + std::to_string(c), curve);
      if (!curve.low.empty()) add_band(script, "b" + std::to_string(p) + "_" + std::to_string(c), curve);
      const auto [low, high] = std::minmax_element(curve.x.begin(), curve.x.end());
      x_low = std::min(x_low, *low);
      x_high = std::max(x_high, *high);
    }
  script << "set border 3 lc rgb '#777777'\nset tics nomirror textcolor rgb '#333333'\nset grid lc rgb '#e2e2e2' lt 1\n"
            "set key at graph 0, graph 1.01 left bottom horizontal Left reverse samplen 2 maxrows 1\n";
  if (x_low < x_high) script << "set xrange [" << number_text(x_low, 12) << ":" << number_text(x_high, 12) << "]\n";
  if (plot.log_x) script << "set logscale x\n";
  script << "set multiplot\nset label 1 " << gnuplot_string(plot.title) << " at screen "
         << fixed_number(14.0 / grid.width, 5) << "," << fixed_number(1.0 - 17.0 / grid.height, 5) << " font ',13'\n";
  for (std::size_t p = 0; p < plot.panels.size(); ++p) {
    add_panel(script, plot, grid, p);
    if (p == 0) script << "unset label 1\n";
  }
  script << "unset multiplot\n";
  return svg_from_gnuplot(script.str());
}

}  // namespace bgsim::cli
