#include "bgsim/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

/// Walks over a CSV text field by field.
class CsvReader {
 public:
  explicit CsvReader(std::string_view text) : text_(text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text_.substr(0, kByteOrderMark.size()) == kByteOrderMark) at_ = kByteOrderMark.size();
  }

  [[nodiscard]] bool at_end() const { return at_ == text_.size(); }
  [[nodiscard]] std::size_t line() const { return line_; }

  /// Reads the next field. False if it was the last of its record.
  bool field(std::string& value) {
    value.clear();
    if (!at_end() && text_[at_] == '"') {
      quoted(value);
    } else {
      const std::size_t end = std::min(text_.find_first_of(",\r\n\"", at_), text_.size());
      value.assign(text_.substr(at_, end - at_));
      at_ = end;
    }
    return separator();
  }

 private:
  void quoted(std::string& value) {
    const std::size_t opened = line_;
    ++at_;
    while (true) {
      const std::size_t quote = text_.find('"', at_);
      if (quote == std::string_view::npos) throw CsvError(opened, "a quote is opened and never closed");
      const std::string_view part = text_.substr(at_, quote - at_);
      line_ += static_cast<std::size_t>(std::count(part.begin(), part.end(), '\n'));
      value += part;
      at_ = quote + 1;
      if (at_end() || text_[at_] != '"') return;
      value += '"';
      ++at_;
    }
  }

  bool separator() {
    if (at_end()) return false;
    if (text_[at_] == ',') {
      ++at_;
      return true;
    }
    if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
    if (text_[at_] != '\n') {
      throw CsvError(line_, text_[at_] == '"' ? "a quote inside a field that does not begin with one"
                                              : "a comma or the end of the line is missing after a field");
    }
    ++at_;
    ++line_;
    return false;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

/// A file is known to be a table of numbers once its first record has been read.
bool is_known(const CsvTable& table) { return !table.columns.back().empty(); }

/// A fault in a field, in words that show it and in words that do not.
CsvError field_fault(std::size_t line, const CsvTable& table, std::size_t column, const std::string& field,
                     const std::string& what) {
  const std::string number = std::to_string(column + 1);
  const std::string place = " in column " + in_quotes(table.names[column]);
  const std::string shown = field.empty() ? what + place : in_quotes(field) + place + what;
  if (is_known(table)) return {line, shown, shown};
  return {line, shown, field.empty() ? what + " in column " + number : "the value in column " + number + what};
}

double parse_number(std::size_t line, const CsvTable& table, std::size_t column, const std::string& field) {
  const std::size_t first = field.find_first_not_of(" \t");
  const std::size_t last = field.find_last_not_of(" \t");
  if (first == std::string::npos) throw field_fault(line, table, column, {}, "no value");
  const char* begin = field.data() + first;
  const char* const end = field.data() + last + 1;
  if (*begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;  // from_chars takes no plus sign
  double value = 0.0;
  const auto [stop, fault] = std::from_chars(begin, end, value);
  if (fault == std::errc::result_out_of_range) {
    // Smaller than any double rounds to zero; larger than any is an error. The exponent's sign tells.
    const std::string_view digits(begin, static_cast<std::size_t>(end - begin));
    if (stop == end && digits.find("e-") != std::string_view::npos) return *begin == '-' ? -0.0 : 0.0;
    if (stop == end && digits.find("E-") != std::string_view::npos) return *begin == '-' ? -0.0 : 0.0;
    throw field_fault(line, table, column, field, " is beyond the range of a number");
  }
  if (fault != std::errc{} || stop != end || !std::isfinite(value)) {
    throw field_fault(line, table, column, field, " is not a number");
  }
  return value;
}

std::vector<std::string> parse_header(CsvReader& reader) {
  std::vector<std::string> names;
  std::unordered_map<std::string, std::size_t> seen;
  if (reader.at_end()) throw CsvError(1, "the file is empty: a header with the columns' names is needed");
  std::string name;
  bool more = true;
  while (more) {
    const std::size_t line = reader.line();
    more = reader.field(name);
    if (name.empty()) throw CsvError(line, "column " + std::to_string(names.size() + 1) + " has no name");
    if (const auto [first, is_new] = seen.emplace(name, names.size()); !is_new)
      throw CsvError(line, "two columns are named " + in_quotes(name),
                     "columns " + std::to_string(first->second + 1) + " and " + std::to_string(names.size() + 1) +
                         " have the same name");
    names.push_back(name);
  }
  if (names.size() == 1)
    for (const char separator : {';', '\t'})
      if (names.front().find(separator) != std::string::npos)
        throw CsvError(1, std::string("the columns are separated by ") + (separator == ';' ? "semicolons" : "tabs") +
                              ": a comma is to stand between them, and a point in numbers");
  return names;
}

}  // namespace

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

namespace {

/// Reads the records: @p take gets the record's line, the column and the text of each cell.
template <class Take>
void for_each_cell(CsvReader& reader, const CsvTable& table, const Take& take) {
  std::string field;
  while (!reader.at_end()) {
    std::size_t column = 0;
    const std::size_t line = reader.line();
    bool more = true;
    while (more) {
      more = reader.field(field);
      if (column < table.names.size()) take(line, column, field);
      ++column;
    }
    if (column != table.names.size()) {
      throw CsvError(line, std::to_string(column) + " fields where the header has " +
                               std::to_string(table.names.size()) + " columns");
    }
  }
}

bool is_missing(const std::string& field) {
  const std::string word = lower_case(trimmed(field));
  return word.empty() || word == "nan" || word == "na";
}

}  // namespace

CsvTable parse_csv(std::string_view text) {
  CsvReader reader(text);
  CsvTable table;
  table.names = parse_header(reader);
  table.columns.resize(table.names.size());
  for_each_cell(reader, table, [&](std::size_t line, std::size_t column, const std::string& field) {
    table.columns[column].push_back(parse_number(line, table, column, field));
  });
  return table;
}

void read_csv_records(std::string_view text,
                      const std::function<void(std::size_t line, const std::vector<std::string>& fields)>& take) {
  CsvReader reader(text);
  std::vector<std::string> fields;
  std::size_t columns = 0;
  while (!reader.at_end()) {
    const std::size_t line = reader.line();
    fields.clear();
    do {
      fields.emplace_back();
    } while (reader.field(fields.back()));
    if (columns == 0) columns = fields.size();
    if (fields.size() != columns)
      throw CsvError(
          line, std::to_string(fields.size()) + " fields where the header has " + std::to_string(columns) + " columns");
    take(line, fields);
  }
}

CsvCells parse_csv_cells(std::string_view text) {
  CsvReader reader(text);
  CsvCells cells;
  CsvTable& table = cells.table;
  table.names = parse_header(reader);
  table.columns.resize(table.names.size());
  cells.faults.resize(table.names.size());
  for_each_cell(reader, table, [&](std::size_t line, std::size_t column, const std::string& field) {
    if (column == 0) cells.lines.push_back(line);
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!is_missing(field)) try {
        value = parse_number(line, table, column, field);
      } catch (const CsvError& error) {
        if (!cells.faults[column]) cells.faults[column] = error;
      }
    table.columns[column].push_back(value);
  });
  return cells;
}

}  // namespace bgsim
