// bgsim plot: pictures of traces, differences, extremes of long ones, refusals.
#include <catch2/catch.hpp>
#include <sstream>

#include "command.hpp"

using Catch::Contains;

TEST_CASE("a trace is drawn as SVG or PNG, with the units of its side-car") {
  const Workplace here;
  here.write("a.csv", "t,x,y,p\n0,1,2,100\n1,2,1,200\n2,1.5,0,150\n");
  here.write("a.units.json", R"({ "x": "m", "y": "m", "p": "Pa" })");
  CHECK(here.bgsim("plot a.csv").code == 0);
  const std::string svg = here.read("a.svg");
  CHECK_THAT(svg, Contains(">x</text>") && Contains(">y</text>") && Contains(">p</text>"));
  CHECK_THAT(svg, Contains(">m</text>") && Contains(">Pa</text>") && Contains(">a.csv</text>"));
  CHECK(here.bgsim("plot a.csv p -o b.png --zoom 1").code == 0);
  CHECK(here.read("b.png").substr(1, 3) == "PNG");
  const Outcome some = here.bgsim("plot a.csv x --from 0.5 --title 'it''s' -o -");
  CHECK(some.code == 0);
  CHECK_THAT(some.out, !Contains(">p</text>"));
  CHECK(here.bgsim("plot a.csv y --x x -o c.svg").code == 0);
}

TEST_CASE("units written with a trace are found by its plot, wherever the trace goes") {
  const Workplace here;
  CHECK(here.bgsim("decay.json -o x.csv --units --quiet").code == 0);
  CHECK_THAT(here.bgsim("plot x.csv q -o -").out, Contains("<text>C</text>"));
}

TEST_CASE("two traces are drawn over each other, and the largest difference is printed") {
  const Workplace here;
  here.write("a.csv", "t,x\n0,1\n1,2\n2,3\n");
  here.write("b.csv", "t,x,more\n0,1,0\n1,1.5,0\n2,3,0\n");
  const Outcome same = here.bgsim("plot a.csv --against b.csv");
  CHECK(same.code == 0);
  CHECK_THAT(same.err, Contains("x: largest difference 0.5 at t = 1, of 3 records in common"));
  CHECK_THAT(here.read("a.svg"), Contains("x, difference</text>") && Contains("x, b.csv</text>"));
  here.write("c.csv", "t,x\n0,1\n2,3.5\n");
  CHECK_THAT(here.bgsim("plot a.csv --against c.csv -o -").err,
             Contains("x: largest difference -0.5 at t = 2, the second trace being interpolated"));
}

TEST_CASE("extremes of a long trace are in its picture, however short they last") {
  const Workplace here;
  std::ostringstream text;
  text << "t,x\n";
  for (int i = 0; i < 200000; ++i) text << i << ',' << (i == 123457 ? 1000 : i % 2) << '\n';
  here.write("long.csv", text.str());
  CHECK(here.bgsim("plot long.csv").code == 0);
  const std::string svg = here.read("long.svg");
  CHECK_THAT(svg, Contains("<text> 1000</text>"));  // the ordinate's range follows what is drawn
  CHECK(svg.size() < 200000);
}

TEST_CASE("records without a value are left out of a curve, as those that fit -o writes") {
  const Workplace here;
  here.write("measured.csv", "t,x,data\n0,1,1.25\n1,2,nan\n2,3,\n3,4,NA\n4,5,5.25\n");
  here.write("whole.csv", "t,data\n0,1.25\n4,5.25\n");
  REQUIRE(here.bgsim("plot measured.csv data").code == 0);
  CHECK_THAT(here.read("measured.svg"), Contains("data"));
  const Outcome against = here.bgsim("plot measured.csv --against whole.csv data -o apart.svg");
  CHECK_THAT(against.err, Contains("data: largest difference 0 at t = 0, of 2 records in common"));
}

TEST_CASE("what cannot be drawn is refused with its place and a fix") {
  const Workplace here;
  here.write("a.csv", "t,speed\n0,1\n1,2\n");
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Outcome outcome = here.bgsim("plot " + arguments);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains(message));
  };
  refused("a.csv sped", "a.csv has no column \"sped\"; did you mean \"speed\"?");
  refused("a.csv --x time", "a.csv has no column \"time\"");
  refused("no.csv", "cannot read \"no.csv\": No such file or directory");
  here.write("bad.csv", "t,x\n0,1\n1,many\n");
  refused("bad.csv", "bad.csv:3: \"many\" in column \"x\" is not a number");
  here.write("none.csv", "t,x\n0,\n1,nan\n");
  refused("none.csv", "column \"x\" of none.csv has no value to draw");
  here.write("empty.csv", "t,x\n");
  refused("empty.csv", "empty.csv has a header and no records");
  refused("a.csv --from 5", "no record between --from and --to");
  refused("a.csv --from 1 --to 0", "--from is to be less than --to");
  refused("a.csv -o a.pdf", "ends with neither .svg nor .png");
  here.write("other.csv", "t,x\n0,1\n");
  refused("a.csv --against other.csv", "have no column in common");
  here.write("back.csv", "t,speed\n0,1\n1,2\n0.5,3\n");
  refused("back.csv --against a.csv", "goes back and forth");
}

TEST_CASE("sides of switches are drawn below the curves, and what is not a table of events is refused") {
  const Workplace here;
  here.write("a.csv", "t,x\n0,1\n1,2\n2,1\n");
  const std::string header = "t,kind,name,quantity,from,to,impulse,energy\n";
  std::string rows = header + "0,start,chop,switch,,open,,\n0,start,free,diode,,blocks,,\n";
  for (int i = 1; i <= 4000; ++i)
    rows += std::to_string(0.0002 * i) + ",switch,chop,," + (i % 2 ? "open,closed" : "closed,open") + ",,\n";
  here.write("a.events.csv", rows);
  CHECK(here.bgsim("plot a.csv --events a.events.csv").code == 0);
  const std::string svg = here.read("a.svg");
  CHECK_THAT(svg, Contains("chop: closed (filled), open; 4000 changes") && Contains("free: blocks throughout"));
  CHECK_THAT(svg, Contains("paler: changes too fast to be drawn one by one"));
  CHECK(svg.size() < 200000);
  const Outcome one = here.bgsim("plot a.csv --events a.events.csv --lane free -o -");
  CHECK_THAT(one.out, Contains("free: blocks") && !Contains("chop"));
  std::string many = header;
  for (int i = 0; i < 50; ++i) many += "0,start,s" + std::to_string(i) + ",switch,,open,,\n";
  here.write("many.csv", many + "1,switch,s49,,open,closed,,\n");
  const Outcome some = here.bgsim("plot a.csv --events many.csv -o -");
  CHECK_THAT(some.err, Contains("20 of 50 lanes are not drawn; --lane NAME draws others"));
  CHECK_THAT(some.out, Contains("30 of 50 lanes") && Contains("s49: closed (filled), open; 1 change"));
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Outcome outcome = here.bgsim("plot a.csv " + arguments);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains(message));
  };
  refused("--events a.csv", "a.csv:1: no table of events");
  here.write("empty.csv", header);
  refused("--events empty.csv", "there is no lane to draw");
  refused("--events a.events.csv --lane chap", "has no lane \"chap\"; did you mean \"chop\"?");
  refused("--events a.events.csv --x x", "--events draws the sides of switches over the time of one run");
  refused("--lane chop", "--lane");
  refused("--events a.events.csv -o a.events.csv", "a.events.csv");
}
