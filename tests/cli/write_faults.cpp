// Faults at every write: a full disk, a broken one, a quota, calls that a signal cuts short. After each: the old file
// bit for bit as it was or the new one whole, a message and exit code 2 if anything failed, and no stray files.
//
// In the suite kRounds rounds run; BGSIM_FAULT_ROUNDS=N in the environment runs N, BGSIM_FAULT_SEED=S others.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <vector>

#include "command.hpp"

namespace fs = std::filesystem;

namespace {

constexpr int kRounds = 120;  // half a minute; BGSIM_FAULT_ROUNDS=500 takes two to three

struct Case {
  const char* arguments;
  std::vector<const char*> outputs;
  int weight;       ///< how often it is chosen: quick ones more often
  bool same_bytes;  ///< two runs write the same; else what is written holds times
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"decay.json --units --quiet", {"decay.first.csv", "decay.first.units.json"}, 20, true},
      {"decay.json -o out.csv --report-json report.json", {"out.csv", "report.json"}, 20, false},
      {"decay.json --all-scenes", {"decay.first.csv", "decay.longer.csv", "decay.wrong.csv"}, 20, true},
      {"wide.json -o wide.csv --quiet", {"wide.csv"}, 20, true},
      {"decay.json -o link.csv --quiet", {"real.csv"}, 5, true},
      {"new motor -o mine.json --schema", {"mine.json", "model.schema.json"}, 10, true},
      {"draw decay.json -o d.dot", {"d.dot"}, 10, true},
      {"draw decay.json -o d.svg", {"d.svg"}, 4, true},
      {"draw decay.json -o d.png", {"d.png"}, 2, true},
      {"plot trace.csv -o p.svg", {"p.svg"}, 3, true},
      {"reduce two.json -o r.json --csv r.csv --json r.all.json",
       {"r.json", "r.reference.csv", "r.csv", "r.all.json"},
       10,
       false},
      {"report decay.json -o page.html --quiet", {"page.html"}, 4, false},
      {"trade decay.json -o t --no-picture --quiet --budget 0.05", {"t.csv", "t.json", "t.html"}, 2, false},
  };
  return all;
}

constexpr const char* kTwo = R"x({ "bgsim": 1, "name": "two", "elements": {
    "pull": { "kind": "Se", "effort": "sin(t)" }, "line": { "kind": "1" }, "drop": { "kind": "R", "resistance": 1 },
    "small": { "kind": "R", "resistance": 1e-6 }, "store": { "kind": "C", "capacitance": 1 } },
  "bonds": [ { "from": "pull", "to": "line" }, { "from": "line", "to": "drop" }, { "from": "line", "to": "small" },
    { "from": "line", "to": "store" } ],
  "outputs": { "q": "store.q" }, "scenes": { "one": { "stop": 1, "samples": 11 } } })x";

/// A trace of several blocks: writes in the middle of the file, too.
constexpr const char* kWide = R"x({ "bgsim": 1, "name": "wide", "elements": {
    "pull": { "kind": "Se", "effort": "sin(t)" }, "line": { "kind": "1" }, "drop": { "kind": "R", "resistance": 1 },
    "store": { "kind": "C", "capacitance": 1 } },
  "bonds": [ { "from": "pull", "to": "line" }, { "from": "line", "to": "drop" }, { "from": "line", "to": "store" } ],
  "outputs": { "q": "store.q", "e": "drop.e" }, "scenes": { "one": { "stop": 1, "samples": 6001 } } })x";

std::string old_text(const std::string& output) { return "the old " + output + std::string(3000, '.'); }

/// The command with one fault, as the program that has all commands itself: the release's bgsim is linked with an
/// archive of the C library, and nothing comes before that. ("env" comes before the command's own quotes: see
/// Workplace::bgsim.)
Outcome with_fault(const Workplace& here, const std::string& fault, const std::string& arguments) {
  std::error_code none;
  fs::remove(fs::path(here.folder()) / ".calls", none);
  return here.shell("ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" BGSIM_FAULT=" + fault +
                    " BGSIM_FAULT_LOG=.calls LD_PRELOAD='" BGSIM_FAULTS "' '" + bgsim_path() + "-studies' " +
                    arguments);
}

std::vector<std::string> calls(const Workplace& here) {
  std::vector<std::string> lines;
  std::istringstream log(here.has(".calls") ? here.read(".calls") : "");
  for (std::string line; std::getline(log, line);) lines.push_back(line);
  return lines;
}

