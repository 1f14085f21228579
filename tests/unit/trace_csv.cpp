#include "bgsim/trace_csv.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <sstream>

#include "bgsim/csv.hpp"

using bgsim::CsvError;
using bgsim::CsvTable;
using bgsim::parse_csv;
using bgsim::Trace;

namespace {

std::string written(const Trace& trace) {
  std::ostringstream out;
  bgsim::write_trace_csv(out, trace);
  return out.str();
}

/// The line and message of the fault in @p text, "line 3: ...".
std::string fault(const std::string& text) {
  try {
    parse_csv(text);
  } catch (const CsvError& error) {
    return "line " + std::to_string(error.line) + ": " + error.what();
  }
  return "none";
}

}  // namespace

TEST_CASE("a trace is written with t first, one record for each time, lines ending with CRLF") {
  CHECK(written({{"x", "v"}, {"m", "m/s"}, {0.0, 0.5}, {{1.0, 0.1}, {-2.0, 1e300}}}) ==
        "t,x,v\r\n0,1,-2\r\n0.5,0.1,1e+300\r\n");
}

TEST_CASE("a trace without outputs has the column of times alone") {
  CHECK(written({{}, {}, {0.0, 1.0}, {}}) == "t\r\n0\r\n1\r\n");
}

TEST_CASE("names with commas, quotes and line breaks are quoted, and read back as they were") {
  const Trace trace{{"a,b", "say \"x\"", "two\nlines"}, {"", "", ""}, {0.0}, {{1.0}, {2.0}, {3.0}}};
  CHECK(written(trace) == "t,\"a,b\",\"say \"\"x\"\"\",\"two\nlines\"\r\n0,1,2,3\r\n");
  const CsvTable table = parse_csv(written(trace));
  CHECK(table.names == std::vector<std::string>{"t", "a,b", "say \"x\"", "two\nlines"});
  CHECK(table.columns[3] == std::vector<double>{3.0});
}

TEST_CASE("every double survives writing and reading to the last bit") {
  std::mt19937_64 random(1);  // seeded: the same 20000 bit patterns each time
  Trace trace{{"x"}, {""}, {}, {{}}};
  const auto add = [&trace](double x) {
    trace.times.push_back(0.0);
    trace.columns[0].push_back(x);
  };
  for (const double x : {5e-324, -2.2250738585072014e-308, 1.7976931348623157e308, 0.1, -0.0, 123456789012345680.0}) {
    add(x);
  }
  while (trace.columns[0].size() < 20000) {
    const auto x = std::bit_cast<double>(random());
    if (std::isfinite(x)) add(x);
  }
  const CsvTable table = parse_csv(written(trace));
  REQUIRE(table.columns[1].size() == trace.columns[0].size());
  for (std::size_t i = 0; i < trace.columns[0].size(); ++i) {
    REQUIRE(std::bit_cast<std::uint64_t>(table.columns[1][i]) == std::bit_cast<std::uint64_t>(trace.columns[0][i]));
  }
}

TEST_CASE("units come as JSON beside the trace, columns without one left out") {
  CHECK(bgsim::trace_units_json({{"x", "n", "q\"\\"}, {"m", "", "m^3"}, {}, {}}) ==
        "{\n  \"x\": \"m\",\n  \"q\\\"\\\\\": \"m^3\"\n}\n");
}

TEST_CASE("LF, a missing last line end, a byte order mark and spaces around numbers are accepted") {
  const CsvTable table = parse_csv("\xEF\xBB\xBFt,x\n0, 1.5 \r\n+1,\"2\"");
  CHECK(table.names == std::vector<std::string>{"t", "x"});
  CHECK(table.columns[0] == std::vector<double>{0.0, 1.0});
  CHECK(table.columns[1] == std::vector<double>{1.5, 2.0});
}

TEST_CASE("numbers too small for a double read as zero, numbers too large are an error") {
  CHECK(parse_csv("x\n1e-400\n-1E-400\n").columns[0] == std::vector<double>{0.0, -0.0});
  CHECK(fault("x\n1e400\n") == "line 2: \"1e400\" in column \"x\" is beyond the range of a number");
}

TEST_CASE("what is no table of numbers is refused with its line") {
  CHECK(fault("") == "line 1: the file is empty: a header with the columns' names is needed");
  CHECK(fault("t,\n0,1\n") == "line 1: column 2 has no name");
  CHECK(fault("t;x\n0;1,5\n") ==
        "line 1: the columns are separated by semicolons: a comma is to stand between them, and a point in numbers");
  CHECK(fault("t\tx\n0\t1\n") ==
        "line 1: the columns are separated by tabs: a comma is to stand between them, and a point in numbers");
  CHECK(fault("t,x,x\n") == "line 1: two columns are named \"x\"");
  CHECK(fault("t,x\n0,1\n1,2,3\n") == "line 3: 3 fields where the header has 2 columns");
  CHECK(fault("t,x\n0,1\n1\n") == "line 3: 1 fields where the header has 2 columns");
  CHECK(fault("t,x\n0,1\n\n2,3\n") == "line 3: no value in column \"t\"");
  CHECK(fault("t,x\n0,one\n") == "line 2: \"one\" in column \"x\" is not a number");
  CHECK(fault("t,x\n0,1.5m\n") == "line 2: \"1.5m\" in column \"x\" is not a number");
  CHECK(fault("t,x\n0,nan\n") == "line 2: \"nan\" in column \"x\" is not a number");
  CHECK(fault("t,x\n0,inf\n") == "line 2: \"inf\" in column \"x\" is not a number");
  CHECK(fault("t,x\n0,+-1\n") == "line 2: \"+-1\" in column \"x\" is not a number");
  CHECK(fault("t,x\n0,\n") == "line 2: no value in column \"x\"");
  CHECK(fault("t,\"two\nlines\"\n0,\"1\n") == "line 3: a quote is opened and never closed");
  CHECK(fault("t,x\n0,\"1\"2\n") == "line 2: a comma or the end of the line is missing after a field");
  CHECK(fault("t,x\n0,1\"2\n") == "line 2: a quote inside a field that does not begin with one");
  CHECK(fault("t,x\r0,1\r") == "line 1: a comma or the end of the line is missing after a field");
}
