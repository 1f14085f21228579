// Poles of systems that are too large for dense algebra: closed forms of chains and grids, and the dense solver itself.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "linear/sparse_eigenvalues.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Complex = std::complex<double>;

namespace {

LinearSystem linear(const std::string& body) {
  const Study study = Study::from_text(model_text(body + R"x(, "scenes": { "s": { "stop": 1, "samples": 3 } })x"));
  return study.linearized(prepare_scene(study.model(), "", {}), {});
}

/// A thousand sections of 1 ohm and 1 F behind a source of 0 V; the last is open.
std::string ladder() {
  return R"x("elements": { "src": { "kind": "Se", "effort": 0 },
      "s": { "kind": "1", "repeat": 1000 }, "r": { "kind": "R", "resistance": 1, "repeat": 1000 },
      "p": { "kind": "0", "repeat": 1000 }, "c": { "kind": "C", "capacitance": 1, "repeat": 1000 } },
    "bonds": [ { "from": "src", "to": "s[1]" }, { "from": "s[i]", "to": "r[i]" }, { "from": "s[i]", "to": "p[i]" },
      { "from": "p[i]", "to": "c[i]" }, { "from": "p[i]", "to": "s[i+1]" } ], "outputs": { "u": "c[1].e" })x";
}

}  // namespace

TEST_CASE("the slowest poles of a line of a thousand sections are those of its closed form", "[long]") {
  constexpr int n = 1000;
  const std::vector<Pole> found = poles(linear(ladder()), PolesNear{0.0, 12});
  REQUIRE(found.size() == 12);
  for (int k = 1; k <= 12; ++k) {
    const double half = std::sin((2 * k - 1) * std::numbers::pi / (2.0 * (2 * n + 1)));
    const Pole& pole = found[static_cast<std::size_t>(k - 1)];
    CAPTURE(k, pole.s, pole.error);
    CHECK(pole.s.imag() == 0.0);
    // What it says of its own error holds, and is some roundings of the largest entry, 2.
    CHECK(std::abs(pole.s.real() + 4.0 * half * half) <= pole.error);
    CHECK(pole.error < 1e-13);
    CHECK(pole.multiple == 1);
  }
}

TEST_CASE("equal poles of a square grid come out as often as they are there", "[long]") {
  // Capacitors of 1 F at the points of a grid, joined by 1 ohm, the border open: -(a_i + a_j), a_k = 4 sin^2(k pi/(2
  // m)).
  constexpr int m = 25;
  const std::string grid = R"x("elements": {
      "p": { "kind": "0", "repeat": [25, 25] }, "c": { "kind": "C", "capacitance": 1, "repeat": [25, 25] },
      "h": { "kind": "1", "repeat": [25, 24] }, "hr": { "kind": "R", "resistance": 1, "repeat": [25, 24] },
      "v": { "kind": "1", "repeat": [24, 25] }, "vr": { "kind": "R", "resistance": 1, "repeat": [24, 25] } },
    "bonds": [ { "from": "p[i][j]", "to": "c[i][j]" },
      { "from": "p[i][j]", "to": "h[i][j]", "repeat": [[1, 25], [1, 24]] },
      { "from": "h[i][j]", "to": "p[i][j+1]", "repeat": [[1, 25], [1, 24]] },
      { "from": "h[i][j]", "to": "hr[i][j]" }, { "from": "v[i][j]", "to": "vr[i][j]" },
      { "from": "p[i][j]", "to": "v[i][j]", "repeat": [[1, 24], [1, 25]] },
      { "from": "v[i][j]", "to": "p[i+1][j]", "repeat": [[1, 24], [1, 25]] } ],
    "outputs": { "u": "c[1][1].e" })x";
  std::vector<double> exact;
  const auto a = [](int k) { return 4.0 * std::pow(std::sin(k * std::numbers::pi / (2.0 * m)), 2); };
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j) exact.push_back(-(a(i) + a(j)));
  const LinearSystem system = linear(grid);
  REQUIRE(system.states.size() == 625);
  for (const double near : {0.0, -1.7, -9.0}) {
    std::sort(exact.begin(), exact.end(), [&](double x, double y) { return std::abs(x - near) < std::abs(y - near); });
    const std::vector<Pole> found = poles(system, PolesNear{near, 14});
    REQUIRE(found.size() == 14);
    // Of poles at the same distance (-1.7 +- d) either may come first: compared in order of their size, but for the
    // last, which may be one of two.
    std::vector<double> ours, theirs(exact.begin(), exact.begin() + 14);
    for (const Pole& pole : found) ours.push_back(pole.s.real());
    std::sort(ours.begin(), ours.end());
    std::sort(theirs.begin(), theirs.end());
    for (std::size_t k = 0; k < ours.size(); ++k) {
      CAPTURE(near, k, ours[k], theirs[k]);
      CHECK(std::abs(ours[k] - theirs[k]) < 1e-12);  // some hundred roundings of 8
    }
  }
  const std::vector<Pole> slow = poles(system, PolesNear{0.0, 3});
  CHECK(slow[0].s == 0.0);  // the charge of all is kept
  CHECK(slow[1].multiple == 2);
  CHECK(free_states(slow).size() > 500);
}

