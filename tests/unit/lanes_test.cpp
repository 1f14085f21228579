// Lanes of modes: from the rows of events, and merged where sides change too fast to be drawn.
#include "lanes.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "bgsim/csv.hpp"
#include "bgsim/trace_csv.hpp"

using namespace bgsim;
using namespace bgsim::cli;

namespace {

using Kind = RunEvent::Kind;

RunEvent row(Kind kind, double t, const std::string& name, const std::string& from, const std::string& to) {
  RunEvent event;
  event.kind = kind;
  event.t = t;
  event.name = name;
  event.from = from;
  event.to = to;
  return event;
}

RunEvent start_row(const std::string& name, const std::string& kind, const std::string& to) {
  RunEvent event = row(Kind::start, 0.0, name, "", to);
  event.quantity = kind;
  return event;
}

/// Time on between two times.
double time_on(const Lane& lane, double from, double to) {
  double sum = 0.0;
  for (std::size_t i = 0; i < lane.from.size(); ++i) {
    const double end = i + 1 < lane.from.size() ? lane.from[i + 1] : to;
    sum += lane.share[i] * std::max(0.0, std::min(end, to) - std::max(lane.from[i], from));
  }
  return sum;
}

double share_at(const Lane& lane, double t) {
  const auto after = std::upper_bound(lane.from.begin(), lane.from.end(), t);
  return after == lane.from.begin() ? -1.0 : lane.share[static_cast<std::size_t>(after - lane.from.begin()) - 1];
}

}  // namespace

TEST_CASE("lanes begin with the side that a run begins on, and say what each side is") {
  LaneBook book;
  for (const RunEvent& event : {start_row("chop", "switch", "closed"),
                                start_row("free", "diode", "blocks"),
                                start_row("wall", "contact", "free"),
                                start_row("brake", "switch", "locked"),
                                row(Kind::switching, 1, "chop", "closed", "open"),
                                row(Kind::diode, 1, "free", "blocks", "conducts"),
                                row(Kind::impact, 1.5, "wall", "2", "-1"),
                                row(Kind::contact, 2, "wall", "free", "closed"),
                                row(Kind::latch, 2.5, "hot", "false", "true"),
                                row(Kind::condition, 3, "sign(m.f)", "1", "held"),
                                row(Kind::condition, 3.5, "sign(m.f)", "held", "0"),
                                row(Kind::condition, 3, "m.f > 2", "true", "false"),
                                row(Kind::condition, 3.2, "sign(pipe.e)", "0", "1"),
                                row(Kind::condition, 3.4, "sign(pipe.e)", "1", "-1"),
                                row(Kind::sample, 0, "u", "0", "1"),
                                row(Kind::sample, 0, "v", "0", "1"),
                                row(Kind::sample, 1, "u", "0", "1"),
                                row(Kind::sample, 1, "v", "0", "1"),
                                row(Kind::sample, 1, "w", "0", "1"),
                                row(Kind::event, 4, "dump", "1", "0"),
                                row(Kind::jump, 4, "a.q", "1", "2"),
                                row(Kind::jump, 4, "b.q", "1", "2"),
                                row(Kind::time, 4, "t > 4", "false", "true")})
    book.take(event);
  const std::vector<Lane> lanes = book.lanes(0.0);
  std::vector<std::string> texts;
  for (const Lane& lane : lanes) texts.push_back(lane_text(lane));
  CHECK(texts == std::vector<std::string>{
                     "chop: closed (filled), open; 1 change", "free: conducts (filled), blocks; 1 change",
                     "wall: touches (filled), apart; 1 change, 1 impact", "brake: locked throughout",
                     "hot: true (filled), false; 1 change", "sign(m.f): sticks (filled), slides; 1 change",
                     "event dump: 1 time", "jumps of stores: 1 time", "sampled u, v: 2 times", "sampled w: 1 time"});
  CHECK(lanes[0].from == std::vector<double>{0, 1});
  CHECK(lanes[0].share == std::vector<double>{1, 0});
  CHECK(lanes[2].marks == std::vector<double>{1.5});
}

TEST_CASE("a side that another follows in the same instant leaves no stretch, and is counted") {
  LaneBook book;
  for (const RunEvent& event :
       {start_row("s", "switch", "open"), row(Kind::switching, 1, "s", "open", "closed"),
        row(Kind::switching, 1, "s", "closed", "open"), row(Kind::switching, 2, "s", "open", "closed")})
    book.take(event);
  const Lane lane = book.lanes(0.0).front();
  CHECK(lane.from == std::vector<double>{0, 2});
  CHECK(lane.share == std::vector<double>{0, 1});
  CHECK(lane.changes == 3);
}

