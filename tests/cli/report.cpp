// bgsim report: what the page holds. That it works in a browser is tested by tests/web.
#include <algorithm>
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The page without what is drawn or run: the texts and tables.
std::string main_of(const std::string& page) {
  const std::size_t begin = page.find("<main"), end = page.find("</main>");
  REQUIRE(begin != std::string::npos);
  REQUIRE(end != std::string::npos);
  return page.substr(begin, end - begin);
}

}  // namespace

TEST_CASE("a report is one page with every section, which asks nobody for anything") {
  const Workplace here;
  const Outcome run = here.bgsim("report decay.json");
  CHECK(run.code == 0);
  CHECK(run.out.empty());
  CHECK_THAT(run.err, Contains("report: decay.first.report.html"));
  const std::string page = here.read("decay.first.report.html");
  for (const char* const id : {"summary", "drawing", "causality", "parameters", "equations", "outputs", "energy",
                               "activity", "statistics", "reproduce"}) {
    CHECK(count(page, "<section id=\"" + std::string(id) + "\">") == 1);
    CHECK(count(page, "<a href=\"#" + std::string(id) + "\">") == 1);
  }
  CHECK_THAT(page, Contains("default-src 'none'"));
  for (const char* const asked : {" src=", "@import", "url(http", "href=\"http", "fetch(", "XMLHttpRequest"})
    CHECK(count(page, asked) == 0);
  const std::string texts = main_of(page);
  CHECK_THAT(texts, Contains("1 state, no dependent stores"));
  CHECK_THAT(texts, Contains("<mover accent=\"true\"><mi>q</mi>"));
  CHECK_THAT(texts, Contains("1 of 1 held"));
  CHECK_THAT(texts, Contains("decay.json:5"));  // where the parameters stand
  CHECK_THAT(texts, Contains("bgsim report decay.json"));
  CHECK_THAT(texts, Contains("bgsim decay.json --scene first --keep-all"));
  CHECK_THAT(page, Contains("\"of\":4"));  // three samples and the reference's, which are not interpolated
}

TEST_CASE("scenes stand side by side, with what differs in each and what the references say") {
  const Workplace here;
  CHECK(here.bgsim("report decay.json --all -o all.html --set C=0.25 --quiet").err.empty());
  const std::string texts = main_of(here.read("all.html"));
  CHECK_THAT(texts, Contains("2 <small>in first, longer</small>"));
  CHECK_THAT(texts, Contains("1 <small>in wrong</small>"));
  CHECK_THAT(texts, Contains("--set C=0.25"));
  CHECK(here.bgsim("report decay.json --scene longer --scene wrong").code == 0);
  CHECK(count(here.read("decay.report.html"), "\"output\":0,\"scene\":1") == 2);  // the curve and its reference
  CHECK_THAT(main_of(here.read("decay.report.html")), Contains("<b>missed</b> at t = 0.5"));
}

TEST_CASE("texts of a model are texts on the page, whatever they hold") {
  const Workplace here;
  std::string model = here.read("decay.json");
  const std::string nasty = "</script><!-- <b>&amp; \\\"'";
  for (const char* const part : {"A capacitor that", "\"unit\": \"C\"", "e, twice", "\"first\""}) {
    const std::size_t at = model.find(part);
    REQUIRE(at != std::string::npos);
    model.insert(at + (std::string(part).rfind("\"unit", 0) == 0 ? 9 : part[0] == '"' ? 1 : 0), nasty);
  }
  here.write("nasty.json", model);
  const Outcome run = here.bgsim("report nasty.json --all -o nasty.html");
  CHECK(run.code == 0);
  const std::string page = here.read("nasty.html");
  CHECK(count(page, "</script>") == 4);  // theme, data, uPlot, page
  CHECK(count(page, "<!--") == 0);
  CHECK(count(page, "<b>&amp;") == 0);
  CHECK(count(page, "&lt;/script&gt;&lt;!-- &lt;b&gt;&amp;amp; &quot;'") > 4);
}

TEST_CASE("a scene that fails is on the page up to there, and the exit code says so") {
  const Workplace here;
  here.write("blow.json", R"json({ "bgsim": 1, "name": "blow",
    "elements": { "feed": { "kind": "MSf", "flow": "tank.q^2" }, "level": { "kind": "0" },
      "tank": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } },
    "bonds": [ { "from": "feed", "to": "level" }, { "from": "level", "to": "tank" } ],
    "outputs": { "q": "tank.q" },
    "scenes": { "short": { "stop": 0.5, "samples": 11 }, "long": { "stop": 2, "samples": 12 } } })json");
  const Outcome run = here.bgsim("report blow.json --all");
  CHECK(run.code == 3);
  CHECK_THAT(run.err, Contains("BG605"));
  const std::string page = here.read("blow.report.html");
  const std::string texts = main_of(page);
  CHECK_THAT(texts, Contains("did not complete"));
  CHECK_THAT(texts, Contains("error BG605"));
  CHECK_THAT(texts, Contains("failed at t = "));
  CHECK_THAT(page, Contains("\"scene\":1,\"t\":7,\"v\":8,\"of\":6}"));  // t = 0 to 0.91
}

