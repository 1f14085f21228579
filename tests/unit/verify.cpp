#include "bgsim/verify.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "base/document.hpp"
#include "support/files.hpp"

using namespace bgsim;

namespace {

Model model_without_files() {
  Model model;
  model.sources = std::make_shared<const Sources>();
  return model;
}

/// x at times 0, 1, 2, ...
Trace trace_of(std::vector<double> x) {
  Trace trace{{"x"}, {""}, {}, {std::move(x)}};
  for (std::size_t i = 0; i < trace.columns[0].size(); ++i) trace.times.push_back(static_cast<double>(i));
  return trace;
}

Reference reference_with(double relative, double absolute, double tube = 0.0) {
  Reference reference;
  reference.file = "reference.csv";
  reference.relative = relative;
  reference.absolute = absolute;
  reference.tube = tube;
  return reference;
}

ColumnCheck check_x(const std::vector<double>& x, const std::string& csv, const Reference& reference) {
  return hold_against(model_without_files(), trace_of(x), parse_csv(csv), reference).columns.at(0);
}

/// The code and situation of the error that @p act throws.
template <class Act>
std::string fault(const Act& act) {
  try {
    act();
  } catch (const ModelError& error) {
    return error.diagnostics.at(0).code + ": " + error.diagnostics.at(0).situation;
  }
  return "none";
}

/// read_reference on a file with this text.
std::string fault_in(const std::string& text) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "reference.csv";
  folder.write("reference.csv", text);
  Reference reference = reference_with(0, 0);
  reference.file = path.string();
  std::string found = fault([&] { read_reference(model_without_files(), reference); });
  const std::size_t at = found.find(path.string());
  return at == std::string::npos ? found : found.replace(at, path.string().size(), "F");
}

}  // namespace

TEST_CASE("the limit is relative to the column's largest magnitude, plus the absolute part") {
  const ColumnCheck check = check_x({0.5, 4.0, 0.0}, "t,x\n0,0\n1,-4\n2,1\n", reference_with(0.25, 0.5));
  CHECK(check.limit == 1.5);
  CHECK(check.error == 8.0);
  CHECK(check.time == 1.0);
  CHECK(check.value == 4.0);
  CHECK(check.low == -4.0);
  CHECK(check.high == -4.0);
  CHECK_FALSE(check.ok());
}

TEST_CASE("an error as large as the limit is accepted, a larger one is not") {
  CHECK(check_x({0.5, 1.0}, "t,x\n0,0\n1,1\n", reference_with(0.0, 0.5)).ok());
  CHECK_FALSE(check_x({0.5000001, 1.0}, "t,x\n0,0\n1,1\n", reference_with(0.0, 0.5)).ok());
}

TEST_CASE("a jump that comes a little late is accepted within the tube of time, and only there") {
  const std::string jump = "t,x\n0,0\n1,0\n2,1\n3,1\n";
  const std::vector<double> late = {0.0, 0.0, 0.0, 1.0};
  CHECK(check_x(late, jump, reference_with(0.0, 0.0)).error == 1.0);
  CHECK(check_x(late, jump, reference_with(0.0, 0.0, 1.0)).error == 0.0);
  // With half the distance the reference, linear between its records, comes down to 0.5 within the tube.
  CHECK(check_x(late, jump, reference_with(0.0, 0.0, 0.5)).error == 0.5);
}

TEST_CASE("the tube ends where the reference ends") {
  CHECK(check_x({2.0, 1.0}, "t,x\n0,0\n1,1\n", reference_with(0.0, 0.0, 100.0)).error == 1.0);
}

TEST_CASE("a value that is not a number is never accepted, whatever comes after it") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(check_x({nan, 1.0, 2.0}, "t,x\n0,0\n1,1\n2,2\n", reference_with(1.0, 1.0)).ok());
}

TEST_CASE("outputs are paired by name or as the scene says, and unused columns are reported") {
  Reference reference = reference_with(0, 0);
  reference.columns = {{"x", "b"}};
  const auto check = hold_against(model_without_files(), trace_of({1.0}), parse_csv("t,x,b\n0,7,1\n"), reference);
  REQUIRE(check.columns.size() == 1);
  CHECK(check.columns[0].reference == "b");
  CHECK(check.ok());
  CHECK(check.unused == std::vector<std::string>{"x"});
}

