#include "sweep_picture.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "gnuplot.hpp"

namespace bgsim::cli {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double number(std::string_view text) {
  double value = kNone;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::vector<std::string> varied(const Json& identity) {
  std::vector<std::string> names;
  for (const auto& [name, values] : identity["vary"].items()) names.push_back(name);
  return names;
}

/// A record that bgsim has written: only the last field can be in quotes.
std::vector<std::string_view> fields_of(std::string_view record, std::size_t count) {
  std::vector<std::string_view> fields;
  while (fields.size() + 1 < count) {
    const auto comma = record.find(',');
    fields.push_back(record.substr(0, comma));
    record.remove_prefix(comma == std::string_view::npos ? record.size() : comma + 1);
  }
  while (record.ends_with('\n') || record.ends_with('\r')) record.remove_suffix(1);
  fields.push_back(record);
  return fields;
}

/// What stands in a field of a record.
std::string unquoted(std::string_view field) {
  if (!field.starts_with('"') || field.size() < 2) return std::string(field);
  std::string text;
  for (std::size_t i = 1; i + 1 < field.size(); ++i) {
    text += field[i];
    if (field[i] == '"') ++i;
  }
  return text;
}

/// A panel's points, those without a value left out.
void add_block(std::ostringstream& text, const std::string& name,
               const std::vector<const std::vector<double>*>& columns) {
  text << "$" << name << " << EOD\n";
  std::vector<std::size_t> order(columns.front()->size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return (*columns.front())[a] < (*columns.front())[b]; });
  for (const std::size_t i : order) {
    if (std::any_of(columns.begin(), columns.end(), [&](const auto* c) { return !std::isfinite((*c)[i]); })) continue;
    for (const auto* column : columns) text << number_text((*column)[i], 9) << ' ';
    text << '\n';
  }
  text << "EOD\n";
}

/// Where the cell of each value ends on both sides: halfway to the values beside it.
std::map<double, std::pair<double, double>> cells_of(const std::vector<double>& values, bool logarithmic) {
  const auto scaled = [&](double value) { return logarithmic ? std::log(value) : value; };
  const auto unscaled = [&](double value) { return logarithmic ? std::exp(value) : value; };
  const std::set<double> distinct(values.begin(), values.end());
  std::map<double, std::pair<double, double>> cells;
  for (auto it = distinct.begin(); it != distinct.end(); ++it) {
    const double own = scaled(*it);
    const double below = it == distinct.begin() ? 2.0 * own - scaled(*std::next(it)) : scaled(*std::prev(it));
    const double above = std::next(it) == distinct.end() ? 2.0 * own - scaled(*std::prev(it)) : scaled(*std::next(it));
    cells[*it] = {unscaled(0.5 * (below + own)), unscaled(0.5 * (own + above))};
  }
  return cells;
}

/// A map's cells, one for each run that has a value: x, y, borders of x and y, value.
void add_cells(std::ostringstream& text, const std::string& name, const std::vector<double>& x,
               const std::vector<double>& y, const std::vector<double>& values, std::array<bool, 2> logarithmic) {
  const auto across = cells_of(x, logarithmic[0]), up = cells_of(y, logarithmic[1]);
  text << "$" << name << " << EOD\n";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const auto [left, right] = across.at(x[i]);
    const auto [bottom, top] = up.at(y[i]);
    for (const double number : {x[i], y[i], left, right, bottom, top, values[i]}) text << number_text(number, 9) << ' ';
    text << '\n';
  }
  text << "EOD\n";
}

/// Distance of marks on an axis: 1, 2 or 5 times a power of ten, with some @p count marks.
std::string marks(const std::vector<double>& values, int count) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const double value : values)
    if (std::isfinite(value)) {
      least = std::min(least, value);
      most = std::max(most, value);
    }
  const double raw = (most - least) / count;
  if (!(raw > 0.0) || !std::isfinite(raw)) return "autofreq";
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double digit = raw / power < 1.5 ? 1.0 : raw / power < 3.5 ? 2.0 : raw / power < 7.5 ? 5.0 : 10.0;
  return number_text(digit * power, 6);
}

/// Marks at the values themselves where they are few; else empty.
std::string marks_at(const std::vector<double>& values) {
  constexpr std::size_t kFew = 9;
  constexpr int kDigits = 3;
  const std::set<double> distinct(values.begin(), values.end());
  if (distinct.size() > kFew) return {};
  std::string text;
  for (const double value : distinct)
    text += (text.empty() ? "(" : ", ") + gnuplot_string(number_text(value, kDigits)) + " " + number_text(value, 17);
  return text + ")";
}

bool is_logarithmic(const Json& identity, const std::string& name) {
  const auto text = identity["vary"][name].get<std::string>();
  return text.starts_with("log");
}

}  // namespace

const std::vector<double>& SweepTable::column(const std::string& name) const {
  // Results stand behind the varied quantities and may have the name of one.
  const auto found = std::find(names.rbegin(), names.rend(), name);
  if (found == names.rend()) throw std::out_of_range("a sweep has no column " + name);
  return columns[static_cast<std::size_t>(names.rend() - found) - 1];
}

