#include <algorithm>
#include <optional>

#include "read/reader.hpp"

namespace bgsim {

/// Reads a CSV file once, however many of its columns are used.
const CsvTable& Reader::data_file(const std::string& path, const std::function<void(std::string, std::string)>& fail) {
  if (const auto known = data_.find(path); known != data_.end()) return known->second;
  const InputText file = read_input(path, NamedBy::model);
  if (!file.fault.empty())
    fail("cannot read the data file " + in_quotes(path) + ": " + file.fault,
         "paths are relative to the folder of the file that names them");
  CsvTable table;
  try {
    table = parse_csv(file.text);
  } catch (const CsvError& error) {
    fail(path + ":" + std::to_string(error.line) + ": " + error.without_text, {});
  }
  const std::vector<double>& x = table.columns.front();
  if (table.columns.size() < 2)
    fail("the data file " + in_quotes(path) + " has one column only",
         "the first is what the others are tabulated over");
  if (x.size() < 2) fail("the data file " + in_quotes(path) + " has fewer than two rows of data", {});
  for (std::size_t i = 1; i < x.size(); ++i)
    if (!(x[i] > x[i - 1]))
      fail("row " + std::to_string(i + 1) + " of " + in_quotes(path) + " does not lie after the row before it",
           "the first column must increase; for a jump, use two tables and step(t - t0)");
  return data_.emplace(path, std::move(table)).first->second;
}

/// A column of a CSV file over its first column. @p file and @p column are parts of the expression @p text.
namespace {

/// The first row, counted from 1, that lies next to nothing before the one after it, measured by the gaps beside.
std::optional<std::size_t> uneven_row(const std::vector<double>& x) {
  constexpr double kUneven = 1e6;
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    if (before > kUneven * after) return i + 1;
    if (after > kUneven * before) return i;
  }
  return std::nullopt;
}

}  // namespace

TableId Reader::load_table(const Scope& scope, std::string_view text, std::string_view file, std::string_view column,
                           Interpolation interpolation) {
  const std::string path = beside(scope.document, file);
  const std::string key =
      path + "\n" + std::string(column) + (interpolation == Interpolation::spline ? "\nspline" : "\nlinear");
  if (const auto known = tables_.find(key); known != tables_.end()) return known->second;
  const auto refuse = [&](std::string_view part, const std::string& what, const std::string& help) {
    const auto begin = static_cast<std::size_t>(part.data() - text.data());
    throw ExpressionError("BG127", what, begin, begin + part.size(), help);
  };
  if (!may_be_named(path, options_)) {
    const auto begin = static_cast<std::size_t>(file.data() - text.data());
    throw ExpressionError("BG170", "the data file " + in_quotes(path) + " is outside the model's folder", begin,
                          begin + file.size(), kOutsideHelp);
  }
  const CsvTable& data =
      data_file(path, [&](const std::string& what, const std::string& help) { refuse(file, what, help); });
  const auto at = std::find(data.names.begin(), data.names.end(), column);
  if (at == data.names.end()) {
    std::string help = suggestion(column, data.names);
    if (help.empty()) help = "its columns are " + list_of(data.names, " and ");
    refuse(column, "the data file " + in_quotes(path) + " has no column " + in_quotes(column), help);
  }
  if (at == data.names.begin())
    refuse(column,
           in_quotes(column) + " is the first column of " + in_quotes(path) + ", over which the others are tabulated",
           "name another column");
  Table table;
  table.file = path;
  table.column = std::string(column);
  table.interpolation = interpolation;
  table.x = data.columns.front();
  table.y = data.columns[static_cast<std::size_t>(at - data.names.begin())];
  if (interpolation == Interpolation::spline) {
    if (const auto row = uneven_row(table.x))
      refuse(
          file,
          "rows " + std::to_string(*row) + " and " + std::to_string(*row + 1) + " of " + in_quotes(path) +
              " lie a million times nearer to each other than their neighbours: a spline swings there beyond measure",
          "for a jump, use two tables and step(t - t0); else interpolate linearly or drop a row");
    prepare_spline(table);
  }
  const TableId id = model_.pool.add_table(std::move(table));
  tables_.emplace(key, id);
  return id;
}

}  // namespace bgsim
