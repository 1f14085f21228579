#include "bgsim/trace_csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

void append_number(std::string& line, double value) {
  std::array<char, 32> digits{};  // the longest shortest form, -2.2250738585072014e-308, has 24
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  line.append(digits.data(), end);
}

}  // namespace

void append_csv_header(std::string& text, const std::vector<std::string>& names) {
  text += 't';
  for (const std::string& name : names) {
    text += ',';
    text += csv_field(name);
  }
  text += "\r\n";
}

void append_csv_record(std::string& text, double time, std::span<const double> values) {
  append_number(text, time);
  for (const double value : values) {
    text += ',';
    append_number(text, value);
  }
  text += "\r\n";
}

std::string_view event_kind_text(RunEvent::Kind kind) {
  using Kind = RunEvent::Kind;
  switch (kind) {
    case Kind::time:
      return "time";
    case Kind::condition:
      return "condition";
    case Kind::event:
      return "event";
    case Kind::sample:
      return "sample";
    case Kind::latch:
      return "latch";
    case Kind::switching:
      return "switch";
    case Kind::diode:
      return "diode";
    case Kind::contact:
      return "contact";
    case Kind::impact:
      return "impact";
    case Kind::jump:
      return "jump";
    case Kind::start:
      return "start";
  }
  return "";
}

void append_event_header(std::string& text) { text += "t,kind,name,quantity,from,to,impulse,energy\r\n"; }

void append_event_record(std::string& text, const RunEvent& event) {
  append_number(text, event.t);
  text += ',';
  text += event_kind_text(event.kind);
  for (const std::string* field : {&event.name, &event.quantity, &event.from, &event.to}) {
    text += ',';
    text += csv_field(*field);
  }
  for (const std::optional<double>& number : {event.impulse, event.energy}) {
    text += ',';
    if (number) append_number(text, *number);
  }
  text += "\r\n";
}

void read_event_records(std::string_view text, const EventSink& take) {
  using Kind = RunEvent::Kind;
  constexpr std::array kKinds{Kind::time,  Kind::condition, Kind::event,  Kind::sample, Kind::latch, Kind::switching,
                              Kind::diode, Kind::contact,   Kind::impact, Kind::jump,   Kind::start};
  const auto number = [](std::size_t line, const std::string& field, const char* column) {
    double value = 0.0;
    const char* const end = field.data() + field.size();
    const auto [stop, fault] = std::from_chars(field.data(), end, value);
    if (fault != std::errc{} || stop != end || !std::isfinite(value))
      throw CsvError(line, in_quotes(field) + " in column " + in_quotes(column) + " is not a number");
    return value;
  };
  const std::vector<std::string> header{"t", "kind", "name", "quantity", "from", "to", "impulse", "energy"};
  bool first = true;
  read_csv_records(text, [&](std::size_t line, const std::vector<std::string>& fields) {
    if (std::exchange(first, false)) {
      if (fields != header)
        throw CsvError(line, "no table of events: its header is not t,kind,name,quantity,from,to,impulse,energy");
      return;
    }
    RunEvent event;
    event.t = number(line, fields[0], "t");
    const auto* const kind =
        std::find_if(kKinds.begin(), kKinds.end(), [&](Kind one) { return event_kind_text(one) == fields[1]; });
    if (kind == kKinds.end()) throw CsvError(line, in_quotes(fields[1]) + " is no kind of event");
    event.kind = *kind;
    event.name = fields[2];
    event.quantity = fields[3];
    event.from = fields[4];
    event.to = fields[5];
    if (!fields[6].empty()) event.impulse = number(line, fields[6], "impulse");
    if (!fields[7].empty()) event.energy = number(line, fields[7], "energy");
    take(event);
  });
  if (first) throw CsvError(1, "the file is empty: a table of events has a header");
}

void write_trace_csv(std::ostream& out, const Trace& trace) {
  std::string line;
  std::vector<double> values(trace.names.size());
  append_csv_header(line, trace.names);
  out.write(line.data(), static_cast<std::streamsize>(line.size()));
  for (std::size_t row = 0; row < trace.times.size() && out; ++row) {
    line.clear();
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = trace.columns[i][row];
    append_csv_record(line, trace.times[row], values);
    out.write(line.data(), static_cast<std::streamsize>(line.size()));
  }
}

std::string trace_units_json(const Trace& trace) {
  nlohmann::ordered_json units = nlohmann::ordered_json::object();
  for (std::size_t column = 0; column < trace.names.size(); ++column)
    if (!trace.units[column].empty()) units[trace.names[column]] = trace.units[column];
  return json_text(units, 2) + "\n";
}

}  // namespace bgsim
