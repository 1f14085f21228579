// Ctrl-C, kill and a closed terminal: exit code 3, a message, no partial files, old targets whole.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"

using Catch::Contains;
namespace fs = std::filesystem;

namespace {

/// A command with work for minutes, and what it says when it is interrupted.
struct LongWork {
  const char* arguments;
  const char* target;
  bool keeps;  ///< what it has so far is written to the target
  const char* says;
};

const std::vector<LongWork> kWorks{
    {"ring.json -o out", "out", true, "trace up to there: out"},
    {"ring.json --accuracy 1e-7 -o out", "out", false, "interrupted"},
    {"report ring.json -o out", "out", true, "interrupted"},
    {"reduce ring.json -o out", "out", false, "interrupted"},
    {"trade ring.json --no-picture --budget 1000 -o out", "out.csv", true, "interrupted"},
    {"verify held.json", "out", false, "interrupted"},
    {"check long.json", "out", false, "interrupted"},
    {"draw long.json -o out.svg", "out.svg", false, "interrupted"},
};

/// A ladder that takes Graphviz and the reader seconds.
std::string ladder(int stages) {
  std::string elements, bonds;
  for (int i = 0; i < stages; ++i) {
    const std::string n = std::to_string(i);
    elements += "\"s" + n + "\": { \"kind\": \"1\" }, \"p" + n + "\": { \"kind\": \"0\" }, \"r" + n +
                "\": { \"kind\": \"R\", \"resistance\": 1 }, \"c" + n +
                "\": { \"kind\": \"C\", \"capacitance\": 1 },\n";
    bonds += "{ \"from\": \"" + (i == 0 ? std::string("source") : "p" + std::to_string(i - 1)) + "\", \"to\": \"s" + n +
             "\" }, { \"from\": \"s" + n + "\", \"to\": \"r" + n + "\" }, { \"from\": \"s" + n + "\", \"to\": \"p" + n +
             "\" }, { \"from\": \"p" + n + "\", \"to\": \"c" + n + "\" },\n";
  }
  bonds.resize(bonds.size() - 2);
  return R"({ "bgsim": 1, "name": "long", "elements": {)" + elements +
         R"("source": { "kind": "Se", "effort": 1 } }, "bonds": [)" + bonds +
         R"(], "outputs": { "q": "c0.q" }, "scenes": { "s": { "stop": 1 } } })";
}

void prepare(const Workplace& here) {
  here.write("long.json", ladder(6000));
  std::string held = here.read("ring.json");
  const std::string stop = "\"stop\":";
  held.insert(held.find(stop), "\"reference\": \"held.csv\", ");
  here.write("held.json", held);
  here.write("held.csv", "t,x\r\n0,0\r\n600000,1\r\n");
}

/// Interrupts after @p seconds, once: without --foreground the signal goes to the process and to its group, and a
/// second one ends a run at once. A process that had not begun yet (a busy machine) is given longer.
Outcome interrupted(const Workplace& here, const std::string& signal, double seconds, const std::string& arguments) {
  for (;; seconds *= 3.0) {
    Outcome done = here.shell("timeout --foreground --preserve-status -s " + signal + " " + std::to_string(seconds) +
                              " '" + bgsim_path() + "' " + arguments);
    if (done.code < 128 || seconds > 20.0) return done;
  }
}

/// Interrupts the work, sooner where it is done before the signal comes, and checks what is left.
void check_interrupted(const LongWork& work, const char* signal, double seconds) {
  constexpr double kShortest = 1e-3;
  for (;; seconds /= 4.0) {
    INFO(work.arguments << ", " << signal << " after " << seconds << " s");
    const Workplace here;
    prepare(here);
    here.write(work.target, "old");
    const auto before = here.names();
    const Outcome done = interrupted(here, signal, seconds, work.arguments);
    if (done.code == 0 && seconds > kShortest) continue;
    INFO(done.err);
    CHECK(done.code == 3);
    CHECK_THAT(done.err, Contains("interrupted") || Contains(work.says));
    if (!work.keeps) CHECK(here.read(work.target) == "old");
    for (const std::string& name : here.names()) {
      INFO("left behind: " << name);
      CHECK((before.contains(name) || name.starts_with("out.")));
      CHECK_FALSE(name.ends_with(".partial"));
    }
    return;
  }
}

}  // namespace

TEST_CASE("every command that is interrupted ends with exit code 3 and a message and leaves nothing behind", "[long]") {
  for (const LongWork& work : kWorks) {
    for (const char* signal : {"INT", "TERM", "HUP"}) {
      for (const double moment : {0.1, 0.5}) {
        if (moment < 0.2 && std::string(signal) == "HUP") continue;
        check_interrupted(work, signal, moment);
      }
    }
  }
}

TEST_CASE("a search for an accuracy that is interrupted says so and writes nothing") {
  const Workplace here;
  here.write("out.csv", "old");
  const Outcome done = interrupted(here, "TERM", 1.0, "ring.json --accuracy 1e-7 -o out.csv");
  CHECK(done.code == 3);
  CHECK_THAT(done.err, Contains("the search for --accuracy was interrupted"));
  CHECK(here.read("out.csv") == "old");
}

TEST_CASE("after an interruption no further scene runs") {
  const Workplace here;
  std::string text = here.read("ring.json");
  const auto at = text.find("\"scenes\": {") + 11;
  here.write("scenes.json", text.insert(at, R"( "before": { "stop": 6e6, "samples": 3 },)"));
  // On a busy machine the signal may come before the first scene runs.
  Outcome done;
  for (double seconds = 0.6; seconds < 30.0 && !here.has("ring.before.csv"); seconds *= 3.0)
    done = interrupted(here, "TERM", seconds, "scenes.json --all-scenes");
  CHECK(done.code == 3);
  CHECK(here.has("ring.before.csv"));
  const auto names = here.names();
  CHECK(std::count_if(names.begin(), names.end(), [](const std::string& name) {
          return name.starts_with("ring.") && name.ends_with(".csv");
        }) == 1);
}