/// A place where every case can run, with the old targets in it.
class Round {
 public:
  explicit Round(const Case& chosen) : chosen_(chosen) {
    here.write("two.json", kTwo);
    here.write("wide.json", kWide);
    here.write("trace.csv", "t,x\r\n0,1\r\n1,2\r\n2,1.5\r\n");
    fs::create_symlink("real.csv", fs::path(here.folder()) / "link.csv");
    for (const char* output : chosen.outputs)
      if (std::string(output) != "mine.json") here.write(output, old_text(output));  // new overwrites nothing
    before = here.names();
    before.insert("mine.json");
  }
  [[nodiscard]] bool is_old(const std::string& output) const {
    return here.has(output) ? here.read(output) == old_text(output) : output == "mine.json";
  }
  /// @param whole  the same output of a run without faults.
  [[nodiscard]] bool is_new(const std::string& output, const std::string& whole) const {
    if (!here.has(output)) return false;
    const std::string text = here.read(output);
    if (chosen_.same_bytes) return text == whole;
    // Times differ; head, tail and rough size do not.
    const auto tail = [](const std::string& t) { return t.substr(t.size() - std::min<std::size_t>(2, t.size())); };
    return text.substr(0, 5) == whole.substr(0, 5) && tail(text) == tail(whole) && 2 * text.size() > whole.size();
  }

  Workplace here;
  std::set<std::string> before;

 private:
  const Case& chosen_;
};

struct Clean {
  std::map<std::string, std::string> outputs;
  std::vector<std::string> calls;
  std::string out;
};

/// What a case writes and which calls it makes if nothing fails.
const Clean& clean(const Case& chosen) {
  static std::map<const Case*, Clean> known;
  const auto [at, is_new] = known.try_emplace(&chosen);
  if (!is_new) return at->second;
  const Round round(chosen);
  const Outcome done = with_fault(round.here, "any:0:EIO", chosen.arguments);
  INFO(chosen.arguments << "\n" << done.err);
  REQUIRE((done.code == 0 || done.code == 3));  // decay's scene "wrong" fails on purpose
  for (const char* output : chosen.outputs) {
    at->second.outputs[output] = round.here.read(output);
    CHECK_FALSE(round.is_old(output));
  }
  at->second.calls = calls(round.here);
  at->second.out = done.out;
  REQUIRE(at->second.calls.size() > 3);  // otherwise nothing is loaded before the C library, and nothing is tested
  return at->second;
}

void check_round(const Case& chosen, const std::string& fault) {
  INFO(chosen.arguments << " with " << fault);
  const Clean& whole = clean(chosen);
  const Round round(chosen);
  const Outcome done = with_fault(round.here, fault, chosen.arguments);
  INFO("exit code " << done.code << "\n" << done.err);
  const auto log = calls(round.here);
  const bool harmless = fault.ends_with("EINTR") || fault.ends_with("SHORT");
  bool all_new = true;
  for (const char* output : chosen.outputs) {
    const bool is_new = round.is_new(output, whole.outputs.at(output));
    INFO(output);
    CHECK((is_new || round.is_old(output)));
    all_new = all_new && is_new;
  }
  const bool failed = std::any_of(log.begin(), log.end(), [](auto& line) { return line.starts_with("failed"); });
  if (done.code == 2) {
    CHECK(failed);
    CHECK_FALSE(harmless);
    CHECK(done.err.find("cannot write") != std::string::npos);
  } else {
    CHECK((done.code == 0 || done.code == 3));
    CHECK(all_new);
    // What may fail without harm: closing when all is on disk under its own name; making a file in a folder that is
    // read-only, where the target is then overwritten in place.
    for (const std::string& line : log)
      if (!harmless && line.starts_with("failed"))
        CHECK((line == "failed close" || (line == "failed open" && fault.ends_with("EROFS"))));
  }
  for (const std::string& name : round.here.names()) {
    INFO("left behind: " << name);
    // Of a trace, what was written before the fault is kept, and named.
    const bool kept = name.ends_with(".csv.partial") && done.code == 2 && done.err.find(name) != std::string::npos;
    CHECK((round.before.contains(name) || kept));
  }
}

int from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : otherwise;
}

}  // namespace

TEST_CASE("after a fault at any write the old file is as it was or the new one whole, and nothing is left behind",
          "[long]") {
  const int rounds = from_environment("BGSIM_FAULT_ROUNDS", kRounds);
  std::mt19937 random(static_cast<unsigned>(from_environment("BGSIM_FAULT_SEED", 1)));
  std::vector<double> weights;
  for (const Case& each : cases()) weights.push_back(each.weight);
  std::discrete_distribution<std::size_t> pick(weights.begin(), weights.end());
  const std::vector<std::string> errors{"ENOSPC", "EIO", "EDQUOT", "EROFS", "EINTR", "SHORT"};
  for (int i = 0; i < rounds; ++i) {
    // The first rounds meet every case.
    const Case& chosen =
        cases()[static_cast<std::size_t>(i) < cases().size() ? static_cast<std::size_t>(i) : pick(random)];
    const auto& known = clean(chosen).calls;
    const std::string& error = errors[random() % errors.size()];
    check_round(chosen, "any:" + std::to_string(1 + random() % known.size()) + ":" + error);
  }
}