SweepTable sweep_table(const Json& identity, const std::map<std::uint64_t, std::string>& records) {
  SweepTable table;
  table.names = varied(identity);
  for (const auto& name : identity["results"]) table.names.push_back(name.get<std::string>());
  table.columns.resize(table.names.size());
  std::map<std::string, std::uint64_t> messages;
  const std::size_t count = table.names.size() + 4;
  for (const auto& [run, record] : records) {
    const auto fields = fields_of(record, count);
    const bool completed = fields[count - 3] == "completed";
    if (completed && fields[count - 2] != "0") ++table.noted;
    if (!fields[count - 1].empty()) ++messages[(completed ? "note: " : "") + unquoted(fields[count - 1])];
    if (!completed) {
      ++table.failed;
      continue;
    }
    table.runs.push_back(run);
    for (std::size_t i = 0; i < table.columns.size(); ++i) table.columns[i].push_back(number(fields[i + 1]));
  }
  constexpr std::size_t kShown = 5;
  table.messages.assign(messages.begin(), messages.end());
  std::stable_sort(table.messages.begin(), table.messages.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  if (table.messages.size() > kShown) table.messages.resize(kShown);
  return table;
}

std::string sweep_svg(const Json& identity, const SweepTable& table) {
  const std::vector<std::string> quantities = varied(identity);
  constexpr std::size_t kMostQuantities = 6, kMostResults = 8;
  const std::size_t inputs = std::min(quantities.size(), kMostQuantities);
  const std::size_t results = std::min(table.names.size() - quantities.size(), kMostResults);
  if (table.runs.empty()) throw UsageError("no run was completed: there is nothing to draw");
  const bool grid = identity["sampling"] == "grid";
  const bool map = grid && quantities.size() == 2 &&
                   std::set(table.columns[0].begin(), table.columns[0].end()).size() > 1 &&
                   std::set(table.columns[1].begin(), table.columns[1].end()).size() > 1;
  const std::size_t panels_across = map ? std::min<std::size_t>(results, 2) : inputs;
  const std::size_t panels_down = map ? (results + panels_across - 1) / panels_across : results;
  std::ostringstream text;
  for (std::size_t r = 0; r < results; ++r)
    for (std::size_t q = 0; q < (map ? 1 : inputs); ++q) {
      const std::string name = "p" + std::to_string(r) + "_" + std::to_string(q);
      const std::vector<double>& values = table.columns[quantities.size() + r];
      if (map)
        add_cells(text, name, table.columns[0], table.columns[1], values,
                  {is_logarithmic(identity, quantities[0]), is_logarithmic(identity, quantities[1])});
      else
        add_block(text, name, {&table.columns[q], &values});
    }
  constexpr int kWide = 900, kMapWide = 480, kPanelWide = 300, kPanelHigh = 230;
  const int across = static_cast<int>(panels_across), down = static_cast<int>(panels_down);
  const int width = across == 1 ? (map ? kMapWide + 120 : kWide) : across * (map ? kMapWide : kPanelWide);
  const int height = (across == 1 && down == 1 ? 420 : down * (map ? 380 : kPanelHigh)) + 40;
  text << "set terminal svg size " << width << "," << height
       << " dynamic noenhanced font 'Helvetica,12' background '#ffffff'\nset encoding utf8\nunset key\nset lmargin 10\n"
          "set grid lc rgb '#dddddd' lt 1\nset format '%g'\nset autoscale xfix\nset multiplot layout "
       << down << "," << across << " title "
       << gnuplot_string(identity["model"].get<std::string>() + ", scene " + identity["scene"].get<std::string>() +
                         ", " + std::to_string(table.runs.size()) + " runs")
       << "\n";
  for (std::size_t r = 0; r < results; ++r)
    for (std::size_t q = 0; q < (map ? 1 : inputs); ++q) {
      const std::string& result = table.names[quantities.size() + r];
      const std::string block = "$p" + std::to_string(r) + "_" + std::to_string(q);
      const std::vector<double>& values = table.columns[quantities.size() + r];
      if (std::none_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); })) {
        text << "unset logscale\nset title " << gnuplot_string(short_name(result) + ": no value in any run")
             << "\nunset tics\nplot [0:1] [0:1] 2 notitle\nset tics\nunset title\n";
        continue;
      }
      text << "unset logscale\nset autoscale\nset autoscale xfix\n";
      if (is_logarithmic(identity, quantities[q]))
        text << "set logscale x\nset xtics autofreq\n";
      else
        text << "set xtics " << marks(table.columns[q], panels_across == 1 ? 10 : 4) << "\n";
      text << "set xlabel " << gnuplot_string(quantities[q]) << "\n";
      if (map) {
        if (const std::string few = marks_at(table.columns[0]); !few.empty()) text << "set xtics " << few << '\n';
        const std::string few = marks_at(table.columns[1]);
        text << "set ytics " << (few.empty() ? "autofreq" : few) << '\n';
        if (is_logarithmic(identity, quantities[1])) text << "set logscale y\n";
        text
            << "set ylabel " << gnuplot_string(quantities[1]) << "\nset title " << gnuplot_string(result)
            << "\nset palette defined (0 '#30123b', 1 '#4777ef', 2 '#1bd0d5', 3 '#62fc6b', 4 '#d2e935', 5 '#fe9b2d', 6 "
               "'#7a0403')\nset autoscale yfix\nunset grid\nset lmargin 13\nset style fill solid noborder\n";
        text << "plot " << block << " using 1:2:3:4:5:6:7 with boxxyerror fc palette\n";
        continue;
      }
      text << "set ylabel " << gnuplot_string(result) << "\nplot " << block
           << (grid && quantities.size() == 1 ? " with linespoints lw 1.6 pt 7 ps 0.5" : " with points pt 7 ps 0.35")
           << " lc rgb '#1f4e9c'\n";
    }
  text << "unset multiplot\n";
  return svg_from_gnuplot(text.str());
}

}  // namespace bgsim::cli