TEST_CASE("lanes that are merged keep the time on, the times of slow changes, and every short pulse") {
  std::mt19937 random(20);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same on each run
  for (int round = 0; round < 300; ++round) {
    INFO("round " << round);
    std::uniform_real_distribution<double> exponent(-9.0, 0.5);
    Lane lane;
    lane.from = {0.0};
    lane.share = {static_cast<double>(round % 2)};
    for (double t = 0.0;;) {
      t += std::pow(10.0, exponent(random)) * (round % 3 == 0 ? 0.01 : 1.0);
      if (t > 10.0 || lane.from.size() > 20000) break;
      lane.from.push_back(t);
      lane.share.push_back(1.0 - lane.share.back());
    }
    constexpr std::size_t kBuckets = 137;
    const double from = 1.25, to = 7.5, width = (to - from) / kBuckets;
    const Lane less = merged(lane, from, to, kBuckets);
    CHECK(less.from.size() <= 3 * kBuckets);
    CHECK(std::is_sorted(less.from.begin(), less.from.end()));
    // Sums of up to 20,000 differences of times of size 10; a bucket that is on or off but for less than a thousandth
    // of its time is off by that.
    CHECK(time_on(less, from, to) == Approx(time_on(lane, from, to)).margin(1e-3 * width * kBuckets + 1e-11));
    for (std::size_t i = 0; i + 1 < lane.from.size(); ++i) {
      const double a = lane.from[i], b = lane.from[i + 1];
      if (a < from || b > to) continue;
      const double middle = 0.5 * (a + b), share = share_at(less, middle);
      if (b - a > 3 * width) {
        CHECK(share == lane.share[i]);  // at least a whole bucket of it
      } else if (i > 0 && b - a < width) {
        CHECK((share > 0.0 && share < 1.0));  // merged: never like one side alone
      }
    }
  }
}

TEST_CASE("a lane without fast changes stays as it is") {
  Lane lane;
  lane.from = {0.0, 1.0, 4.0};
  lane.share = {0.0, 1.0, 0.0};
  lane.marks = {0.5, 3.0, 9.0};
  const Lane same = merged(lane, 0.0, 8.0, 100);
  CHECK(same.from == lane.from);
  CHECK(same.share == lane.share);
  CHECK(same.marks == std::vector<double>{0.5, 3.0});
  const Lane part = merged(lane, 2.0, 8.0, 100);
  CHECK(part.from == std::vector<double>{2.0, 4.0});
  CHECK(part.share == std::vector<double>{1.0, 0.0});
}

TEST_CASE("of many lanes those that change come first") {
  std::vector<Lane> lanes(5);
  lanes[3].changes = 1;
  lanes[4].marks = {1.0};
  CHECK(lanes_to_draw(lanes, 3) == std::vector<std::size_t>{0, 3, 4});
  CHECK(lanes_to_draw(lanes, 9).size() == 5);
}

TEST_CASE("a table of events reads back as it was written") {
  std::string text;
  append_event_header(text);
  RunEvent impact = row(Kind::impact, 0.1, "a \"wall\", left", "2.5", "-1.25");
  impact.impulse = 3.75;
  impact.energy = 1e-300;
  const std::vector<RunEvent> events{start_row("s", "switch", "open"), impact,
                                     row(Kind::time, 1e9, "t > 1,\n2", "false", "true")};
  for (const RunEvent& event : events) append_event_record(text, event);
  std::vector<RunEvent> read;
  read_event_records(text, [&](const RunEvent& event) { read.push_back(event); });
  REQUIRE(read.size() == events.size());
  std::string again;
  append_event_header(again);
  for (const RunEvent& event : read) append_event_record(again, event);
  CHECK(again == text);
  const auto refused = [](const std::string& bad, const std::string& message) {
    try {
      read_event_records(bad, [](const RunEvent&) {});
      FAIL("read");
    } catch (const CsvError& error) {
      CHECK(std::string(error.what()) == message);
    }
  };
  const std::string header = "t,kind,name,quantity,from,to,impulse,energy\n";
  refused("", "the file is empty: a table of events has a header");
  refused("t,x\n0,1\n", "no table of events: its header is not t,kind,name,quantity,from,to,impulse,energy");
  refused(header + "0,flip,s,,open,closed,,\n", "\"flip\" is no kind of event");
  refused(header + "soon,switch,s,,open,closed,,\n", "\"soon\" in column \"t\" is not a number");
  refused(header + "0,impact,s,,1,-1,much,\n", "\"much\" in column \"impulse\" is not a number");
  refused(header + "0,switch,s\n", "3 fields where the header has 8 columns");
}
