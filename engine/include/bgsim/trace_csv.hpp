/// Traces as CSV text (RFC 4180): writing exactly, reading strictly.
#pragma once

#include <ostream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// Writes `t` and the trace's columns: one header record, one record for each time. Numbers are the shortest decimal
/// text that reads back as the same double; names are quoted where they hold a comma, a quote or a line break; records
/// end with CRLF, as the RFC has it. Units are not part of it (see trace_units_json).
///
/// A failed write is left in the state of @p out for the caller to see.
void write_trace_csv(std::ostream& out, const Trace& trace);
/// The same bytes record by record: the header, and one for each time.
void append_csv_header(std::string& text, const std::vector<std::string>& names);
void append_csv_record(std::string& text, double time, std::span<const double> values);

/// The units of a trace's columns: {"x": "m"}; columns without a unit are left out.
std::string trace_units_json(const Trace& trace);

/// A CSV file of numbers under one header record.
struct CsvTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< by name, all of the same length
};

/// A fault in a CSV text, with the line (from 1) at which it stands.
class CsvError : public std::runtime_error {
 public:
  CsvError(std::size_t line_, const std::string& message) : std::runtime_error(message), line(line_) {}
  std::size_t line;
};

/// Reads a CSV text: a header with distinct names that are not empty, then records of as many finite numbers. Lines may
/// end with CRLF or LF, the last one with neither; a UTF-8 byte order mark is skipped; spaces around numbers are
/// allowed.
/// @throws CsvError for anything else: a record of another length, a field that is no number, an open quote, no header.
/// @note Time and memory linear in the text.
CsvTable parse_csv(std::string_view text);

}  // namespace bgsim
