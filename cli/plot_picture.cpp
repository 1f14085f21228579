#include "plot_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <sstream>

#include "bgsim/text.hpp"
#include "gnuplot.hpp"
#include "thinning.hpp"

namespace bgsim::cli {

namespace {

constexpr std::size_t kBuckets = 1000;  // about the pixels of a panel's width
constexpr double kWidth = 860.0, kPanelHeight = 230.0, kLowHeight = 150.0;
constexpr double kLaneHeight = 25.0, kLanesHead = 26.0, kLanesFoot = 12.0;
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
  double lanes = 0.0;        ///< height of the lanes under them; 0 without
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
  if (!plot.lanes.empty()) grid.lanes = kLanesHead + kLanesFoot + kLaneHeight * static_cast<double>(plot.lanes.size());
  grid.height = at + grid.lanes + 42.0;  // numbers and label of the abscissa
  return grid;
}

void add_panel(std::ostringstream& script, const Plot& plot, const Grid& grid, std::size_t index) {
  const PlotPanel& panel = plot.panels[index];
  const std::size_t row = index / grid.columns, column = index % grid.columns;
  const bool lowest = index + grid.columns >= plot.panels.size() && grid.lanes == 0.0;
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

/// 0xrrggbb of each kind of lane, from the same colours.
std::uint32_t lane_colour(Lane::Kind kind) {
  switch (kind) {
    case Lane::Kind::switching:
      return 0x0072b2;
    case Lane::Kind::diode:
      return 0xd55e00;
    case Lane::Kind::contact:
      return 0x009e73;
    case Lane::Kind::latch:
      return 0xcc79a7;
    case Lane::Kind::friction:
      return 0xe69f00;
    case Lane::Kind::marks:
      return 0x555555;
  }
  return 0;
}

constexpr std::uint32_t kTrack = 0xebebeb, kMark = 0x222222;

/// Between the track, which is off, and the full colour; where both sides are merged never like one of them.
std::uint32_t shade(std::uint32_t colour, double share) {
  const double part = share == 1.0 ? 1.0 : 0.25 + 0.45 * share;
  std::uint32_t mixed = 0;
  for (const int shift : {16, 8, 0}) {
    const double full = (colour >> shift) & 0xffU, none = (kTrack >> shift) & 0xffU;
    mixed |= static_cast<std::uint32_t>(std::lround(none + part * (full - none))) << shift;
  }
  return mixed;
}

/// Boxes of one lane: middle, left and right, below and above, colour. @return whether sides are merged somewhere.
bool add_lane(std::ostringstream& script, const Lane& whole, double row, double x_low, double x_high, double pixels) {
  const double pixel = (x_high - x_low) / pixels, bottom = row + 0.05, top = row + 0.41;
  const Lane lane = merged(whole, x_low, x_high, static_cast<std::size_t>(pixels));
  const std::uint32_t colour = lane_colour(lane.kind);
  const auto box = [&](double left, double right, double high, std::uint32_t rgb) {
    script << number_text(0.5 * (left + right), 12) << ' ' << number_text(0.5 * (bottom + high), 9) << ' '
           << number_text(left, 12) << ' ' << number_text(right, 12) << ' ' << number_text(bottom, 9) << ' '
           << number_text(high, 9) << ' ' << rgb << '\n';
  };
  bool paler = false;
  if (!lane.from.empty()) box(lane.from.front(), x_high, top, kTrack);
  for (std::size_t i = 0; i < lane.from.size(); ++i) {
    if (lane.share[i] == 0.0) continue;
    paler = paler || lane.share[i] < 1.0;
    box(lane.from[i], i + 1 < lane.from.size() ? lane.from[i + 1] : x_high, top, shade(colour, lane.share[i]));
  }
  // Marks that cannot be told apart are one paler bar.
  const double near = 3.0 * pixel, half = 0.7 * pixel, high = lane.kind == Lane::Kind::marks ? top : row + 0.46;
  for (std::size_t i = 0; i < lane.marks.size();) {
    std::size_t last = i;
    while (last + 1 < lane.marks.size() && lane.marks[last + 1] - lane.marks[last] < near) ++last;
    paler = paler || last > i;
    box(std::max(x_low, lane.marks[i] - half), std::min(x_high, lane.marks[last] + half), high,
        last > i ? shade(kMark, 0.5) : kMark);
    i = last + 1;
  }
  return paler;
}

/// Under a column of panels, from which the abscissa's range comes.
void add_lanes(std::ostringstream& script, const Plot& plot, const Grid& grid, std::size_t column, bool paler) {
  const double span = 1.0 / static_cast<double>(grid.columns), left = static_cast<double>(column) * span;
  const auto screen = [&](double y) { return fixed_number(1.0 - y / grid.height, 5); };
  const double top = grid.tops.back() + kLanesHead, count = static_cast<double>(plot.lanes.size());
  std::string head = plot.lanes_left_out;
  if (paler) head += std::string(head.empty() ? "" : "; ") + "paler: changes too fast to be drawn one by one";
  script << "unset key\nunset ytics\nset border 1\nset grid noytics\nunset logscale y\n"
         << "set lmargin at screen " << fixed_number(left + 86.0 / grid.width, 5) << "\nset rmargin at screen "
         << fixed_number(left + span - 30.0 / grid.width, 5) << "\nset tmargin at screen " << screen(top)
         << "\nset bmargin at screen " << screen(top + kLaneHeight * count) << "\nset label 2 "
         << gnuplot_string("modes") << " at graph 0, graph 1 right offset character -1, character 0.9\n"
         << "set label 3 " << gnuplot_string(head) << " at graph 1, graph 1 right offset character 0, character 0.9"
         << " font ',10' textcolor rgb '#555555'\n"
         << "set xlabel " << gnuplot_string(plot.x_label) << "\nset format x '%g'\nset yrange [0:" << plot.lanes.size()
         << "]\n";
  for (std::size_t i = 0; i < plot.lanes.size(); ++i)
    script << "set label " << i + 4 << ' ' << gnuplot_string(lane_text(plot.lanes[i])) << " at graph 0, first "
           << fixed_number(count - static_cast<double>(i) - 0.29, 3)
           << " left offset character 0.3, 0 font ',10' textcolor rgb '#333333' front\n";
  script << "plot $lanes using 1:2:3:4:5:6:7 with boxxyerror fs solid 1.0 noborder lc rgb variable notitle\n";
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
  bool paler = false;
  if (!plot.lanes.empty()) script << "$lanes << EOD\n";
  const double pixels = grid.width / static_cast<double>(grid.columns) - 116.0;
  for (std::size_t i = 0; i < plot.lanes.size(); ++i)
    paler =
        add_lane(script, plot.lanes[i], static_cast<double>(plot.lanes.size() - 1 - i), x_low, x_high, pixels) || paler;
  if (!plot.lanes.empty()) script << "EOD\n";
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
  if (!plot.lanes.empty())
    for (std::size_t column = 0; column < grid.columns; ++column) add_lanes(script, plot, grid, column, paler);
  script << "unset multiplot\n";
  return svg_from_gnuplot(script.str());
}

}  // namespace bgsim::cli
