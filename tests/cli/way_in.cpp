// What meets a newcomer: starter models, pages of messages, completion, examples in every help.
#include <catch2/catch.hpp>
#include <regex>

#include "command.hpp"

namespace {

std::string project_file(const std::string& name) { return bgsim::test::file_text(BGSIM_SOURCE_DIR "/" + name); }

}  // namespace

TEST_CASE("every starter model that new lists is written, runs, and passes its check without a warning") {
  const Workplace place;
  const Outcome list = place.bgsim("new");
  REQUIRE(list.code == 0);
  const std::regex line(R"(\n  ([a-z]+) +\S)");
  int starters = 0;
  for (std::sregex_iterator each(list.out.begin(), list.out.end(), line), end; each != end; ++each, ++starters) {
    const std::string name = (*each)[1];
    INFO(name);
    REQUIRE(place.bgsim("new " + name).code == 0);
    const Outcome check = place.bgsim("check " + name + ".json");
    CHECK(check.code == 0);
    CHECK(check.err.empty());
    const Outcome run = place.bgsim(name + ".json -o trace.csv");
    CHECK(run.code == 0);
    CHECK(run.err.find("warning") == std::string::npos);
    CHECK(place.read("trace.csv").starts_with("t,"));
  }
  CHECK(starters >= 4);
}

TEST_CASE("new overwrites nothing, and writes the schema on request") {
  const Workplace place;
  REQUIRE(place.bgsim("new electric -o mine.json --schema").code == 0);
  CHECK(place.read("mine.json").find("\"$schema\": \"model.schema.json\"") != std::string::npos);
  CHECK(place.read("model.schema.json") == project_file("docs/model.schema.json"));
  CHECK(place.bgsim("mine.json -o -").code == 0);
  const Outcome again = place.bgsim("new motor -o mine.json");
  CHECK(again.code == 2);
  CHECK(again.err.find("mine.json is there already") != std::string::npos);
  const Outcome unknown = place.bgsim("new elektrisch");
  CHECK(unknown.code == 2);
  CHECK(unknown.err.find("no starter model \"elektrisch\"") != std::string::npos);
}

TEST_CASE("explain prints the page of a code however it is written, and lists all codes") {
  const Workplace place;
  const std::string page = place.bgsim("explain BG301").out;
  CHECK(page.starts_with("## BG301 "));
  CHECK(project_file("docs/errors.md").find(page.substr(0, page.size() - 1)) != std::string::npos);
  CHECK(place.bgsim("explain bg301").out == page);
  CHECK(place.bgsim("explain 301").out == page);
  const std::string all = place.bgsim("explain").out;
  CHECK(all.find("BG101 The file is not JSON\n") != std::string::npos);
  const Outcome unknown = place.bgsim("explain BG999");
  CHECK(unknown.code == 2);
  CHECK(unknown.err.find("there is no message BG999") != std::string::npos);
}

TEST_CASE("bash completes commands, options, scenes and models") {
  const Workplace place;
  place.write("complete.sh", R"sh(PATH="$(dirname "$1"):$PATH"
source completion.bash
COMP_WORDS=("${@:2}"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_bgsim
printf '%s\n' "${COMPREPLY[@]}"
)sh");
  REQUIRE(place.bgsim("completion bash", "> completion.bash").code == 0);
  REQUIRE(place.bgsim("new mechanical").code == 0);
  const auto complete = [&](const std::string& words) {
    return "\n" + place.bgsim("--version", "> .version; bash complete.sh '" + bgsim_path() + "' bgsim " + words).out;
  };
  CHECK(complete("equa").find("\nequations\n") != std::string::npos);
  CHECK(complete("mech").find("\nmechanical.json\n") != std::string::npos);
  CHECK(complete("equations --la").find("\n--latex\n") != std::string::npos);
  CHECK(complete("mechanical.json --scene so").find("\nsoft\n") != std::string::npos);
  CHECK(complete("explain BG30").find("\nBG301\n") != std::string::npos);
  const Outcome unknown = place.bgsim("completion tcsh");
  CHECK(unknown.code == 2);
}

TEST_CASE("the help of every command shows examples") {
  const Workplace place;
  const std::vector<std::string> names = command_names(place.bgsim("--help").out);
  for (const std::string& name : names) {
    INFO(name);
    CHECK(place.bgsim(name + " --help").out.find("Example") != std::string::npos);
  }
  CHECK(names.size() >= 10);
}
