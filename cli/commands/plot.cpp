// bgsim plot: traces as pictures, and two of them over each other.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "bands.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/diagnostic.hpp"
#include "bgsim/input_file.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "drawing.hpp"
#include "files.hpp"
#include "output_file.hpp"
#include "plot_picture.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

struct PlotArguments {
  std::string file, against, reference, output, x, title, events;
  std::vector<std::string> columns, lanes;
  std::optional<double> from, to;
  bool one_panel = false, each = false;
  double zoom = 2.0;
};

PlotArguments parse_plot(const Arguments& arguments) {
  PlotArguments options;
  CLI::App app("Draws columns of a trace, or of two traces with their difference.", "bgsim plot");
  app.footer(
      "Columns of one unit and of like size share a panel; the units are those of NAME.units.json beside NAME.csv\n"
      "(bgsim run --units writes it). Long traces are thinned out for display; every extreme stays.\n\n"
      "Examples:\n"
      "  bgsim plot actuator.bending.csv                      all columns, in actuator.bending.svg\n"
      "  bgsim plot actuator.bending.csv x_L x_R -o x.png\n"
      "  bgsim plot run.csv theta --from 1 --to 2\n"
      "  bgsim plot run.csv p --x q                           over another column\n"
      "  bgsim plot run.csv --reference reference.csv         the reference dashed over each column that it has\n"
      "  bgsim plot run.csv --against reference.csv           both, and their difference below\n"
      "  bgsim plot buck.csv --events buck.events.csv         below them which side switches and diodes are on\n"
      "  bgsim plot bellow.step.sweep x                       x of a sweep's runs: median, and between 5 and 95 %");
  app.add_option("trace.csv", options.file, "the trace; or the folder of a sweep with --traces: bands of its runs")
      ->required();
  app.add_option("columns", options.columns, "columns to draw (default: all)");
  app.add_option("-o,--output", options.output,
                 "the picture, .svg or .png; - for SVG on standard output (default: the trace's name with .svg)")
      ->type_name("FILE");
  app.add_option("--against", options.against, "another trace, drawn over the first, with the difference")
      ->type_name("CSV");
  app.add_option("--reference", options.reference, "a trace whose columns are drawn dashed over those of one name")
      ->type_name("CSV")
      ->excludes("--against");
  auto* events =
      app.add_option("--events", options.events,
                     "what bgsim run --events wrote: a lane below the curves for each switch, diode, contact and latch "
                     "that shows its side over time, with marks at events, jumps of stores and samples")
          ->type_name("CSV");
  app.add_option("--lane", options.lanes, "a lane to draw, by its name; may be given again (default: up to 30 of them)")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->needs(events);
  app.add_option("--x", options.x, "the column for the horizontal axis (default: the first)")->type_name("COLUMN");
  app.add_option("--from", options.from, "least value of the abscissa")->type_name("X");
  app.add_option("--to", options.to, "greatest value of the abscissa")->type_name("X");
  auto* one = app.add_flag("--one-panel", options.one_panel, "all columns in one panel");
  app.add_flag("--each", options.each, "each column in its own panel")->excludes(one);
  app.add_option("--title", options.title, "text above (default: the trace's name)")->type_name("TEXT");
  app.add_option("--zoom", options.zoom, "scale of a PNG (default: 2)")->type_name("X")->check(CLI::Range(0.1, 20.0));
  parse_arguments(app, arguments);
  if (options.from && options.to && !(*options.from < *options.to)) throw UsageError("--from is to be less than --to");
  return options;
}

/// A trace with what is known of its units.
struct UnitTrace {
  std::string file;
  CsvTable table;
  std::map<std::string, std::string> units;

  [[nodiscard]] std::string unit(const std::string& column) const {
    const auto found = units.find(column);
    return found == units.end() ? std::string() : found->second;
  }
  [[nodiscard]] const std::vector<double>* find(const std::string& column) const {
    const auto found = std::find(table.names.begin(), table.names.end(), column);
    return found == table.names.end() ? nullptr : &table.columns[static_cast<std::size_t>(found - table.names.begin())];
  }
  /// @throws UsageError with the nearest name.
  [[nodiscard]] const std::vector<double>& column(const std::string& name) const {
    if (const auto* values = find(name)) return *values;
    const std::string near = nearest_name(name, table.names);
    std::string list;
    for (const std::string& have : table.names) list += (list.empty() ? "" : ", ") + short_name(have);
    throw UsageError(short_path(file) + " has no column \"" + short_name(name) + "\"" +
                     (near.empty() ? "" : "; did you mean \"" + short_name(near) + "\"?") +
                     "\nit has: " + short_line(list, 2000));
  }
};

