// Depth-first search: order of completion, arcs back, members left out.
#include "base/depth_first.hpp"

#include <catch2/catch.hpp>

#include "base/dependence.hpp"

using namespace bgsim;

namespace {

using Graph = std::vector<std::vector<std::size_t>>;

Dependence dependence(const Graph& graph) {
  return order_by_dependence(graph.size(), [&](std::size_t i) { return graph[i]; });
}

}  // namespace

TEST_CASE("what is referred to is finished first, and each circle is found once") {
  CHECK(dependence({{1, 2}, {2}, {}, {0}}).order == std::vector<std::size_t>{2, 1, 0, 3});
  CHECK(dependence({{1}, {2}, {0}}).cycles == Graph{{0, 1, 2}});
  CHECK(dependence({{0}, {2}, {1}}).cycles == Graph{{0}, {1, 2}});
  CHECK(dependence({{1, 2}, {0}, {0}}).cycles == Graph{{0, 1}});  // 0-2 shares a member
}

TEST_CASE("members that do not enter are passed over, also where an arc back shuts them") {
  const Graph graph{{1}, {2}, {0, 3}, {2}};
  std::vector<bool> shut(4, false);
  std::vector<std::size_t> finished;
  depth_first(
      4, [&](std::size_t i) { return graph[i]; }, [&](std::size_t i) { return !shut[i]; },
      [&](std::span<const std::size_t> path, std::size_t i) {
        CHECK(path.front() == 0);
        shut[i] = true;
      },
      [&](std::size_t i) { finished.push_back(i); });
  CHECK(shut == std::vector<bool>{true, false, true, false});
  CHECK(finished == std::vector<std::size_t>{3, 2, 1, 0});
}

TEST_CASE("a chain of a million needs no stack of the program", "[long]") {
  constexpr std::size_t kLong = 1'000'000;
  const auto next = [](std::size_t i) {
    return i + 1 < kLong ? std::vector<std::size_t>{i + 1} : std::vector<std::size_t>{};
  };
  CHECK(order_by_dependence(kLong, next).order.front() == kLong - 1);
}
