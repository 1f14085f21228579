#include "equations/tearing.hpp"

#include <catch2/catch.hpp>
#include <random>

using namespace bgsim;

namespace {

/// Every dependence of a sequenced member is on a tear or on an earlier member.
void check_sequence(const LoopGraph& loop, const Tearing& tearing) {
  const std::size_t n = loop.depends_on.size();
  REQUIRE(tearing.tears.size() + tearing.sequence.size() == n);
  std::vector<bool> known(n, false);
  for (const auto i : tearing.tears) known[i] = true;
  for (const auto i : tearing.sequence) {
    REQUIRE_FALSE(known[i]);
    for (const auto j : loop.depends_on[i]) REQUIRE(known[j]);
    known[i] = true;
  }
}

LoopGraph ring(std::uint32_t n) {
  LoopGraph loop;
  for (std::uint32_t i = 0; i < n; ++i) loop.depends_on.push_back({(i + 1) % n});
  loop.must_tear.assign(n, false);
  return loop;
}

}  // namespace

TEST_CASE("a ring of unknowns is cut at one place") {
  for (const std::uint32_t n : {1U, 2U, 17U, 100000U}) {
    const LoopGraph loop = ring(n);
    const Tearing tearing = tear(loop);
    check_sequence(loop, tearing);
    CHECK(tearing.tears.size() == 1);
  }
}

TEST_CASE("two rings that share a member are cut at that member") {
  LoopGraph loop;
  loop.depends_on = {{1, 3}, {2}, {0}, {4}, {0}};
  loop.must_tear.assign(5, false);
  const Tearing tearing = tear(loop);
  check_sequence(loop, tearing);
  CHECK(tearing.tears == std::vector<std::uint32_t>{0});
}

TEST_CASE("unknowns of implicit equations are always torn") {
  LoopGraph loop = ring(4);
  loop.must_tear[2] = true;
  const Tearing tearing = tear(loop);
  check_sequence(loop, tearing);
  CHECK(tearing.tears == std::vector<std::uint32_t>{2});
}

TEST_CASE("a loop through the rate of one state is cut at what the rate is a multiple of") {
  // 0 is the rate, a multiple of 1, which is a sum over 3 and 4; both are multiples of 2, and that of the rate.
  LoopGraph loop;
  loop.depends_on = {{1}, {3, 4}, {0}, {2}, {2}};
  loop.must_tear.assign(5, false);
  CHECK(tear(loop).tears == std::vector<std::uint32_t>{1});  // the most paths go through it
  loop.depends_on = {{1}, {5}, {0}, {2}, {2}, {3, 4}};       // 1 has another term, which is no part of the loop
  loop.must_tear.assign(6, false);
  loop.multiple_of = {1, 1, 0, 2, 2, 5};
  CHECK(tear(loop).tears == std::vector<std::uint32_t>{2});
  loop.rates = {0};
  const Tearing tearing = tear(loop);
  check_sequence(loop, tearing);
  CHECK(tearing.tears == std::vector<std::uint32_t>{1});
  CHECK_FALSE(tearing.by_rates);
}

TEST_CASE("a loop through the rates of several states is cut at all rates") {
  // 0 and 1 are rates of states, both differences of an input and 2, which is a sum over both.
  LoopGraph loop;
  loop.depends_on = {{2}, {2}, {0, 1}};
  loop.must_tear.assign(3, false);
  loop.multiple_of = {0, 1, 2};
  CHECK(tear(loop).tears == std::vector<std::uint32_t>{2});
  loop.rates = {0, 1};
  loop.dependent_rates = {2};
  const Tearing tearing = tear(loop);
  check_sequence(loop, tearing);
  CHECK(tearing.tears == std::vector<std::uint32_t>{0, 1, 2});
  CHECK(tearing.by_rates);
}

TEST_CASE("whatever depends on whatever, the rest can be computed in sequence") {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    const auto n =
        static_cast<std::uint32_t>(1 + random() % (round % 10 == 0 ? 900 : 30));  // both sides of the greedy limit
    LoopGraph loop;
    loop.depends_on.resize(n);
    loop.must_tear.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      for (auto k = random() % 4; k > 0; --k) loop.depends_on[i].push_back(static_cast<std::uint32_t>(random() % n));
      loop.must_tear[i] = random() % 8 == 0;
    }
    check_sequence(loop, tear(loop));
    for (std::uint32_t i = 0; i < n; ++i) {
      loop.multiple_of.push_back(!loop.must_tear[i] && loop.depends_on[i].size() == 1 ? loop.depends_on[i][0] : i);
      if (random() % 16 == 0) loop.rates.push_back(i);
      if (random() % 16 == 0) loop.dependent_rates.push_back(i);
    }
    check_sequence(loop, tear(loop));
  }
}

TEST_CASE("a matching is found exactly if the structural rank is full") {
  CHECK(has_full_matching({}));
  CHECK(has_full_matching({{0}}));
  CHECK_FALSE(has_full_matching({{}}));
  CHECK(has_full_matching({{0, 1}, {0}}));
  CHECK_FALSE(has_full_matching({{0}, {0}}));
  CHECK(has_full_matching({{0, 1}, {0, 2}, {0}}));
  CHECK_FALSE(has_full_matching({{0, 1}, {0, 1}, {0, 1}}));
}