std::string read_text(const std::string& path, NamedBy by) {
  InputText file = read_input(path, by);
  if (std::error_code ignored; !fs::exists(path, ignored)) file.fault = std::strerror(ENOENT);
  if (!file.fault.empty()) throw UsageError("cannot read \"" + short_path(path) + "\": " + file.fault);
  return std::move(file.text);
}

/// Where the units of a trace are, if they are anywhere.
std::string units_of(const std::string& csv) { return fs::path(csv).replace_extension(".units.json").string(); }
constexpr const char* kUnitsRole = "it holds the units of the trace";

std::map<std::string, std::string> read_units(const std::string& csv) {
  const std::string path = units_of(csv);
  if (!fs::exists(path)) return {};
  try {
    return nlohmann::json::parse(read_text(path, NamedBy::model)).get<std::map<std::string, std::string>>();
  } catch (const nlohmann::json::parse_error& error) {
    throw UsageError(short_path(path) + ", which is taken for the units of " + short_path(csv) +
                     ", is not JSON: the error is at byte " + std::to_string(error.byte));
  } catch (const nlohmann::json::exception&) {
    throw UsageError(short_path(path) + ", which is taken for the units of " + short_path(csv) +
                     ", is no object of texts, such as { \"x\": \"m\" }");
  }
}

UnitTrace read_trace(const std::string& path) {
  const std::string text = read_text(path, NamedBy::user);
  try {
    CsvCells cells = parse_csv_cells(text);
    const std::optional<CsvError>* first = nullptr;
    for (const std::optional<CsvError>& fault : cells.faults)
      if (fault && (first == nullptr || fault->line < (*first)->line)) first = &fault;
    if (first != nullptr) throw CsvError(**first);
    UnitTrace trace{path, std::move(cells.table), read_units(path)};
    if (trace.table.columns.front().empty())
      throw UsageError(short_path(path) + " has a header and no records: nothing to draw");
    return trace;
  } catch (const CsvError& error) {
    throw UsageError(short_path(path) + ":" + std::to_string(error.line) + ": " + error.without_text);
  }
}

/// The medians of a sweep's traces; the bands beside them are @p bands.
UnitTrace medians_of(const std::string& folder, Bands& bands) {
  bands = bands_of({folder});
  if (bands.traces == 0)
    throw UsageError("\"" + short_path(folder) + "\" has no traces: bgsim sweep --traces writes them");
  if (bands.times.empty() || bands.names.empty())
    throw UsageError("the traces in \"" + short_path(folder) + "\" hold no values: nothing to draw");
  UnitTrace trace{folder, {{bands.time}, {bands.times}}, {}};
  for (std::size_t o = 0; o < bands.names.size(); ++o) {
    trace.table.names.push_back(bands.names[o]);
    trace.table.columns.push_back(bands.of[o][1]);
  }
  return trace;
}

/// The bands beneath the curves of their medians.
void add_bands(std::vector<PlotPanel>& panels, const Bands& bands, const PlotArguments& options) {
  for (PlotPanel& panel : panels) {
    panel.range.reset();
    for (PlotCurve& curve : panel.curves) {
      const auto o =
          static_cast<std::size_t>(std::find(bands.names.begin(), bands.names.end(), curve.name) - bands.names.begin());
      for (std::size_t i = 0; i < bands.times.size(); ++i) {
        if ((options.from && bands.times[i] < *options.from) || (options.to && bands.times[i] > *options.to)) continue;
        if (std::isnan(bands.of[o][1][i])) continue;
        curve.low.push_back(bands.of[o].front()[i]);
        curve.high.push_back(bands.of[o].back()[i]);
      }
      curve.name += ": median, 5 to 95 % of " + std::to_string(bands.traces) + " runs";
    }
  }
}

/// The rows of a column whose abscissa lies in the range asked for, without those that lack a value.
PlotCurve curve_of(const UnitTrace& trace, const std::string& x, const std::string& y, const PlotArguments& options) {
  const std::vector<double>&abscissa = trace.column(x), &ordinate = trace.column(y);
  PlotCurve curve{y, {}, {}, false, true, {}, {}, {}};
  bool in_range = false;
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    if ((options.from && abscissa[i] < *options.from) || (options.to && abscissa[i] > *options.to)) continue;
    in_range = true;
    if (std::isnan(abscissa[i]) || std::isnan(ordinate[i])) continue;
    curve.x.push_back(abscissa[i]);
    curve.y.push_back(ordinate[i]);
  }
  if (!in_range) throw UsageError(short_path(trace.file) + " has no record between --from and --to");
  if (curve.x.empty())
    throw UsageError("column \"" + short_name(y) + "\" of " + short_path(trace.file) + " has no value to draw");
  return curve;
}

