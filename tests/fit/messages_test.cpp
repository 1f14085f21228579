// What is asked for and cannot be fitted, each with its message: tests/fit/messages.txt. BGSIM_UPDATE_GOLDEN=1 rewrites
// the file; the difference is then to be reviewed.
#include <catch2/catch.hpp>

#include "fit_support.hpp"
#include "support/files.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Rows of the capacitor: "t,u,i".
const char* const kRows = "t,u,i\n0,0.5,1.2\n0.5,1.5,0.7\n1,2.1,0.4\n1.5,2.5,0.2\n";

struct Asked {
  std::vector<std::string> vary = {};
  std::string text = kRows;
  std::vector<FitMatch> matches = {{"u", "u", 0.0}};
  std::string time = {};
  std::vector<std::string> set = {};
  FitLoss loss = FitLoss::squares;
  std::uint64_t global_runs = 0;
};

std::string message(const Asked& asked) {
  try {
    const Study study = Study::from_text(capacitor());
    FitPlan plan;
    for (const std::string& each : asked.vary) plan.vary.push_back(parse_fit_variation(each));
    plan.matches = asked.matches;
    plan.time = asked.time;
    plan.loss = asked.loss;
    plan.loss_at = 1.0;
    plan.global_runs = asked.global_runs;
    plan.data = {fit_data("", "rows.csv", asked.text)};
    fit(study, plan, with_parameters(asked.set));
  } catch (const ModelError& error) {
    return render(error);
  }
  return "no message\n";
}

}  // namespace

TEST_CASE("what cannot be fitted gets its message") {
  const std::vector<std::pair<std::string, Asked>> all{
      {"nothing is varied", {{}}},
      {"an unknown parameter", {{"Q"}}},
      {"an output", {{"u"}}},
      {"a setting of the scene", {{"scene.stop"}}},
      {"a computed parameter", {{"tau"}}},
      {"a parameter that --set computes", {{"R"}, kRows, {{"u", "u"}}, "", {"R=2*C"}}},
      {"one twice", {{"R", "R=1:3"}}},
      {"two initial values of one store", {{"c.q", "c.e"}}},
      {"no range", {{"R=3"}}},
      {"words", {{"R=a:b"}}},
      {"an infinite bound", {{"R=1:inf"}}},
      {"three bounds", {{"R=1:2:3"}}},
      {"an empty range", {{"R=3:3"}}},
      {"a reversed range", {{"R=5:1"}}},
      {"no name", {{"=1:3"}}},
      {"a start below the range", {{"R=3:5"}}},
      {"a start above the range that --set gives", {{"R=3:5"}, kRows, {{"u", "u"}}, "", {"R=7"}}},
      {"a global search without a range", {{"R"}, kRows, {{"u", "u"}}, "", {}, FitLoss::squares, 10}},
      {"no match", {{"R"}, kRows, {}}},
      {"an unknown column", {{"R"}, kRows, {{"u", "v"}}}},
      {"a column nearly so", {{"R"}, "t,voltage\n0,1\n1,2\n", {{"u", "voltge"}}}},
      {"an unknown output", {{"R"}, kRows, {{"w", "u"}}}},
      {"a match twice", {{"R"}, kRows, {{"u", "u"}, {"u", "u"}}}},
      {"a standard deviation of some", {{"R"}, kRows, {{"u", "u", 0.1}, {"i", "i"}}}},
      {"a loss without a scale", {{"R"}, kRows, {{"u", "u"}}, "", {}, FitLoss::huber}},
      {"an unknown column of times", {{"R"}, kRows, {{"u", "u"}}, "time"}},
      {"an empty file", {{"R"}, ""}},
      {"a header alone", {{"R"}, "t,u\n"}},
      {"a row of another length", {{"R"}, "t,u\n0,1\n1\n"}},
      {"a word in a cell", {{"R"}, "t,u\n0,1\n1,two\n"}},
      {"a decimal comma", {{"R"}, "t,u\n0,\"1,5\"\n1,2\n"}},
      {"units in the second line", {{"R"}, "t,u\ns,V\n0,1\n"}},
      {"an infinite cell", {{"R"}, "t,u\n0,inf\n1,2\n"}},
      {"no time in a row", {{"R"}, "t,u\n0,1\n,2\n"}},
      {"times that go back", {{"R"}, "t,u\n0,1\n1,2\n0.5,1.5\n"}},
      {"a time twice", {{"R"}, "t,u\n0,1\n1,2\n1,2\n"}},
      {"data before the scene", {{"R"}, "t,u\n-5,1\n-4,2\n"}},
      {"data in milliseconds", {{"R"}, "t,u\n500,1\n1000,2\n"}},
      {"a column without numbers", {{"R"}, "t,u\n0,\n1,\n"}},
      {"fewer rows than values", {{"R", "U", "c.q"}, "t,u\n0,1\n1,2\n"}},
      {"a parameter without influence", {{"R"}, kRows, {{"s", "u"}}}},
      {"one of two without influence", {{"U", "c.q"}, kRows, {{"s", "u"}}}},
      {"no run at the start", {{"C"}, kRows, {{"u", "u"}}, "", {"C=0"}}},
  };
  std::string text;
  for (const auto& [what, asked] : all) text += "== " + what + "\n" + message(asked) + "\n";
  CHECK(text.find("no message") == std::string::npos);
  const std::string golden = std::string(BGSIM_SOURCE_DIR) + "/tests/fit/messages.txt";
  if (text == file_text(golden)) return;
  CHECK(text == file_text(golden));
  if (update_goldens()) write_file(golden, text);
}
