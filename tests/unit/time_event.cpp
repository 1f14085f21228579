#include "expression/time_event.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "program/known_times.hpp"
#include "support/expression_world.hpp"
#include "support/rounds.hpp"

using namespace bgsim;
using bgsim::test::World;

namespace {

struct Events {
  World world;
  std::vector<double> parameters = std::vector<double>(8, 0.0);

  /// The condition of if(condition, 1, 0), or a number.
  ExprId relation(const std::string& text) {
    const ExprId e = world.parse(text);
    return world.pool[e].op == Op::select ? ExprId(world.pool[e].a) : e;
  }
  std::vector<double> all(const std::string& text, double start, double stop, std::size_t most = 100000) {
    const ExprId e = relation(text);
    std::vector<double> times;
    double t = start;
    while (times.size() < most) {
      const auto next = next_change(world.pool, e, World::id(0), parameters, t, stop);
      if (!next) break;
      REQUIRE(*next > t);
      t = *next;
      times.push_back(t);
    }
    return times;
  }
  double at(const std::string& text, double t) {
    std::vector<double> values = parameters;
    values[0] = t;
    return evaluate(world.pool, relation(text), values);
  }
};

double before(double t) { return std::nextafter(t, -1e300); }

}  // namespace

TEST_CASE("a condition on t changes at the first number that fulfils it") {
  Events e;
  CHECK(e.all("if(t >= 0.1, 1, 0)", 0.0, 1.0) == std::vector<double>{0.1});
  CHECK(e.all("if(t > 0.1, 1, 0)", 0.0, 1.0) == std::vector<double>{std::nextafter(0.1, 1.0)});
  CHECK(e.all("if(t < 0.1, 1, 0)", 0.0, 1.0) == std::vector<double>{0.1});
  CHECK(e.all("if(t - 0.1 < 0, 1, 0)", 0.0, 0.1) == std::vector<double>{0.1});
  CHECK(e.all("if(t >= 0.1, 1, 0)", 0.1, 1.0).empty());
  CHECK(e.all("if(t >= 5, 1, 0)", 0.0, 1.0).empty());
  CHECK(e.all("step(t - 1e-300)", 0.0, 1.0) == std::vector<double>{1e-300});
  CHECK(e.all("step(t + 3)", -1e9, 1e9) == std::vector<double>{-3.0});
}

TEST_CASE("a search that ends at 0 or before, or far from 0, is as quick and as certain as any") {
  Events e;
  for (const double stop : {0.0, -0.5, -1e6, 1e-300, 1e6}) {
    CAPTURE(stop);
    const ExprId edge = e.relation("if(t >= " + std::to_string(stop - 0.25) + ", 1, 0)");
    TimeSearch search;
    CHECK(next_change(e.world.pool, edge, World::id(0), e.parameters, stop - 1.0, stop, &search) == stop - 0.25);
    CHECK_FALSE(search.undecided);
    const ExprId later = e.relation("if(t < " + std::to_string(stop + 2.0) + ", 1, 0)");
    CHECK_FALSE(next_change(e.world.pool, later, World::id(0), e.parameters, stop - 1.0, stop, &search));
    CHECK_FALSE(search.undecided);
  }
}