TEST_CASE("a reference that shares no column, or lacks one that is named, is an error and no pass") {
  const auto against = [](const std::string& csv, const Reference& reference) {
    return fault([&] { hold_against(model_without_files(), trace_of({1.0}), parse_csv(csv), reference); });
  };
  CHECK(against("t,y\n0,1\n", reference_with(0, 0)) ==
        "BG152: no output of the scene is a column of reference \"reference.csv\"");
  Reference reference = reference_with(0, 0);
  reference.columns = {{"x", "z"}};
  CHECK(against("t,x\n0,1\n", reference) == "BG152: reference \"reference.csv\" has no column \"z\"");
  reference.columns = {{"w", "x"}};
  CHECK(against("t,x\n0,1\n", reference) == "BG152: the scene has no output \"w\" to compare with a reference");
}

TEST_CASE("a reference is read strictly") {
  CHECK(fault_in("t,x\n0,1\n1,2\n") == "none");
  CHECK(fault_in("x,t\n0,1\n") == "BG150: reference \"F\": the first column is not named t");
  CHECK(fault_in("t,x\n") == "BG150: reference \"F\": there are no records");
  CHECK(fault_in("t,x\n0,1\n0,2\n") == "BG150: reference \"F\": t = 0 comes after t = 0");
  CHECK(fault_in("t,x\n0,1\n1,two\n") == "BG150: reference \"F\": line 3: \"two\" in column \"x\" is not a number");
  Reference reference = reference_with(0, 0);
  reference.file = "/nowhere/reference.csv";
  CHECK(fault([&] { read_reference(model_without_files(), reference); }) ==
        "BG150: reference \"/nowhere/reference.csv\": there is no such file");
}

TEST_CASE("a scene is run at its reference's times, from its own start") {
  RunInputs inputs;
  inputs.scene = "fall";
  inputs.stop = 10.0;
  inputs.output_times = {0.0, 10.0};
  inputs.reference = reference_with(0, 0);
  const RunInputs adapted = at_reference_times(model_without_files(), inputs, parse_csv("t,x\n1,0\n2,0\n"));
  CHECK(adapted.output_times.list() == std::vector<double>{0.0, 1.0, 2.0});
  CHECK(adapted.stop == 2.0);
  // The row at the start is not compared: the reference does not have it.
  const Trace trace{{"x"}, {""}, adapted.output_times.list(), {{99.0, 5.0, 6.0}}};
  CHECK(hold_against(model_without_files(), trace, parse_csv("t,x\n1,5\n2,6\n"), reference_with(0, 0)).ok());
}

TEST_CASE("a reference beyond the scene's times is an error") {
  RunInputs inputs;
  inputs.scene = "fall";
  inputs.stop = 1.0;
  inputs.reference = reference_with(0, 0);
  CHECK(fault([&] { at_reference_times(model_without_files(), inputs, parse_csv("t,x\n0,0\n2,0\n")); }) ==
        "BG151: scene \"fall\" runs from 0 to 1, its reference from 0 to 2");
}

TEST_CASE("a reference's band is what is accepted at each of its times") {
  const CsvTable table = parse_csv("t,x,other\n0,0,1\n1,10,1\n2,10,1\n");
  const Reference reference = reference_with(0.1, 0.5, 0.5);
  const std::vector<ReferenceBand> bands = reference_bands(model_without_files(), {"y", "x"}, table, reference);
  REQUIRE(bands.size() == 1);
  CHECK(bands[0].output == "x");
  CHECK(bands[0].limit == 1.5);
  CHECK(bands[0].values == std::vector<double>{0, 10, 10});
  CHECK(bands[0].low == std::vector<double>{-1.5, 3.5, 8.5});  // halfway to the neighbour at 0, less the limit
  CHECK(bands[0].high == std::vector<double>{6.5, 11.5, 11.5});
  for (std::size_t row = 0; row < 3; ++row) {
    std::vector<double> x{0, 10, 10};
    x[row] = bands[0].high[row];
    CHECK(hold_against(model_without_files(), trace_of(x), parse_csv("t,x\n0,0\n1,10\n2,10\n"), reference).ok());
    x[row] += 1e-9;
    CHECK(!hold_against(model_without_files(), trace_of(x), parse_csv("t,x\n0,0\n1,10\n2,10\n"), reference).ok());
  }
}

TEST_CASE("the root mean square of errors is finite where their squares are not") {
  const Trace zero{.names = {"x"}, .units = {""}, .times = {0.0, 1.0, 2.0, 3.0}, .columns = {{0.0, 0.0, 1.0, 0.0}}};
  Trace unstable = zero;
  unstable.columns[0] = {3e200, 0.0, 1.0, 4e200};
  const OutputError error = output_errors(zero, unstable).front();
  CHECK(error.error == 4e200);
  CHECK(error.rms == Approx(2.5e200).epsilon(1e-14));  // sqrt((9 + 16)/4)
}
