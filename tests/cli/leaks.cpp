// Under the address sanitizer looking for leaks is half of what a command takes, so the other tests of the command
// leave it out (tests/CMakeLists.txt). Here each command is asked for it, once where it succeeds and once where it does
// not.
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace {

const std::map<std::string, std::string> kArguments = {
    {"run", "decay.json"},
    {"check", "decay.json"},
    {"equations", "decay.json"},
    {"draw", "decay.json"},
    {"plot", "decay.csv"},
    {"linearize", "decay.json"},
    {"poles", "decay.json"},
    {"control", "fed.json --in feed --out q"},
    {"transfer", "fed.json --in feed --out q"},
    {"zeros", "fed.json --in feed --out q"},
    {"bode", "fed.json --impedance feed"},
    {"step", "fed.json --in feed --out q"},
    {"steady", "decay.json"},
    {"show", "decay.json --stage program"},
    {"reduce", "decay.json"},
    {"report", "decay.json"},
    {"trade", "decay.json --budget 1"},
    {"sweep", "decay.json --vary R=1,2 --picture"},
    {"sensitivity", "decay.json --of q --to R"},
    {"fit", "decay.json decay.csv --match q=q --vary R=1:3"},
    {"verify", "decay.json"},
    {"new", "electric"},
    {"explain", "BG101"},
    {"completion", "bash"},
};

/// Linear analysis needs an input.
constexpr const char* kFed = R"x({ "bgsim": 1, "name": "fed", "elements": {
    "feed": { "kind": "Se", "effort": 1 }, "line": { "kind": "1" }, "drop": { "kind": "R", "resistance": 1 },
    "store": { "kind": "C", "capacitance": 1 } },
  "bonds": [ { "from": "feed", "to": "line" }, { "from": "line", "to": "drop" }, { "from": "line", "to": "store" } ],
  "outputs": { "q": "store.q" }, "scenes": { "one": { "stop": 1, "samples": 11 } } })x";

Outcome looking_for_leaks(const Workplace& here, const std::string& arguments) {
  return here.shell("ASAN_OPTIONS=\"$ASAN_OPTIONS:detect_leaks=1\" '" + bgsim_path() + "' " + arguments);
}

}  // namespace

TEST_CASE("no command leaks memory") {
  const Workplace here;
  here.write("fed.json", kFed);
  here.write("faulty.json", R"({ "bgsim": 1, "name": "faulty", "elements": { "a": { "kind": "Q" } }, "bonds": [] })");
  const std::vector<std::string> names = command_names(here.bgsim("--help").out);
  CHECK(names.size() == kArguments.size());
  for (const std::string& name : names) {
    INFO(name);
    const auto known = kArguments.find(name);
    REQUIRE(known != kArguments.end());
    const Outcome right = looking_for_leaks(here, name + " " + known->second);
    CHECK(right.err.find("Sanitizer") == std::string::npos);
    CHECK(right.code == (name == "verify" ? 1 : 0));  // one of its three scenes is wrong on purpose
    const Outcome wrong = looking_for_leaks(here, name + " faulty.json --scene none");
    CHECK(wrong.err.find("Sanitizer") == std::string::npos);
    CHECK((wrong.code == 1 || wrong.code == 2));
  }
}
