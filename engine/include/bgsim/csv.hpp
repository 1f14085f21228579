/// CSV (RFC 4180): fields written, tables of numbers read strictly.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bgsim {

/// @p text as a field of a record (RFC 4180): in quotes, with doubled quotes inside, where it holds a comma, a quote or
/// a line break, else as it is. It is never altered, so that it reads back the same; that a spreadsheet takes a field
/// that begins with =, +, - or @ for a formula is a matter of the spreadsheet (docs/design/writers.md).
std::string csv_field(std::string_view text);

/// A CSV file of numbers under one header record.
struct CsvTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< by name, all of the same length
};

/// An error in a CSV text, with its line (from 1).
class CsvError : public std::runtime_error {
 public:
  CsvError(std::size_t line_, const std::string& message) : CsvError(line_, message, message) {}
  CsvError(std::size_t line_, const std::string& message, std::string without)
      : std::runtime_error(message), line(line_), without_text(std::move(without)) {}
  std::size_t line;
  /// The message in words that show nothing of the text until its first record has been read: a file that a model names
  /// may be no table at all.
  std::string without_text;
};

/// Reads a CSV text: a header with distinct names that are not empty, then records of as many finite numbers. Lines may
/// end with CRLF or LF, the last one with neither; a UTF-8 byte order mark is skipped; spaces around numbers are
/// allowed.
/// @throws CsvError for anything else: a record of another length, a field that is no number, an open quote, no header.
/// @note Time and memory linear in the text.
CsvTable parse_csv(std::string_view text);

/// Hands over the fields of each record, the header's too, with the record's line (from 1).
/// @throws CsvError  an open quote; a record of another length than the header.
void read_csv_records(std::string_view text,
                      const std::function<void(std::size_t line, const std::vector<std::string>& fields)>& take);

/// The same of measurements, where cells may be empty.
struct CsvCells {
  CsvTable table;                               ///< NaN where there is no number
  std::vector<std::size_t> lines;               ///< of the text, by record
  std::vector<std::optional<CsvError>> faults;  ///< by column: of the first cell that is neither empty nor a number
};

/// Reads a CSV text as parse_csv does, but for what stands in the cells: an empty one, "NaN" or "NA" is a missing
/// value; another that is no number is kept as a fault of its column, which may be one that nobody asks for.
/// @throws CsvError for the header, a record of another length, an open quote.
CsvCells parse_csv_cells(std::string_view text);

}  // namespace bgsim
