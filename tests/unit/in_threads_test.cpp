#include "base/in_threads.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

using namespace bgsim;

TEST_CASE("each of many tasks is done once, on any number of threads, and none may be there") {
  for (const unsigned threads : {1U, 2U, 7U, 300U}) {
    std::vector<std::atomic<int>> done(100);
    in_threads(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    for (const std::atomic<int>& times : done) CHECK(times == 1);
  }
  in_threads(0, 4, [](std::size_t) { FAIL("there is no task"); });
}

TEST_CASE("what the first task throws is thrown when all are done") {
  for (const unsigned threads : {1U, 4U}) {
    std::atomic<int> done = 0;
    const auto task = [&](std::size_t i) {
      ++done;
      if (i == 3 || i == 8) throw std::runtime_error("task " + std::to_string(i));
    };
    CHECK_THROWS_WITH(in_threads(20, threads, task), "task 3");
    CHECK(done == 20);
  }
}