TEST_CASE("the wall time of a stage that only one scene of a report has is blank for the others") {
  const Workplace here;
  // With a diode each run has a second one for its errors, unless it has failed.
  here.write("charge.json", R"json({ "bgsim": 1, "name": "charge",
    "elements": { "feed": { "kind": "MSf", "flow": "1 + k*c.q^2" }, "level": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 1 }, "branch": { "kind": "1" }, "d": { "kind": "D" },
      "r": { "kind": "R", "resistance": 1 } },
    "parameters": { "k": 0 },
    "bonds": [ { "from": "feed", "to": "level" }, { "from": "level", "to": "c" }, { "from": "level", "to": "branch" },
      { "from": "branch", "to": "d" }, { "from": "branch", "to": "r" } ],
    "outputs": { "q": "c.q" },
    "scenes": { "tame": { "stop": 1, "samples": 3 },
      "wild": { "stop": 10, "samples": 3, "parameters": { "k": 5 } } } })json");
  const Outcome run = here.bgsim("report charge.json --all");
  CHECK(run.code == 3);
  const std::string texts = main_of(here.read("charge.report.html"));
  const auto cells_of = [&](const std::string& stage) {
    const std::size_t at = texts.find("Wall time: " + stage);
    return at == std::string::npos ? std::size_t{0} : count(texts.substr(at, texts.find("</tr>", at) - at), " ms<");
  };
  CHECK(cells_of("second run") == 1);
  CHECK(cells_of("integration") == 2);
  CHECK(cells_of("modes") == 2);
}

TEST_CASE("studies are on a report's page with what they print and draw, and stay what they are when called alone") {
  const Workplace here;
  const Outcome run = here.bgsim(
      "report decay.json --scene longer -o page.html --set C=0.25 --study poles --study 'step --in R --out q --stop 1' "
      "--study \"sweep --vary R=1:2:3 --result 'end=final(q)'\"");
  CHECK(run.code == 0);
  const std::string texts = main_of(here.read("page.html"));
  CHECK_THAT(texts,
             Contains("<section id=\"studies\">") && Contains("bgsim poles decay.json --scene longer --set C=0.25"));
  // What the page says is what the command says.
  const Outcome alone = here.bgsim("poles decay.json --scene longer --set C=0.25");
  CHECK_THAT(texts, Contains(alone.out.substr(alone.out.rfind('\n', alone.out.size() - 2) + 1)));
  CHECK(count(texts, "<img src=\"data:image/svg+xml;base64,") == 2);
  CHECK(here.has("decay.longer.sweep/results.csv"));
  CHECK(count(here.read("decay.longer.sweep/results.csv"), "completed") == 3);

  // One that fails is on the page with its message, and the rest is there.
  const Outcome faulty =
      here.bgsim("report decay.json -o faulty.html --study 'bode --in nobody --out q' --study poles");
  CHECK(faulty.code == 1);
  CHECK_THAT(faulty.err, Contains("--study 'bode --in nobody --out q':") && Contains("nobody"));
  CHECK_THAT(main_of(here.read("faulty.html")),
             Contains("exit code 1") && Contains("nobody") && Contains("time constant"));
  const Outcome unknown = here.bgsim("report decay.json -o none.html --study pole");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("--study pole: the first word is to be one of bode, check,"));
  CHECK(!here.has("none.html"));
}

TEST_CASE("a report keeps no more samples than asked for, and says so") {
  const Workplace here;
  std::string model = here.read("decay.json");
  model.replace(model.find("\"samples\": 3"), 12, "\"samples\": 100001");
  here.write("long.json", model);
  CHECK(here.bgsim("report long.json -o long.html --points 1000 --set R=1e3").code == 0);
  const std::string page = here.read("long.html");
  CHECK_THAT(main_of(page), Contains("Of 100001 samples a curve, up to 1000 are drawn"));
  CHECK(page.size() < 300'000);
}

TEST_CASE("a report that cannot be written, or of a scene that is not there, is refused before anything is run") {
  const Workplace here;
  CHECK(here.bgsim("report decay.json -o nowhere/x.html").code == 2);
  CHECK(here.bgsim("report decay.json -o decay.json").code == 2);
  CHECK(here.bgsim("report decay.json --all --scene first").code == 2);
  CHECK_THAT(here.bgsim("report decay.json --scene fist").err, Contains("first"));
}
