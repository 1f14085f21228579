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
