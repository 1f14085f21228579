// Names that somebody chose so that another program would act on them. The generator of many more is
// tests/contracts/hostile.py.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

namespace {

/// A model with one name for itself, its scene and its output. @p name is the inside of a JSON string.
std::string named(const std::string& name) {
  return R"({ "bgsim": 1, "name": ")" + name + R"(", "elements": { "r": { "kind": "R", "resistance": 1 },
  "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } }, "bonds": [ { "from": "c", "to": "r" } ],
  "outputs": { ")" +
         name + R"(": { "value": "c.e", "unit": "V" } }, "scenes": { ")" + name +
         R"(": { "stop": 1, "samples": 5 } } })";
}

}  // namespace

TEST_CASE("a picture of a trade runs nothing that a name asks for, and shows the name") {
  const Workplace here;
  for (const std::string name : {"x'; system('touch PWNED'); #", "'; system('touch PWNED'); #", "`touch PWNED`",
                                 "Watt's governor", "x\\n system('touch PWNED')\\n"}) {
    here.write("m.json", named(name));
    CHECK(here.bgsim("trade m.json --budget 0.05 --quiet -o it").code == 0);
    CHECK_FALSE(here.has("PWNED"));
    const std::string shown = name.find("system") != std::string::npos ? "touch PWNED" : name;
    CHECK_THAT(here.read("it.svg"), Contains(shown));
  }
}

TEST_CASE("a plot runs nothing that a column's name or a title asks for") {
  const Workplace here;
  here.write("a.csv", "t,\"x'; system('touch PWNED'); #\",\"`touch PWNED`\",\"\x1b\n\"\n0,1,2,3\n1,2,3,4\n");
  CHECK(here.bgsim("plot a.csv --title \"'; system('touch PWNED') #\"").code == 0);
  CHECK_FALSE(here.has("PWNED"));
  CHECK_THAT(here.read("a.svg"), Contains("\\x1b\\n") && Contains("`touch PWNED`") && !Contains("\x1b"));
}

TEST_CASE("settings and programs beside a model are not used") {
  const Workplace here;
  here.write(".gnuplot", "system('touch PWNED')\n");
  here.write("gnuplot", "#!/bin/sh\ntouch PWNED\n");
  here.write("a.csv", "t,x\n0,1\n1,2\n");
  CHECK(here.bgsim("plot a.csv", "; chmod +x gnuplot").code == 0);
  const Outcome outcome = here.bgsim("--version", "; PATH=:.:$PATH '" + bgsim_path() + "' plot a.csv");
  CHECK(outcome.code == 0);
  CHECK_FALSE(here.has("PWNED"));
}

TEST_CASE("units beside a trace are JSON for a name with a line break, and its plot reads them") {
  const Workplace here;
  here.write("m.json", named("a\\n\\u0000b"));
  CHECK(here.bgsim("m.json --units -o x.csv --quiet").code == 0);
  CHECK(here.read("x.units.json") == "{\n  \"a\\n\\u0000b\": \"V\"\n}\n");
  CHECK_THAT(here.bgsim("plot x.csv -o -").out, Contains("a\\n\\x00b") && Contains("<text>V</text>"));
}

TEST_CASE("a name neither rules the terminal nor forges a line of what is printed") {
  const Workplace here;
  here.write("m.json", named("a\\u001b[31m\\nerror BG000\\u009b\\u202e"));
  for (const char* command : {"run m.json", "check m.json", "equations m.json", "show --stage model m.json",
                              "show --stage equations m.json", "verify m.json", "reduce m.json", "report m.json",
                              "trade m.json --budget 0.05 --no-picture", "run m.json --set 'x\x1b[31m=1'"}) {
    INFO(command);
    const Outcome outcome = here.bgsim(command);
    for (const std::string& text : {outcome.out, outcome.err}) {
      CHECK(text.find_first_of("\x1b\r") == std::string::npos);
      CHECK(text.find("\u009b") == std::string::npos);
      CHECK(text.find("\u202e") == std::string::npos);
      CHECK(text.find("\nerror BG000") == std::string::npos);
    }
  }
  CHECK_THAT(here.bgsim("run m.json").err, Contains("a\\x1b[31m\\nerror BG000\\u{9b}\\u{202e}"));
}

TEST_CASE("data on standard output hold a name as it is") {
  const Workplace here;
  here.write("m.json", named("=cmd|' /C calc'!A0\\n\\u001b"));
  CHECK_THAT(here.bgsim("m.json -o - --quiet").out, Catch::StartsWith("t,\"=cmd|' /C calc'!A0\n\x1b\"\r\n"));
}

TEST_CASE("a name of a million characters makes short messages and a file's name that the system takes", "[long]") {
  const Workplace here;
  here.write("m.json", named(std::string(1000000, 'n')));
  const Outcome run = here.bgsim("m.json");
  CHECK(run.code == 0);
  CHECK(run.err.size() < 4000);
  CHECK_THAT(run.err, Contains("nnn...nnn") && Contains(" (1000000 characters)"));
  CHECK(here.bgsim("check m.json").out.size() < 4000);
  CHECK(here.bgsim("--version", "; ls | grep -c '^n\\{100,\\}_[0-9a-f]\\{16\\}.csv$'").out.ends_with("\n1\n"));
}