double magnitude(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

/// A sum whose terms cancel keeps the rounding of its terms: of some thousand additions, this part of the largest.
constexpr double kRounded = 4096 * std::numeric_limits<double>::epsilon();

/// The largest magnitude of all columns of a unit; 0 for an unknown one, of which nothing can be said.
double largest_of_unit(const UnitTrace& trace, const std::string& unit) {
  double most = 0.0;
  for (std::size_t i = 0; !unit.empty() && i < trace.table.names.size(); ++i)
    if (trace.unit(trace.table.names[i]) == unit) most = std::max(most, magnitude(trace.table.columns[i]));
  return most;
}

/// A column that is no more than the rounding of others of its unit: the difference of two that are equal.
bool only_rounding(const UnitTrace& trace, const std::string& unit, const PlotCurve& curve) {
  return magnitude(curve.y) <= kRounded * largest_of_unit(trace, unit);
}

/// What is only rounding is drawn at the scale of its unit, and what is constant but for it with room around.
void choose_range(const UnitTrace& trace, PlotPanel& panel) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const PlotCurve& curve : panel.curves)
    for (const double y : curve.y)
      if (std::isfinite(y)) {
        low = std::min(low, y);
        high = std::max(high, y);
      }
  if (low > high) return;
  const double size = std::max(std::abs(low), std::abs(high)), largest = largest_of_unit(trace, panel.unit);
  if (size <= kRounded * largest) {
    if (largest > 0.0) panel.range = {-largest, largest};
  } else if (high - low <= kRounded * size) {
    panel.range = {low - 0.1 * size, high + 0.1 * size};
  }
}

/// Whether a curve can be read beside others in one panel: the same unit, and no more than ten times smaller or larger.
bool fits(const UnitTrace& trace, const PlotPanel& panel, const std::string& unit, const PlotCurve& curve) {
  constexpr std::size_t kMostCurves = 5;
  if (panel.unit != unit || panel.curves.size() >= kMostCurves) return false;
  if (only_rounding(trace, unit, curve)) return true;
  const double size = magnitude(curve.y), other = magnitude(panel.curves.front().y);
  return size <= 10.0 * other && other <= 10.0 * size;
}

/// @param reference  drawn over the columns that it has; null without one
std::vector<PlotPanel> panels_of(const UnitTrace& trace, const UnitTrace* reference, const std::string& x,
                                 const PlotArguments& options) {
  std::vector<PlotPanel> panels;
  std::map<std::size_t, std::vector<PlotCurve>> references;  // by panel
  for (const std::string& column : options.columns) {
    PlotCurve curve = curve_of(trace, x, column, options);
    const std::string unit = trace.unit(column);
    if (only_rounding(trace, unit, curve) && magnitude(curve.y) > 0.0) curve.name += " (only rounding)";
    const auto place = std::find_if(panels.begin(), panels.end(), [&](const PlotPanel& panel) {
      return options.one_panel || (!options.each && fits(trace, panel, unit, curve));
    });
    const auto at = static_cast<std::size_t>(place - panels.begin());
    if (place == panels.end()) {
      panels.push_back({unit, {std::move(curve)}, false, std::nullopt});
    } else {
      if (place->unit != unit) place->unit.clear();
      place->curves.push_back(std::move(curve));
    }
    if (reference == nullptr || reference->find(column) == nullptr) continue;
    PlotCurve over = curve_of(*reference, x, column, options);
    over.name = "reference";
    over.colour = "#222222";
    over.reference = true;
    references[at].push_back(std::move(over));
  }
  // Last, so that they lie above, and the others keep their colours.
  for (auto& [panel, curves] : references) {
    for (PlotCurve& curve : curves) {
      curve.named = &curve == &curves.front();
      panels[panel].curves.push_back(std::move(curve));
    }
  }
  for (PlotPanel& panel : panels) choose_range(trace, panel);
  return panels;
}

double linear_at(const PlotCurve& curve, std::size_t& after, double x) {
  while (curve.x[after] < x) ++after;
  if (curve.x[after] == x) return curve.y[after];
  const double part = (x - curve.x[after - 1]) / (curve.x[after] - curve.x[after - 1]);
  return curve.y[after - 1] + part * (curve.y[after] - curve.y[after - 1]);
}

/// a - b, and where it was taken.
struct Difference {
  PlotCurve curve;
  bool interpolated = false;
};