TEST_CASE("a value that is held where a search begins changes at the next number that has another") {
  Events e;
  const auto from = [&](const std::string& text, double after, std::optional<double> held) {
    return next_change(e.world.pool, e.relation(text), World::id(0), e.parameters, after, 1.0, nullptr, held);
  };
  // Just after the number before an edge is the edge: without what is held there is no change.
  CHECK_FALSE(from("if(t >= 0.1, 1, 0)", before(0.1), {}));
  CHECK(from("if(t >= 0.1, 1, 0)", before(0.1), 0.0) == 0.1);
  CHECK(from("if(t >= 0.1, 1, 0)", before(before(0.1)), 0.0) == 0.1);
  CHECK(from("if(t >= 0.1, 1, 0)", 0.0, 0.0) == 0.1);
  CHECK_FALSE(from("if(t >= 0.1, 1, 0)", 0.1, 1.0));
  CHECK(from("if(t >= 0.3 and t < 0.3 + 1e-9, 1, 0)", before(0.3), 0.0) == 0.3);
  CHECK(from("if(t >= 0.3 and t < 0.3 + 1e-9, 1, 0)", before(0.3 + 1e-9), 1.0) == 0.3 + 1e-9);
  CHECK_FALSE(from("if(t >= 1, 1, 0)", 1.0, 0.0));  // beyond the end
  const std::string wave = "if(t - 1e-3*floor(t/1e-3) < 0.4e-3, 1, 0)";
  for (const double edge : e.all(wave, 0.0, 0.1)) {
    CAPTURE(edge);
    REQUIRE(from(wave, before(edge), e.at(wave, before(edge))) == edge);
  }
}

TEST_CASE("every edge of a 1 kHz square wave is found, at the first number behind it") {
  Events e;
  const std::string wave = "if(t - 1e-3*floor(t/1e-3) < 0.4e-3, 1, 0)";
  const std::vector<double> edges = e.all(wave, 0.0, 1.0);
  REQUIRE(edges.size() == 2000);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    CAPTURE(i, edges[i]);
    const double exact =
        i % 2 == 0 ? 1e-3 * static_cast<double>(i / 2) + 0.4e-3 : 1e-3 * static_cast<double>(i / 2 + 1);
    // t/1e-3 and 1e-3*floor(...) round: the edge moves by some units in the last place of t
    REQUIRE(edges[i] == Approx(exact).epsilon(0).margin(4e-16 * exact + 1e-19));
    REQUIRE(e.at(wave, edges[i]) == static_cast<double>(i % 2));
    REQUIRE(e.at(wave, before(edges[i])) == 1.0 - static_cast<double>(i % 2));
  }
}

TEST_CASE("the edges of a sine's sign are found where the sine changes sign") {
  Events e;
  const std::vector<double> edges = e.all("step(sin(2*pi*1e3*t))", 0.0, 0.1);
  REQUIRE(edges.size() == 200);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double exact = 0.5e-3 * static_cast<double>(i + 1);
    CHECK(edges[i] == Approx(exact).epsilon(1e-15));
    CHECK(e.at("step(sin(2*pi*1e3*t))", edges[i]) == (i % 2 == 0 ? 0.0 : 1.0));
  }
}

TEST_CASE("a pulse of a billionth of the run, or of a few numbers' width, is not missed") {
  Events e;
  CHECK(e.all("if(t >= 0.3 and t < 0.3 + 1e-9, 1, 0)", 0.0, 1.0) == std::vector<double>{0.3, 0.3 + 1e-9});
  CHECK(e.all("if(abs(t - 700.5) < 1e-6, 1, 0)", 0.0, 1e3).size() == 2);
  CHECK(e.all("if(t >= 0.3 and t < 0.3 + 5e-16, 1, 0)", 0.0, 1.0) == std::vector<double>{0.3, 0.3 + 5e-16});
  // a resonance curve: 1 at t = 0.7 and above 1/2 within 1e-9 of it
  const auto narrow = e.all("if(1/(1 + ((t - 0.7)*1e9)^2) > 0.5, 1, 0)", 0.0, 1.0);
  REQUIRE(narrow.size() == 2);
  CHECK(narrow[0] - 0.7 == Approx(-1e-9).epsilon(1e-6));
  CHECK(narrow[1] - 0.7 == Approx(1e-9).epsilon(1e-6));
}