TEST_CASE("vibrations of a long chain that is free at both ends begin with its free motion", "[long]") {
  // 400 masses of 1 kg with springs of 1 N/m between them and no loss: 0, +- 2j sin(k pi/(2 n)).
  constexpr int n = 400;
  const std::string chain = R"x("elements": {
      "v": { "kind": "1", "repeat": 400 }, "m": { "kind": "I", "inertance": 1, "repeat": 400 },
      "d": { "kind": "0", "repeat": 399 }, "k": { "kind": "C", "capacitance": 1, "repeat": 399 } },
    "bonds": [ { "from": "v[i]", "to": "m[i]" }, { "from": "v[i]", "to": "d[i]", "repeat": [1, 399] }, { "from": "d[i]", "to": "k[i]" },
      { "from": "d[i]", "to": "v[i+1]", "repeat": [1, 399] } ], "outputs": { "p": "m[1].p" })x";
  const std::vector<Pole> found = poles(linear(chain), PolesNear{0.0, 8});
  REQUIRE(found.size() == 8);
  CHECK(found[0].s == 0.0);
  for (int k = 1; k < 8; ++k) {
    const Pole& pole = found[static_cast<std::size_t>(k)];
    CAPTURE(k, pole.s, pole.error);
    CHECK(pole.pair);
    CHECK(pole.s.real() == 0.0);  // of its sign nothing is known
    CHECK(std::abs(pole.s.imag() - 2.0 * std::sin(k * std::numbers::pi / (2.0 * n))) <= pole.error);
    CHECK(pole.error < 1e-12);
  }
}

TEST_CASE("eigenvalues nearest to a number are those of the dense solver", "[long]") {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int round = 0; round < static_cast<int>(share_of(40)); ++round) {
    const int n = std::uniform_int_distribution<int>(40, 110)(random);
    const double span = uniform(0.0, 6.0);  // decades between the sizes of rows
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      const double size = std::pow(10.0, uniform(0.0, span));
      a(i, i) = -size * uniform(0.1, 2.0);
      for (const int j : {(i + 1) % n, (i + 7) % n, std::uniform_int_distribution<int>(0, n - 1)(random)})
        a(i, j) += size * uniform(-1.0, 1.0);
    }
    const PolesNear some{-std::pow(10.0, uniform(-1.0, span)), 6};
    std::vector<BlockEigenvalue> all = eigenvalues_by_blocks(sparse(a));
    std::erase_if(all, [](const BlockEigenvalue& one) { return one.value.imag() < 0.0; });
    std::sort(all.begin(), all.end(), [&](const BlockEigenvalue& x, const BlockEigenvalue& y) {
      return std::abs(x.value - some.near) < std::abs(y.value - some.near);
    });
    const std::vector<BlockEigenvalue> found = eigenvalues_near(a.sparseView(), some);
    CAPTURE(round, n, span, some.near);
    REQUIRE(found.size() == 6);
    for (std::size_t k = 0; k < found.size(); ++k) {
      CAPTURE(k, found[k].value, found[k].error, all[k].value, all[k].error);
      CHECK(std::abs(found[k].value - all[k].value) <= 4.0 * (found[k].error + all[k].error));
    }
  }
}