TEST_CASE("what is written for a name stays in the working folder, in sight and no option") {
  const Workplace here;
  for (const std::string name : {"../../x", "/tmp/x", "-rf", ".hidden", "a\\u0000\\nb"}) {
    here.write("m.json", named(name));
    CHECK(here.bgsim("m.json --quiet").code == 0);
  }
  CHECK(here.has("_._.._x..._.._x.csv"));
  CHECK(here.has("_tmp_x._tmp_x.csv"));
  CHECK(here.has("_rf.-rf.csv"));
  CHECK(here.has("_hidden..hidden.csv"));
  CHECK(here.has("a__b.a__b.csv"));
}

TEST_CASE("LaTeX takes a name as text, and a comment holds it to its end") {
  const Workplace here;
  here.write("m.json", named("p_1 \\\\input{x}^^5c%\\n$"));
  const std::string latex = here.bgsim("equations --latex m.json").out;
  CHECK_THAT(latex, Catch::StartsWith("% p_1 \\input{x}^^5c%\\n$\n"));
  CHECK_THAT(latex, Contains("\\text{p\\_1 \\textbackslash{}input\\{x\\}\\textasciicircum{}\\textasciicircum{}5c\\%"
                             "\\textbackslash{}n\\$}"));
}

TEST_CASE("completing a scene's name runs nothing that it says") {
  const Workplace here;
  here.write("m.json", named("$(touch${IFS}PWNED)`touch PWNED`"));
  here.write("complete.sh", R"sh(PATH="$(dirname "$1"):$PATH"
source completion.bash
COMP_WORDS=(bgsim m.json --scene ''); COMP_CWORD=3
_bgsim
printf '%s\n' "${COMPREPLY[@]}"
)sh");
  REQUIRE(here.bgsim("completion bash", "> completion.bash").code == 0);
  CHECK_THAT(here.bgsim("--version", "> .version; bash complete.sh '" + bgsim_path() + "'").out,
             Contains("$(touch${IFS}PWNED)`touch PWNED`\n"));
  CHECK_FALSE(here.has("PWNED"));
}

TEST_CASE("a command that a message proposes is one word for each argument") {
  const Workplace here;
  CHECK_THAT(here.bgsim("new mechanical -o 'it'\\''s; x.json'").out,
             Contains("next: bgsim 'it'\\''s; x.json', bgsim check"));
  CHECK_THAT(here.bgsim("new mechanical -o \"$(printf 'a\\033b.json')\"").out, Contains("next: bgsim $'a\\033b.json'"));
}

TEST_CASE("Graphviz takes the name of a model as text") {
  const Workplace here;
  here.write("m.json", named("\\\"; a -> b \\\\N &lt; \\n"));
  CHECK(here.bgsim("draw m.json -o x.dot").code == 0);
  CHECK_THAT(here.read("x.dot"), Contains(R"(digraph "\"; a -> b \\N &amp;lt; \\n" {)"));
}

TEST_CASE("Graphviz reads a drawing whose names are longer than its longest string") {
  const Workplace here;
  const std::string longer(20000, 'a');
  here.write("m.json", R"({ "bgsim": 1, "name": "m", "elements": {
  ")" + longer + R"(1": { "kind": "Se", "effort": 1 }, ")" +
                           longer + R"(2": { "kind": "R", "resistance": 1 } },
  "bonds": [{ "from": ")" + longer +
                           R"(1", "to": ")" + longer + R"(2" }] })");
  CHECK(here.bgsim("draw m.json -o x.svg").code == 0);
  REQUIRE(here.bgsim("draw m.json -o x.dot").code == 0);
  // Two nodes and one edge: the names are cut, and still differ.
  CHECK_THAT(here.shell("dot -Tplain x.dot | cut -d ' ' -f 1 | sort | uniq -c | tr -s ' '").out,
             Contains(" 1 edge\n 1 graph\n 2 node\n"));
}

TEST_CASE("a program that bgsim has started ends with it and leaves nothing behind", "[long]") {
  const Workplace here;
  here.write("a.csv", "t,x\n0,1\n1,2\n");
  here.write("gnuplot", "#!/bin/sh\necho $$ >'" + here.folder() + "/pid'\nexec sleep 100\n");
  const Outcome outcome = here.bgsim(
      "--version",
      "; mkdir bin scratch; mv gnuplot bin; chmod +x bin/gnuplot; TMPDIR=$PWD/scratch PATH=\"$PWD/bin:$PATH\" "
      "timeout --foreground 3 '" +
          bgsim_path() + "' plot a.csv; echo code $?; kill -0 $(cat pid) 2>/dev/null && echo alive; ls scratch");
  CHECK_THAT(outcome.out, Catch::EndsWith("\ncode 124\n"));
  CHECK_FALSE(here.has("a.svg"));
}