TEST_CASE("a contact is no change, and costs a bounded search") {
  Events e;
  CHECK(e.all("if(sin(t) >= 1, 1, 0)", 0.0, 10.0).empty());
  CHECK(e.all("sign((t - 1)^2)", 0.0, 2.0).empty());
  CHECK(e.all("if(t^2 - 2*t + 1 < 0, 1, 0)", 0.0, 2.0).empty());
  CHECK(e.all("if(t == 0.5, 1, 0)", 0.0, 1.0).empty());
  CHECK(e.all("if(sin(t)^2 + cos(t)^2 > 1, 1, 0)", 0.0, 10.0).empty());
}

TEST_CASE("floor, sign and table cells change at their borders") {
  Events e;
  CHECK(e.all("round(t)", 0.0, 2.5) == std::vector<double>{0.5, 1.5, 2.5});
  CHECK(e.all("round(-t)", 0.0, 2.5) == std::vector<double>{0.5, 1.5, 2.5});
  CHECK(e.all("ceil(t)", 0.0, 2.5) == std::vector<double>{std::nextafter(1.0, 2.0), std::nextafter(2.0, 3.0)});
  CHECK(e.all("if(mod(t, 2) < 1, 1, 0)", 0.0, 4.5) == std::vector<double>{1.0, 2.0, 3.0, 4.0});
  CHECK(e.all("floor(t/0.25)", 0.0, 1.0) == std::vector<double>{0.25, 0.5, 0.75, 1.0});
  CHECK(e.all("floor(-t)", 0.0, 2.5) == std::vector<double>{std::nextafter(1.0, 2.0), std::nextafter(2.0, 3.0)});
  CHECK(e.all("sign(t - 1)", 0.0, 3.0) == std::vector<double>{std::nextafter(1.0, 2.0)});
  CHECK(e.all("table('data.csv', 'u', t)", -9.0, 9.0) == std::vector<double>{0.0, 1.0});
  const auto slow = e.all("table('data.csv', 'u', 2*t)", -4.0, 4.0);
  CHECK(slow == std::vector<double>{0.0, 0.5});
}

TEST_CASE("conditions within conditions, tables and parameters take part") {
  Events e;
  e.parameters[1] = 0.25;  // x
  CHECK(e.all("if(t*if(t < x, 1, 2) >= 0.5, 1, 0)", 0.0, 1.0) == std::vector<double>{0.25});
  // the line from (0, 1) to (1, 2) reaches 1.5 at t = 0.5, the line from (1, 2) to (10, -4) at t = 1.75
  CHECK(e.all("if(table('data.csv', 'u', t) > 1.5, 1, 0)", 0.0, 9.0).size() == 2);
  const auto spline = e.all("if(table('data.csv', 'u', t, spline) > 1.5, 1, 0)", 0.0, 9.0);
  for (const double t : spline) {
    const double jump = e.at("table('data.csv', 'u', t, spline)", t);
    CHECK(jump == Approx(1.5).epsilon(1e-14));
  }
  CHECK(spline.size() >= 1);
  CHECK(e.all("if(exp(-t)*cos(20*t) > 0.1, 1, 0)", 0.0, 10.0).size() % 2 == 1);
}

TEST_CASE("the value just after a time is the one that lasts") {
  Events e;
  const auto just_after = [&](const char* text, double t) {
    return value_just_after(e.world.pool, e.relation(text), World::id(0), e.parameters, t);
  };
  CHECK(just_after("sign(t)", 0.0) == 1.0);
  CHECK(just_after("if(t > 0, 1, 0)", 0.0) == 1.0);
  CHECK(just_after("if(t <= 0, 1, 0)", 0.0) == 0.0);
  CHECK(just_after("if(t == 0, 1, 0)", 0.0) == 0.0);
  CHECK(just_after("floor(t)", 0.999) == 0.0);
  CHECK(just_after("step(sin(t))", 0.0) == 1.0);
  CHECK(just_after("sign(sin(t))", std::numbers::pi) == -1.0);
  CHECK(just_after("table('data.csv', 'u', t)", 1.0) == 2.0);
  CHECK(just_after("table('data.csv', 'u', t)", 10.0) == 2.0);
  CHECK(just_after("if(table('data.csv', 'u', t) < 0, 1, 0)", 10.0) == 1.0);
  CHECK(just_after("if(x < 1, 1, 0)", 3.0) == 1.0);
}

