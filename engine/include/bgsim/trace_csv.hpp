/// Traces as CSV text (RFC 4180), written exactly.
#pragma once

#include <ostream>
#include <span>
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

/// A run's events as CSV: t,kind,name,quantity,from,to,impulse,energy; what an event has none of is empty.
void append_event_header(std::string& text);
void append_event_record(std::string& text, const RunEvent& event);
/// Hands over each row of such a table, in order.
/// @throws CsvError  another header, a kind that is not known, a cell that is no number where one belongs.
void read_event_records(std::string_view text, const EventSink& take);
/// "switch", "impact", ...: as they stand in that table.
std::string_view event_kind_text(RunEvent::Kind kind);

/// The units of a trace's columns: {"x": "m"}; columns without a unit are left out.
std::string trace_units_json(const Trace& trace);

}  // namespace bgsim