/// At the records at one place in both, where there are some; else at all of a's that lie within b's range, b being
/// linear between its own.
Difference difference(const PlotCurve& a, const PlotCurve& b) {
  constexpr std::size_t kEnough = 10;
  // Two programs may write one time with rounding errors of its computation.
  const double same = 1e-12 * std::max(std::abs(a.x.front()), std::abs(a.x.back()));
  Difference common{{a.name + ", difference", {}, {}, false, true, {}, {}, {}}, false};
  for (std::size_t i = 0, k = 0; i < a.x.size() && k < b.x.size();) {
    if (std::abs(a.x[i] - b.x[k]) <= same) {
      common.curve.x.push_back(a.x[i]);
      common.curve.y.push_back(a.y[i++] - b.y[k++]);
    } else {
      ++(a.x[i] < b.x[k] ? i : k);
    }
  }
  if (common.curve.x.size() >= kEnough || common.curve.x.size() == a.x.size()) return common;
  Difference all{{a.name + ", difference (interpolated)", {}, {}, false, true, {}, {}, {}}, true};
  std::size_t after = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    if (a.x[i] < b.x.front() || a.x[i] > b.x.back()) continue;
    all.curve.x.push_back(a.x[i]);
    all.curve.y.push_back(a.y[i] - linear_at(b, after, a.x[i]));
  }
  return all;
}

std::vector<PlotPanel> panels_against(const UnitTrace& a, const UnitTrace& b, const std::string& x,
                                      const PlotArguments& options) {
  std::vector<PlotPanel> panels;
  for (const std::string& column : options.columns) {
    PlotCurve mine = curve_of(a, x, column, options), other = curve_of(b, x, column, options);
    for (const auto* curve : {&mine, &other})
      if (!std::is_sorted(curve->x.begin(), curve->x.end()))
        throw UsageError("column \"" + short_name(x) +
                         "\" goes back and forth: there is no difference over it to be drawn");
    auto [apart, interpolated] = difference(mine, other);
    if (apart.x.empty())
      throw UsageError(short_path(a.file) + " and " + short_path(b.file) + " have no stretch of \"" + short_name(x) +
                       "\" in common");
    const auto most =
        std::max_element(apart.y.begin(), apart.y.end(), [](double p, double q) { return std::abs(p) < std::abs(q); });
    std::cerr << short_name(column) << ": largest difference " << number_text(*most, 4) << " at " << short_name(x)
              << " = " << number_text(apart.x[static_cast<std::size_t>(most - apart.y.begin())], 6)
              << (interpolated ? ", the second trace being interpolated"
                               : ", of " + std::to_string(apart.x.size()) + " records in common")
              << "\n";
    const auto name = [](const std::string& path) { return fs::path(path).filename().string(); };
    const bool told_apart = name(a.file) != name(b.file);
    mine.name = column + ", " + (told_apart ? name(a.file) : a.file);
    other.name = column + ", " + (told_apart ? name(b.file) : b.file);
    other.reference = true;
    panels.push_back({a.unit(column), {std::move(mine), std::move(other)}, false, std::nullopt});
    panels.push_back({a.unit(column), {std::move(apart)}, true, std::nullopt});
  }
  return panels;
}

/// The columns to be drawn: those asked for, or all (that both traces have).
void choose_columns(PlotArguments& options, const std::string& x, const UnitTrace& a, const UnitTrace* b) {
  for (const std::string& column : options.columns)
    for (const UnitTrace* trace : {&a, b})
      if (trace != nullptr) static_cast<void>(trace->column(column));
  if (!options.columns.empty()) return;
  for (const std::string& name : a.table.names)
    if (name != x && (b == nullptr || b->find(name) != nullptr)) options.columns.push_back(name);
  if (options.columns.empty())
    throw UsageError(b == nullptr ? short_path(a.file) + " has no column but \"" + short_name(x) + "\""
                                  : short_path(a.file) + " and " + short_path(b->file) +
                                        " have no column in common but \"" + short_name(x) + "\"");
}

/// @throws UsageError if a reference has nothing of what is drawn.
void check_reference(const UnitTrace& reference, const std::string& x, const std::vector<std::string>& columns) {
  static_cast<void>(reference.column(x));
  if (std::none_of(columns.begin(), columns.end(), [&](const auto& name) { return reference.find(name) != nullptr; }))
    throw UsageError(reference.file +
                     " has none of the columns that are drawn: there is no reference to draw over them");
}