TEST_CASE("a million periods into a run the next edge is still found") {
  Events e;
  const std::vector<double> edges = e.all("if(t - 2*floor(t/2) < 1, 1, 0)", 2e6, 2e6 + 10);
  CHECK(edges ==
        std::vector<double>{2e6 + 1, 2e6 + 2, 2e6 + 3, 2e6 + 4, 2e6 + 5, 2e6 + 6, 2e6 + 7, 2e6 + 8, 2e6 + 9, 2e6 + 10});
}

TEST_CASE("random relations change only where sampling sees them change") {
  World world;
  std::vector<double> values(8, 0.4);
  for (unsigned seed = 0; seed < test::share_of(10); ++seed) {
    test::RandomExpressions random(world, seed);
    const ExprId e = random.condition(6);
    std::vector<double> changes;
    double t = 0.0;
    while (changes.size() < 200) {
      const auto next = next_change(world.pool, e, World::id(0), values, t, 3.0);
      if (!next) break;
      changes.push_back(t = *next);
    }
    if (changes.size() == 200) continue;
    // between two changes all samples agree, but for contacts, which samples do not meet
    std::size_t k = 0;
    double now = value_just_after(world.pool, e, World::id(0), values, 0.0);
    for (int i = 1; i < 3000; ++i) {
      values[0] = 1e-3 * i + 1e-4 * std::numbers::pi / 10.0;
      while (k < changes.size() && changes[k] <= values[0])
        now = value_just_after(world.pool, e, World::id(0), values, changes[k++]);
      const double sample = evaluate(world.pool, e, values);
      CAPTURE(seed, world.text(world.pool.select(e, world.symbol("x"), world.symbol("y"))), values[0], k);
      if (!(std::isnan(sample) && std::isnan(now))) REQUIRE(sample == now);
    }
  }
}

TEST_CASE("a comparison of an expression with what it is on a stretch is decided there") {
  Events e;
  const double behind = std::nextafter(1.0, 2.0);
  for (const std::string text :
       {"if(t > min(t, 1), 1, 0)", "if(min(t, 1) < t, 1, 0)", "sign(t - min(t, 1))", "if(2*t > 2*min(t, 1), 1, 0)",
        "if(max(t, 1) > 1, 1, 0)", "if(t != min(1, t), 1, 0)"}) {
    INFO(text);
    CHECK(e.all(text, 0.0, 2.0) == std::vector<double>{behind});
    std::vector<double> at(8, 0.0);
    CHECK(value_just_after(e.world.pool, e.relation(text), World::id(0), at, 0.0) == 0.0);
    CHECK(value_just_after(e.world.pool, e.relation(text), World::id(0), at, behind) == 1.0);
  }
  CHECK(e.all("if(abs(t - 1) > t - 1, 1, 0)", 0.0, 2.0) == std::vector<double>{1.0});
  CHECK(e.all("if(t >= min(t, 1), 1, 0)", 0.0, 2.0).empty());
  // the same by other operations: undecided up to 1, false at each single time
  CHECK(e.all("if(t*t > t*min(t, 1) + 0*t, 1, 0)", 0.0, 2.0) == std::vector<double>{behind});
  CHECK(e.all("if(t + t > t + min(t, 1), 1, 0)", 0.0, 2.0).size() == 1);
  CHECK(e.all("if(abs(t) <= t, 1, 0)", -1.0, 2.0) == std::vector<double>{0.0});
  CHECK(e.all("if(if(t < 1, t, 1) < t, 1, 0)", 0.0, 2.0) == std::vector<double>{behind});
}

