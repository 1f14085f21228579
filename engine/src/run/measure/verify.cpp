#include "bgsim/verify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/codes.hpp"
#include "bgsim/input_file.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

constexpr const char* kTime = "t";

[[noreturn]] void fail(const Model& model, const Reference& reference, std::string_view code, std::string situation,
                       std::string rule, std::string help) {
  Diagnostic problem = diagnostic_of(code);
  problem.situation = std::move(situation);
  problem.place = reference.place;
  problem.rule = std::move(rule);
  problem.help = std::move(help);
  throw ModelError({problem}, model.sources);
}

[[noreturn]] void unreadable(const Model& model, const Reference& reference, const std::string& what) {
  fail(model, reference, "BG150", "reference \"" + short_name(reference.file) + "\": " + what,
       "a reference is a CSV file with a header, a first column t that increases, and numbers", {});
}

std::size_t position(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The reference at @p t, linear between its records, constant beyond them.
double interpolated(const std::vector<double>& times, const std::vector<double>& values, double t) {
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  if (after == times.begin()) return values.front();
  if (after == times.end()) return values.back();
  const auto i = static_cast<std::size_t>(after - times.begin());
  const double part = (t - times[i - 1]) / (times[i] - times[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

struct ValueRange {
  double low, high;
};

/// What the reference takes on [times[row] - tube, times[row] + tube].
ValueRange range_within(const std::vector<double>& times, const std::vector<double>& values, std::size_t row,
                        double tube) {
  ValueRange range{values[row], values[row]};
  if (tube <= 0.0) return range;
  const auto take = [&range](double value) {
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  };
  const double from = times[row] - tube;
  const double to = times[row] + tube;
  take(interpolated(times, values, from));
  take(interpolated(times, values, to));
  for (std::size_t i = row; i-- > 0 && times[i] >= from;) take(values[i]);
  for (std::size_t i = row + 1; i < times.size() && times[i] <= to; ++i) take(values[i]);
  return range;
}

double limit_of(const std::vector<double>& values, const Reference& reference) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return reference.relative * largest + reference.absolute;
}

ColumnCheck check_column(const Trace& trace, std::size_t output, const std::vector<double>& times,
                         const std::vector<double>& values, const Reference& reference) {
  ColumnCheck check;
  check.limit = limit_of(values, reference);
  // The trace may begin earlier than the reference (see at_reference_times), never end later.
  const std::size_t first = trace.times.size() - times.size();
  for (std::size_t row = 0; row < times.size(); ++row) {
    const double value = trace.columns[output][first + row];
    const ValueRange range = range_within(times, values, row, reference.tube);
    const double error = std::isfinite(value) ? std::max({range.low - value, value - range.high, 0.0})
                                              : std::numeric_limits<double>::infinity();
    if (row > 0 && error <= check.error) continue;
    check.error = error;
    check.time = times[row];
    check.value = value;
    check.low = range.low;
    check.high = range.high;
  }
  return check;
}

/// The reference's column for each output of the trace; none where the reference has no such column.
std::vector<std::optional<std::size_t>> pair_columns(const Model& model, const std::vector<std::string>& outputs,
                                                     const CsvTable& table, const Reference& reference) {
  for (const auto& [output, column] : reference.columns) {
    if (position(outputs, output) == outputs.size()) {
      fail(model, reference, "BG152",
           "the scene has no output \"" + short_name(output) + "\" to compare with a reference",
           "\"columns\" maps outputs of the scene to columns of the reference",
           "add it to the model's outputs, or leave it out here");
    }
    if (position(table.names, column) == table.names.size()) {
      fail(model, reference, "BG152",
           "reference \"" + short_name(reference.file) + "\" has no column \"" + short_name(column) + '"',
           "\"columns\" maps outputs of the scene to columns of the reference", {});
    }
  }
  std::vector<std::optional<std::size_t>> pairs;
  bool any = false;
  for (const std::string& output : outputs) {
    const auto mapped = reference.columns.find(output);
    const std::size_t column = position(table.names, mapped == reference.columns.end() ? output : mapped->second);
    pairs.emplace_back(column == table.names.size() ? std::nullopt : std::optional(column));
    any = any || pairs.back();
  }
  if (!any) {
    fail(model, reference, "BG152",
         "no output of the scene is a column of reference \"" + short_name(reference.file) + '"',
         "outputs are compared with columns of the same name", "map them by \"columns\": { \"output\": \"column\" }");
  }
  return pairs;
}

}  // namespace

bool ReferenceCheck::ok() const {
  return std::all_of(columns.begin(), columns.end(), [](const ColumnCheck& column) { return column.ok(); });
}

void check_reference(const Model& model, const std::string& path, const Reference& reference,
                     const ReadOptions& options) {
  if (may_be_named(reference.file, with_folder_of(path, options))) return;
  fail(model, reference, "BG170", "the reference \"" + reference.file + "\" is outside the model's folder",
       kOutsideRule, kOutsideHelp);
}

CsvTable read_reference(const Model& model, const Reference& reference) {
  const InputText file = read_input(reference.file, NamedBy::model);
  if (!file.fault.empty()) unreadable(model, reference, file.fault);
  CsvTable table;
  try {
    table = parse_csv(file.text);
  } catch (const CsvError& error) {
    unreadable(model, reference, "line " + std::to_string(error.line) + ": " + error.without_text);
  }
  if (table.names.front() != kTime) unreadable(model, reference, "the first column is not named t");
  const std::vector<double>& times = table.columns.front();
  if (times.empty()) unreadable(model, reference, "there are no records");
  for (std::size_t row = 1; row < times.size(); ++row) {
    if (times[row] > times[row - 1]) continue;
    unreadable(model, reference,
               "t = " + number_text(times[row], 17) + " comes after t = " + number_text(times[row - 1], 17));
  }
  return table;
}

RunInputs at_reference_times(const Model& model, const RunInputs& inputs, const CsvTable& table) {
  const std::vector<double>& times = table.columns.front();
  if (times.front() < inputs.start || times.back() > inputs.stop) {
    fail(model, inputs.reference.value(), "BG151",
         "scene \"" + short_name(inputs.scene) + "\" runs from " + number_text(inputs.start, 17) + " to " +
             number_text(inputs.stop, 17) + ", its reference from " + number_text(times.front(), 17) + " to " +
             number_text(times.back(), 17),
         "a reference lies within its scene's times", "adjust the scene's start and stop");
  }
  RunInputs adapted = inputs;
  std::vector<double> recorded;
  if (times.front() > inputs.start) recorded.push_back(inputs.start);
  recorded.insert(recorded.end(), times.begin(), times.end());
  adapted.output_times = std::move(recorded);
  adapted.stop = times.back();  // nothing is compared beyond
  return adapted;
}

ReferenceCheck hold_against(const Model& model, const Trace& trace, const CsvTable& table, const Reference& reference) {
  const auto pairs = pair_columns(model, trace.names, table, reference);
  std::vector<bool> used(table.names.size(), false);
  used.front() = true;
  ReferenceCheck check;
  for (std::size_t output = 0; output < trace.names.size(); ++output) {
    if (!pairs[output]) {
      check.unheld.push_back(trace.names[output]);
      continue;
    }
    const std::size_t column = *pairs[output];
    used[column] = true;
    check.columns.push_back(check_column(trace, output, table.columns.front(), table.columns[column], reference));
    check.columns.back().output = trace.names[output];
    check.columns.back().reference = table.names[column];
  }
  for (std::size_t column = 0; column < used.size(); ++column) {
    if (!used[column]) check.unused.push_back(table.names[column]);
  }
  return check;
}

std::vector<ReferenceBand> reference_bands(const Model& model, const std::vector<std::string>& outputs,
                                           const CsvTable& table, const Reference& reference) {
  const auto pairs = pair_columns(model, outputs, table, reference);
  const std::vector<double>& times = table.columns.front();
  std::vector<ReferenceBand> bands;
  for (std::size_t output = 0; output < outputs.size(); ++output) {
    if (!pairs[output]) continue;
    const std::vector<double>& values = table.columns[*pairs[output]];
    ReferenceBand band{outputs[output], table.names[*pairs[output]], limit_of(values, reference), values, {}, {}};
    for (std::size_t row = 0; row < times.size(); ++row) {
      const ValueRange range = range_within(times, values, row, reference.tube);
      band.low.push_back(range.low - band.limit);
      band.high.push_back(range.high + band.limit);
    }
    bands.push_back(std::move(band));
  }
  return bands;
}

}  // namespace bgsim