/// The lanes asked for, from a table of events.
void add_lanes(Plot& plot, const PlotArguments& options, double start) {
  constexpr std::size_t kMost = 30;
  const std::string text = read_text(options.events, NamedBy::user);
  LaneBook book;
  try {
    read_event_records(text, [&](const RunEvent& event) { book.take(event); });
  } catch (const CsvError& error) {
    throw UsageError(short_path(options.events) + ":" + std::to_string(error.line) + ": " + error.without_text);
  }
  std::vector<Lane> lanes = book.lanes(start);
  if (lanes.empty())
    throw UsageError(short_path(options.events) +
                     " has no switch, diode, contact, latch, event or sample: there is no lane to draw");
  if (!options.lanes.empty()) {
    std::vector<std::string> names;
    for (const Lane& lane : lanes) names.push_back(lane.name);
    for (const std::string& wanted : options.lanes) {
      const auto found = std::find(names.begin(), names.end(), wanted);
      const std::string near = nearest_name(wanted, names);
      if (found == names.end())
        throw UsageError(short_path(options.events) + " has no lane \"" + short_name(wanted) + "\"" +
                         (near.empty() ? "" : "; did you mean \"" + short_name(near) + "\"?"));
      plot.lanes.push_back(lanes[static_cast<std::size_t>(found - names.begin())]);
    }
    return;
  }
  for (const std::size_t i : lanes_to_draw(lanes, kMost)) plot.lanes.push_back(std::move(lanes[i]));
  if (lanes.size() > kMost) {
    plot.lanes_left_out = std::to_string(kMost) + " of " + std::to_string(lanes.size()) + " lanes";
    std::cerr << lanes.size() - kMost << " of " << lanes.size() << " lanes are not drawn; --lane NAME draws others\n";
  }
}

}  // namespace

Exit plot_command(const Arguments& arguments) {
  PlotArguments options = parse_plot(arguments);
  if (options.output.empty()) options.output = file_name(fs::path(options.file).stem().string()) + ".svg";
  const std::string ending = options.output == "-" ? ".svg" : fs::path(options.output).extension().string();
  if (ending != ".svg" && ending != ".png")
    throw UsageError("\"" + short_path(options.output) + "\" ends with neither .svg nor .png: which picture is meant?");
  std::vector<NamedFile> inputs{{options.file, "it is the trace itself"}, {units_of(options.file), kUnitsRole}};
  if (!options.against.empty()) {
    inputs.push_back({options.against, "it is the other trace"});
    inputs.push_back({units_of(options.against), kUnitsRole});
  }
  if (!options.events.empty()) inputs.push_back({options.events, "it is the table of events"});
  check_outputs({{options.output, "the picture"}}, inputs);
  const bool sweep = fs::is_directory(options.file);
  if (!options.events.empty() && (sweep || !options.x.empty()))
    throw UsageError("--events draws the sides of switches over the time of one run, without --x and not for a sweep");
  if (sweep && (!options.against.empty() || !options.reference.empty() || !options.x.empty()))
    throw UsageError("the bands of a sweep are drawn over time, without --x, --against and --reference");
  OutputFile file(options.output);
  Bands bands;
  const UnitTrace trace = sweep ? medians_of(options.file, bands) : read_trace(options.file);
  if (sweep && !options.one_panel) options.each = true;  // units are not known
  std::optional<UnitTrace> other, reference;
  if (!options.against.empty()) other = read_trace(options.against);
  if (!options.reference.empty()) reference = read_trace(options.reference);

  const std::string x = options.x.empty() ? trace.table.names.front() : options.x;
  static_cast<void>(trace.column(x));
  choose_columns(options, x, trace, other ? &*other : nullptr);
  Plot plot;
  plot.title = options.title.empty() ? fs::path(options.file).filename().string() : options.title;
  // Model format 1 has its time in seconds, for which its traces have no unit.
  const std::string x_unit = !trace.unit(x).empty() ? trace.unit(x) : x == "t" && !trace.units.empty() ? "s" : "";
  plot.x_label = x + (x_unit.empty() ? "" : " in " + x_unit);
  if (reference) check_reference(*reference, x, options.columns);
  plot.panels = other ? panels_against(trace, *other, x, options)
                      : panels_of(trace, reference ? &*reference : nullptr, x, options);
  if (sweep) add_bands(plot.panels, bands, options);
  if (!options.events.empty()) add_lanes(plot, options, trace.column(x).front());
  std::string picture = plot_svg(plot);
  if (ending == ".png") picture = png_from_svg(picture, options.zoom);
  file.stream() << picture;
  file.commit();
  return Exit::done;
}

}  // namespace bgsim::cli