TEST_CASE("the value just after an instant is the limit from the right, also where rounding hides it") {
  Events e;
  const auto after = [&](const std::string& text, double t) {
    return value_just_after(e.world.pool, e.relation(text), World::id(0), e.parameters, t);
  };
  CHECK(after("floor(1 - t)", 0.0) == 0.0);
  CHECK(after("floor(1 + t)", 0.0) == 1.0);
  CHECK(after("ceil(3 + t)", 0.0) == 4.0);
  CHECK(after("ceil(3 - t)", 0.0) == 3.0);
  CHECK(after("round(2.5 - t)", 0.0) == 2.0);
  CHECK(after("round(-2.5 + t)", 0.0) == -2.0);
  CHECK(after("floor(1e3 - t)", 1.0) == 998.0);
  CHECK(after("floor(1 - t^2)", 0.0) == 0.0);
  CHECK(after("floor(cos(t))", 0.0) == 0.0);
  CHECK(after("if(1 - t < 1, 1, 0)", 0.0) == 1.0);
  CHECK(after("if(1 + t^3 > 1, 1, 0)", 0.0) == 1.0);
  CHECK(after("sign(exp(t) - 1)", 0.0) == 1.0);
  CHECK(after("step(-t)", 0.0) == 0.0);
  CHECK(after("floor(2)", 0.0) == 2.0);
  // no event is made of what rounding hides
  CHECK(e.all("floor(1 - t)", 0.0, 0.5).empty());
  CHECK(e.all("floor(1e3 - t)", 1.0, 1.5).empty());
  CHECK(e.all("floor(1 - t)", 0.0, 2.0).size() == 1);
  CHECK(e.all("floor(1 - t)", 0.0, 2.0).front() == Approx(1.0).epsilon(1e-15));
}

TEST_CASE("the search for known times ends, and tells where it could not decide") {
  Events e;
  for (const std::string text : {"floor(sin(t)^2 + cos(t)^2)", "if((t + 1)^2 > t^2 + 2*t + 1, 1, 0)"}) {
    INFO(text);
    TimeSearch search;
    double t = 0.0;
    int changes = 0;
    for (; changes < 50 && !search.undecided; ++changes) {
      const auto next = next_change(e.world.pool, e.relation(text), World::id(0), e.parameters, t, 2.0, &search);
      if (!next) break;
      t = *next;
    }
    CHECK((search.undecided || t < 1e-9));  // or it goes from double to double, which the run sees
  }
  // contacts are decided by what is on either side
  TimeSearch search;
  CHECK(!next_change(e.world.pool, e.relation("if(sin(t) >= 1, 1, 0)"), World::id(0), e.parameters, 0.0, 3.0, &search));
  CHECK(!search.undecided);
}

TEST_CASE("a relation of time that is kept for many searches gives the same as a new one each time") {
  Events e;
  e.parameters[1] = 0.3;
  for (const std::string text : {"if(t/x - floor(t/x) < 0.25, 1, 0)", "floor(1 - t)", "if(sin(7*t) > min(t, 1), 1, 0)",
                                 "if(abs(t - 1) <= 0.5, 1, 0)", "sign(t - x)", "if(mod(t, x) < 0.1, 1, 0)"}) {
    INFO(text);
    const ExprId relation = e.relation(text);
    RelationOfTime kept(e.world.pool, relation, World::id(0), e.parameters);
    // Later instants first: nothing may be left of them.
    std::vector<double> from = e.all(text, 0.0, 3.0, 20);
    from.push_back(0.0);
    std::sort(from.begin(), from.end(), std::greater<>());
    for (const double t : from) {
      CHECK(kept.next_change(t, 3.0) == next_change(e.world.pool, relation, World::id(0), e.parameters, t, 3.0));
      CHECK(kept.value_just_after(t) == value_just_after(e.world.pool, relation, World::id(0), e.parameters, t));
    }
  }
}

