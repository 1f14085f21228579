#include "bars.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "bgsim/text.hpp"
#include "gnuplot.hpp"

namespace bgsim::cli {

namespace {

constexpr std::array kBarColours{"#9db8dd", "#1f4e9c", "#e08214"};

std::string bar_number(double value) { return number_text(value, 9); }

std::string picture_head(const std::string& title, int width, int height, std::size_t panels) {
  std::ostringstream text;
  text << "set terminal svg size " << width << "," << height
       << " dynamic noenhanced font 'Helvetica,12' background '#ffffff'\nset encoding utf8\nset grid x lc rgb "
          "'#dddddd' lt "
          "1\nset format '%g'\nset multiplot layout "
       << panels << ",1 title " << gnuplot_string(title) << "\n";
  return text.str();
}

/// The bars of one colour as rows of numbers: value, place, from, to, lower, upper edge, whisker, its place.
std::string bars_of(const BarPanel& panel, int colour) {
  std::ostringstream text;
  const double half = colour == 1 ? 0.18 : 0.36;
  for (std::size_t r = 0; r < panel.rows.size(); ++r) {
    const auto place = static_cast<double>(panel.rows.size() - r);
    for (const Bar& bar : panel.rows[r].bars)
      if (bar.colour == colour && std::isfinite(bar.from) && std::isfinite(bar.to))
        text << bar_number(bar.to) << ' ' << bar_number(place) << ' ' << bar_number(std::min(bar.from, bar.to)) << ' '
             << bar_number(std::max(bar.from, bar.to)) << ' ' << bar_number(place - half) << ' '
             << bar_number(place + half) << ' '
             << (bar.within > 0.0 && std::isfinite(bar.within) ? bar_number(bar.within) : "NaN") << ' '
             << bar_number(colour == 0 ? place + 0.27 : place) << '\n';
  }
  return text.str();
}

}  // namespace

std::string bars_svg(const std::string& title, const std::vector<BarPanel>& panels) {
  std::size_t rows = 1, letters = 4;
  for (const BarPanel& panel : panels) {
    rows = std::max(rows, panel.rows.size());
    for (const BarRow& row : panel.rows) letters = std::max(letters, character_count(short_name(row.label)));
  }
  const int high = 100 + 28 * static_cast<int>(rows);
  std::ostringstream text;
  for (std::size_t p = 0; p < panels.size(); ++p)
    for (std::size_t c = 0; c < kBarColours.size(); ++c)
      text << "$p" << p << "_" << c << " << EOD\n" << bars_of(panels[p], static_cast<int>(c)) << "EOD\n";
  text << picture_head(title, 900, 40 + high * static_cast<int>(panels.size()), panels.size()) << "set lmargin "
       << letters + 3 << "\nset rmargin 4\nset key outside below center horizontal\nset xzeroaxis\n";
  text << "set style fill solid 1.0 noborder\nset arrow 1 from first 0, graph 0 to first 0, graph 1 nohead lc rgb "
          "'#555555' "
          "front\n";
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const BarPanel& panel = panels[p];
    text << "set title " << gnuplot_string(panel.title) << "\nset yrange [0.4:" << panel.rows.size()
         << ".6]\nset ytics (";
    for (std::size_t r = 0; r < panel.rows.size(); ++r)
      text << (r > 0 ? ", " : "") << gnuplot_string(panel.rows[r].label) << " " << panel.rows.size() - r;
    text << ") scale 0\nplot ";
    bool first = true;
    for (std::size_t c = 0; c < kBarColours.size(); ++c) {
      const std::string data = bars_of(panel, static_cast<int>(c));
      if (data.empty()) continue;
      text << (first ? "" : ", ") << "$p" << p << "_" << c << " using 1:2:3:4:5:6 with boxxyerror lc rgb '"
           << kBarColours.at(c) << "' title " << gnuplot_string(c < panel.legend.size() ? panel.legend[c] : "")
           << ", $p" << p << "_" << c << " using 1:8:7 with xerrorbars pt -1 lc rgb '#222222' notitle";
      first = false;
    }
    if (first) text << "[0:1] 100 notitle";  // beyond the rows: an empty panel
    text << "\n";
  }
  text << "unset multiplot\n";
  return svg_from_gnuplot(text.str());
}

}  // namespace bgsim::cli
