// Contacts among balls between two walls, against a computation from impact to impact.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Box {
  std::vector<double> masses, places, speeds;  ///< by ball, from left to right
  std::vector<double> restitutions;            ///< left wall, between neighbours, right wall
  double width = 1.0, stop = 5.0;
};

Box random_box(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  Box box;
  const std::size_t count = 1 + seed % 4;
  for (std::size_t i = 0; i < count; ++i) {
    box.masses.push_back(std::pow(10.0, 2.0 * part(random) - 1.0));
    box.places.push_back(0.05 + 0.9 * part(random));
    box.speeds.push_back(4.0 * part(random) - 2.0);
  }
  std::sort(box.places.begin(), box.places.end());
  const bool elastic = seed % 2 == 0;
  for (std::size_t i = 0; i <= count; ++i) box.restitutions.push_back(elastic ? 1.0 : 0.9 + 0.1 * part(random));
  return box;
}

std::string model_of(const Box& box) {
  const auto number = [](double x) { return number_text(x, 17); };
  std::string elements, bonds, signals, outputs;
  const auto element = [&](const std::string& name, const std::string& text) {
    elements += (elements.empty() ? "" : ", ") + ("\"" + name + "\": {" + text + "}");
  };
  const auto bond = [&](const std::string& from, const std::string& to) {
    bonds += (bonds.empty() ? "" : ", ") + (R"({"from": ")" + from + R"(", "to": ")" + to + "\"}");
  };
  const auto contact = [&](const std::string& name, double gap, double restitution) {
    element(name, R"("kind": "contact", "gap": )" + number(gap) + R"(, "restitution": )" + number(restitution));
  };
  const std::size_t count = box.masses.size();
  // The left wall stands still; what it and the first ball come closer by is the flow of their 0-junction.
  element("left", R"("kind": "Sf", "flow": 0)");
  element("z0", R"("kind": "0")");
  contact("c0", box.places.front(), box.restitutions.front());
  bond("left", "z0");
  bond("z0", "c0");
  bond("z0", "v0");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string k = std::to_string(i), next = std::to_string(i + 1);
    element("v" + k, R"("kind": "1")");
    element("m" + k, R"("kind": "I", "inertance": )" + number(box.masses[i]) + R"(, "initial": {"f": )" +
                         number(box.speeds[i]) + "}");
    bond("v" + k, "m" + k);
    signals += (i == 0 ? "\"x" : ", \"x") + k + R"(": {"integral": "m)" + k + R"(.f", "initial": )" +
               number(box.places[i]) + "}";
    outputs += (i == 0 ? "\"x" : ", \"x") + k + R"(": "x)" + k + "\"";
    const double gap = (i + 1 < count ? box.places[i + 1] : box.width) - box.places[i];
    contact("c" + next, gap, box.restitutions[i + 1]);
    if (i + 1 == count) {
      bond("v" + k, "c" + next);
    } else {
      element("z" + next, R"("kind": "0")");
      bond("v" + k, "z" + next);
      bond("z" + next, "c" + next);
      bond("z" + next, "v" + next);
    }
  }
  return R"({"bgsim": 1, "name": "box", "signals": {)" + signals + R"(}, "elements": {)" + elements +
         R"(}, "bonds": [)" + bonds + R"(], "outputs": {)" + outputs + R"(}, "scenes": {"run": {"stop": )" +
         number(box.stop) + R"(, "samples": 101}}})";
}

/// Places of the balls at the times @p times, by exact flights between impacts of two partners.
std::vector<std::vector<double>> exact_places(Box box, const std::vector<double>& times) {
  const std::size_t count = box.masses.size();
  std::vector<std::vector<double>> rows;
  double now = 0.0;
  // A light ball between a heavy one and a wall may be hit without end in a finite time; these boxes have no such ball.
  for (int impacts = 0; rows.size() < times.size(); ++impacts) {
    REQUIRE(impacts < 1000);
    double next = std::numeric_limits<double>::infinity();
    std::size_t where = 0;
    const auto meets = [&](double way, double closing, std::size_t contact) {
      if (closing > 0.0 && now + way / closing < next) next = now + way / closing, where = contact;
    };
    meets(box.places.front(), -box.speeds.front(), 0);
    for (std::size_t i = 0; i + 1 < count; ++i)
      meets(box.places[i + 1] - box.places[i], box.speeds[i] - box.speeds[i + 1], i + 1);
    meets(box.width - box.places.back(), box.speeds.back(), count);
    while (rows.size() < times.size() && times[rows.size()] < next) {
      std::vector<double> row(count);
      for (std::size_t i = 0; i < count; ++i) row[i] = box.places[i] + box.speeds[i] * (times[rows.size()] - now);
      rows.push_back(std::move(row));
    }
    for (std::size_t i = 0; i < count; ++i) box.places[i] += box.speeds[i] * (next - now);
    now = next;
    const double e = box.restitutions[where];
    if (where == 0) {
      box.speeds.front() *= -e;
    } else if (where == count) {
      box.speeds.back() *= -e;
    } else {
      const double a = 1.0 / box.masses[where - 1], b = 1.0 / box.masses[where];
      const double impulse = (1.0 + e) * (box.speeds[where - 1] - box.speeds[where]) / (a + b);
      box.speeds[where - 1] -= impulse * a;
      box.speeds[where] += impulse * b;
    }
  }
  return rows;
}

}  // namespace

TEST_CASE("balls in a box collide as computed from impact to impact, by every method", "[long]") {
  for (unsigned seed = 1; seed <= 12; ++seed)
    for (const Method method :
         {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4}) {
      const Box box = random_box(seed);
      INFO("seed " << seed << ", " << box.masses.size() << " balls, " << facts_of(method).name);
      const RunResult result = Study::from_text(model_of(box)).scene("", with_method(method, 1e-6)).simulate(untimed());
      REQUIRE(result.stop == StopReason::completed);
      const auto exact = exact_places(box, result.trace.times);
      double worst = 0.0;
      for (std::size_t row = 0; row < exact.size(); ++row)
        for (std::size_t i = 0; i < box.masses.size(); ++i)
          worst = std::max(worst, std::abs(result.trace.columns[i][row] - exact[row][i]));
      // Flights are straight lines, which every method follows exactly: rounding, enlarged by some forty impacts.
      CHECK(worst < 1e-10);
    }
}