TEST_CASE("a guess where a condition on time changes next finds what a search without one does") {
  // The first three repeat with one or two distances; the others break that: a narrow pulse at the guess or just before
  // it, one edge less, distances that shrink, steps by more than one. Where they break it the guess is in vain.
  Events e;
  e.parameters[1] = 2e-5;
  int near = 0;
  for (const std::string text : {"if(t/x - floor(t/x) < 0.3, 1, 0)", "floor(t/x)", "if(sin(t/(3*x)) > 0.2, 1, 0)",
                                 "if(mod(t, x) < 0.5*x or abs(t - 50.1*x) < 1e-12*x, 1, 0)",
                                 "if(mod(t, x) < 0.5*x and abs(t - 70*x) > 1e-9*x, 1, 0)",
                                 "if(mod(t, x) < 0.5*x and not (t > 80.2*x and t < 82.2*x), 1, 0)",
                                 "if(sin(t^2/x^2) > 0.2, 1, 0)", "floor(t/x) + floor(t/(7*x))"}) {
    INFO(text);
    const ExprId relation = e.relation(text);
    RelationOfTime with(e.world.pool, relation, World::id(0), e.parameters),
        without(e.world.pool, relation, World::id(0), e.parameters);
    KnownTime known;
    const double stop = 100.0 * e.parameters[1];
    double t = 0.0;
    for (int changes = 0; changes < 4000; ++changes) {
      TimeSearch search{known.guess(t), {}};
      const auto next = with.next_change(t, stop, &search);
      const auto searched = without.next_change(t, stop);
      REQUIRE(next == searched);
      if (!next) break;
      if (search.guess && std::abs(*next - *search.guess) <= 16.0 * (*next - before(*next))) ++near;
      t = *next;
      known.take_change(t);
    }
    CHECK(t > 0.9 * stop);
  }
  CHECK(near > 800);  // of which the most are of the first six
}

TEST_CASE("steps of sawtooths of time are followed from jump to jump") {
  // Where the sawtooth begins again the outer step is at its border, and what rounding makes of the sawtooth there is a
  // few roundings of its line, not one of its jumps.
  Events e;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.3, 3.0);
  constexpr double kStop = 12.0, kNear = 1e-9;
  int values = 0;
  for (const std::string text :
       {"floor(x*mod(y*t, z))", "ceil(x*mod(y*t, 1))", "round(x*mod(y*t, 1) - 0.5)", "floor(mod(mod(y*t, x + z), z))",
        "floor(x*min(mod(y*t, 1), mod(z*t, 1)))", "floor(x*(y*t - z*floor(y*t/z)))", "floor(x*(1 - mod(y*t, 1)))",
        "floor(x*abs(mod(y*t, 1) - 0.5))", "floor(x*(y*t - floor(y*t)))", "if(floor(x*mod(y*t, 1)) >= 1, 1, 0)",
        "step(mod(y*t, z) - 0.5*x) + floor(mod(x*t, z))", "floor(if(mod(y*t, z) < x, mod(y*t, z), x))"}) {
    for (std::uint64_t round = 0; round < test::share_of(10); ++round) {
      for (std::size_t i = 1; i < 4; ++i) e.parameters[i] = std::round(1e3 * uniform(random)) / 1e3;
      CAPTURE(text, e.parameters[1], e.parameters[2], e.parameters[3]);
      const std::vector<double> changes = e.all(text, 0.0, kStop, 5000);
      double value = value_just_after(e.world.pool, e.relation(text), World::id(0), e.parameters, 0.0);
      std::size_t next = 0;
      for (int k = 1; k < 700; ++k) {
        const double t = kStop * k / 700.0;
        bool near = false;
        for (; next < changes.size() && changes[next] <= t; ++next)
          value = value_just_after(e.world.pool, e.relation(text), World::id(0), e.parameters, changes[next]);
        for (const double offset : {-kNear, kNear}) near = near || e.at(text, t + offset) != e.at(text, t);
        if (near) continue;
        REQUIRE(value == e.at(text, t));
        ++values;
      }
    }
  }
  CHECK(values > 12 * 5 * 650);
}
