/// Three results printed in the example reports of MTT (2003) that energy or reciprocity refute, beside the right ones,
/// and the naive reading of the paper's Eq. 2.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "model/constitutive.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;
using test::column;
using test::run;
using test::study_of;

const std::string kFolder = "tests/data/models/";

/// Times at which a column changes sign, by linear interpolation between records.
std::vector<double> zero_crossings(const RunResult& result, const std::string& name) {
  const std::vector<double> values = column(result, name);
  std::vector<double> times;
  for (std::size_t i = 1; i < values.size(); ++i)
    if ((values[i - 1] > 0) != (values[i] > 0)) {
      const double part = values[i - 1] / (values[i - 1] - values[i]);
      times.push_back(result.trace.times[i - 1] + part * (result.trace.times[i] - result.trace.times[i - 1]));
    }
  return times;
}

std::pair<double, double> range(const std::vector<double>& values) {
  return {*std::min_element(values.begin(), values.end()), *std::max_element(values.begin(), values.end())};
}

Reciprocity reciprocity_of(const Study& study, const std::string& field) {
  for (std::size_t i = 0; i < study.model().elements.size(); ++i)
    if (study.model().elements[i].name == field) return test_reciprocity(study.model(), ElementId(i));
  FAIL("no field " << field);
  return {};
}

TEST_CASE("the printed pendulum swings too slowly and its energy swings with it") {
  const auto study = study_of(kFolder + "pendulum_printed.json");
  const auto printed = run(study, "printed");
  const auto crossings = zero_crossings(printed, "theta");
  REQUIRE(crossings.size() == 3);
  // figures printed to three digits
  CHECK(crossings[0] == Approx(1.95).margin(0.01));
  CHECK(crossings[1] == Approx(5.87).margin(0.01));
  CHECK(crossings[2] == Approx(9.78).margin(0.01));
  const auto [low, high] = range(column(printed, "energy"));
  CHECK(low == Approx(0.22).margin(0.005));
  CHECK(high == Approx(2.87).margin(0.005));
  // A lossless system without a source: the audit finds the energy that the source named error moves.
  REQUIRE(printed.report.energy.done);
  CHECK(std::abs(printed.report.energy.supplied) > 1e-3);

  const auto sound = run(study, "sound");
  const auto [least, most] = range(column(sound, "energy"));
  CHECK(most - least < 1e-6 * most);
}

TEST_CASE("the pendulum from its graph keeps its energy and has the physical period of 2.17 s") {
  const auto result = run(study_of(kFolder + "rod_pendulum.json"));
  const auto [low, high] = range(column(result, "energy"));
  CHECK(high - low < 1e-6 * high);
  const auto crossings = zero_crossings(result, "theta");
  REQUIRE(crossings.size() > 2);
  CHECK(crossings[2] - crossings[0] == Approx(2.17).margin(0.005));
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.relative < 1e-6);
}

TEST_CASE("the printed leaky cylinder makes energy: 550 J become 633.6 J within 0.02 s") {
  const auto study = study_of(kFolder + "cylinder_printed.json");
  CHECK(test::at(run(study, "printed"), "total", 0.02) == Approx(633.6687).margin(1e-3));
  const auto right = column(run(study, "right"), "total");
  for (const double total : right) CHECK(total == Approx(550).epsilon(1e-8));
}

TEST_CASE("the cylinder from its graph moves as the right signs make it and keeps 550 J") {
  const auto graph = run(study_of(kFolder + "cylinder.json"));
  for (const double total : column(graph, "total")) CHECK(total == Approx(550).epsilon(1e-8));
  const auto right = run(study_of(kFolder + "cylinder_printed.json"), "right");
  const auto v = column(graph, "v");
  CHECK(test::largest_difference(v, column(right, "v")) < 1e-7 * test::largest_magnitude(v));
  REQUIRE(graph.report.energy.done);
  CHECK(graph.report.energy.relative < 1e-7);
}

TEST_CASE("the printed loudspeaker violates Maxwell reciprocity, and from its energy it cannot") {
  const auto printed = reciprocity_of(study_of(kFolder + "loudspeaker_printed.json"), "field");
  CHECK(printed.verdict == Reciprocity::Verdict::violated);
  CHECK(!printed.text.empty());
  const auto sound = reciprocity_of(study_of(kFolder + "loudspeaker.json"), "field");
  CHECK(sound.verdict == Reciprocity::Verdict::by_energy);
}

TEST_CASE("C2(x) put into the bellow's laws as they stand violates reciprocity, and from its energy it cannot") {
  const auto naive = reciprocity_of(study_of(kFolder + "bellow_naive.json"), "field");
  CHECK(naive.verdict == Reciprocity::Verdict::violated);
  const auto sound = reciprocity_of(study_of("models/bellow_compliance.json"), "field");
  CHECK(sound.verdict == Reciprocity::Verdict::by_energy);
}

}  // namespace
