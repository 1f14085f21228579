// What each method costs and how exact it is, over all scenes: the table behind the choice of `auto`.
//   bench_methods [--seconds S] [FILE[:SCENE]]...     default: models/ and tests/data/models/
//   bench_methods [--seconds S] --pair METHOD METHOD [FILE[:SCENE]]...   default: models/
//   bench_methods --random SEEDS [--from STATES] [FAMILY]...   random models of 2 to 300 states (families.hpp)
//
// Every scene by every method at 1e-4, 1e-6 and 1e-9, without audit and estimate of errors. Errors are the largest of
// all outputs relative to the output's range, against the most exact of several methods at 1e-11; the reference's own
// error is how far a second one stays from it. Times are processor times of simulate() alone, the least of several
// runs. Prints a line for each run (tab-separated), then how `auto` compares with the best row of each scene: the
// cheapest that is at least as exact as `auto` at that tolerance.
//
// A pair: what the first takes of the steps, the processor time and the error of the second, at 1e-4, 1e-6 and 1e-8,
// and of the time at equal error, if the error falls with the fifth power of it.
//
// Random models: the processor time that each method takes to an error of 1e-3, 1e-5 and 1e-7, over tolerances half a
// decade apart, as a multiple of what the best of them takes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "families.hpp"

namespace {

using namespace bgsim;

constexpr std::array<double, 3> kTolerances{1e-4, 1e-6, 1e-9};
constexpr std::array kMethodsToTry{Method::automatic, Method::bdf,  Method::radau, Method::adams,
                                   Method::erk5,      Method::erk8, Method::dirk5, Method::ida};
constexpr double kTight = 1e-11;
/// Part of an output's magnitude below which its variation is not judged.
constexpr double kConstant = 1e-9;

double seconds_now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Timed {
  RunResult result;
  double seconds = 0.0;
  bool whole = false;
};

Timed run(const Simulation& scene, RunInputs inputs, Method method, double relative, double limit) {
  inputs.method = method;
  inputs.max_order = 0;
  inputs.relative = relative;
  SimulateOptions options;
  options.energy_audit = options.error_estimate = false;
  const double begin = seconds_now();
  options.progress = [&](double) { return seconds_now() - begin < limit; };
  Timed timed;
  timed.result = scene.simulate(inputs, options);
  timed.seconds = seconds_now() - begin;
  timed.whole = timed.result.stop == StopReason::completed;
  return timed;
}

/// By output, the largest distance relative to the reference's range.
std::vector<double> distances(const Trace& trace, const Trace& reference) {
  std::vector<double> all;
  for (std::size_t c = 0; c < reference.columns.size(); ++c) {
    double low = std::numeric_limits<double>::infinity(), high = -low, largest = 0.0;
    for (std::size_t i = 0; i < reference.times.size(); ++i) {
      low = std::min(low, reference.columns[c][i]);
      high = std::max(high, reference.columns[c][i]);
      largest = std::max(largest, std::abs(trace.columns[c][i] - reference.columns[c][i]));
    }
    const double magnitude = std::max(std::abs(low), std::abs(high));
    const double range = high - low > kConstant * magnitude ? high - low : magnitude;
    all.push_back(range > 0.0 ? largest / range : largest > 0.0 ? std::numeric_limits<double>::infinity() : 0.0);
  }
  return all;
}

struct Reference {
  Trace trace;
  std::vector<double> own;
};

std::optional<Reference> reference_of(const Simulation& scene, RunInputs inputs, double limit) {
  inputs.absolute.reset();
  inputs.absolute_by_state.clear();
  std::vector<Trace> traces;
  std::optional<Reference> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Method method : {Method::radau, Method::dirk5, Method::bdf, Method::erk8, Method::adams, Method::ida}) {
    Timed timed = run(scene, inputs, method, kTight, limit);
    if (!timed.whole) continue;
    for (const Trace& other : traces) {
      std::vector<double> own = distances(timed.result.trace, other);
      double sum = 0.0;
      for (const double distance : own) sum += std::min(distance, 1.0);
      if (sum < least) {
        least = sum;
        best = Reference{other, std::move(own)};
      }
    }
    traces.push_back(std::move(timed.result.trace));
    if (least < 1e-9 && traces.size() > 1) break;
  }
  return best;
}

struct Row {
  Method method = Method::automatic;
  double relative = 0.0, seconds = 0.0, error = 0.0;
  bool whole = false;
  std::string by;
  std::uint64_t steps = 0, rates = 0;
  [[nodiscard]] bool same_run(const Row& other) const {
    return whole && other.whole && relative == other.relative && by == other.by && steps == other.steps &&
           rates == other.rates;
  }
};

struct Totals {
  std::vector<double> ratios;
  std::vector<std::string> dear;
};

void measure(const std::string& file, const std::string& scene, double limit, Totals& totals) {
  const Simulation compiled = Study(file).scene(scene, {}, {.keep_all = false});
  const Program& program = compiled.program();
  const RunInputs& inputs = compiled.inputs();
  const std::string name = compiled.model().name + " " + inputs.scene;
  if (program.state_names.empty() || program.output_names.empty()) return;
  const std::optional<Reference> reference = reference_of(compiled, inputs, 4.0 * limit);
  std::vector<Row> rows;
  for (const double relative : kTolerances)
    for (const Method method : kMethodsToTry) {
      Timed timed = run(compiled, inputs, method, relative, limit);
      Row row{method, relative, timed.seconds, std::numeric_limits<double>::quiet_NaN(), timed.whole, {}, 0, 0};
      // Short runs scatter more, and cost less.
      for (int repeat = 0; timed.whole && repeat < (timed.seconds < 0.005 ? 8 : timed.seconds < 0.1 ? 3 : 1); ++repeat)
        row.seconds = std::min(row.seconds, run(compiled, inputs, method, relative, limit).seconds);
      std::string worst;
      if (timed.whole && reference) {
        row.error = 0.0;
        const std::vector<double> all = distances(timed.result.trace, reference->trace);
        for (std::size_t c = 0; c < all.size(); ++c)
          if (reference->own[c] < 1e-3 && all[c] >= row.error) {
            row.error = std::max(all[c], reference->own[c]);
            worst = program.output_names[c];
          }
      }
      const RunReport& report = timed.result.report;
      std::printf("%s\t%zu\t%zu\t%s\t%.0e\t%.3f\t%llu\t%llu\t%llu\t%llu\t%.1e\t%s\t%s\n", name.c_str(),
                  program.state_names.size(), program.blocks.size(), method_name(method).c_str(), relative,
                  1e3 * row.seconds, static_cast<unsigned long long>(report.steps),
                  static_cast<unsigned long long>(report.rate_evaluations),
                  static_cast<unsigned long long>(report.jacobian_evaluations),
                  static_cast<unsigned long long>(report.factorizations), row.error, worst.c_str(),
                  timed.whole            ? report.method.c_str()
                  : timed.result.failure ? timed.result.failure->code.c_str()
                                         : "cut");
      std::fflush(stdout);
      row.by = report.method;
      row.steps = report.steps;
      row.rates = report.rate_evaluations;
      rows.push_back(row);
    }
  // What `auto` chooses is there by its own name as well: one run, of which the least time counts. The difference would
  // be that of two measurements of the same.
  for (Row& row : rows)
    for (const Row& other : rows)
      if (row.same_run(other)) row.seconds = std::min(row.seconds, other.seconds);
  for (const double relative : kTolerances) {
    const auto own = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
      return row.method == Method::automatic && row.relative == relative;
    });
    if (!own->whole || !(own->error == own->error)) continue;
    double best = own->seconds;
    Method by = Method::automatic;
    for (const Row& row : rows)
      if (row.whole && row.error <= own->error && row.seconds < best) {
        best = row.seconds;
        by = row.method;
      }
    totals.ratios.push_back(own->seconds / best);
    char text[200];
    std::snprintf(text, sizeof text, "%s at %.0e: %.2f times %s", name.c_str(), relative, own->seconds / best,
                  method_name(by).c_str());
    if (own->seconds / best > 1.5) totals.dear.emplace_back(text);
  }
}

// --- two methods

constexpr std::array<double, 3> kPairTolerances{1e-4, 1e-6, 1e-8};

struct Pair {
  std::array<Method, 2> methods{};
  /// By tolerance, the first over the second.
  struct Ratios {
    std::vector<double> steps, seconds, errors, at_equal_error;
  };
  std::array<Ratios, kPairTolerances.size()> ratios;
};

/// The least of several runs; short ones scatter more, and cost less.
Timed timed_run(const Simulation& scene, Method method, double relative, double limit) {
  Timed timed = run(scene, scene.inputs(), method, relative, limit);
  for (int repeat = 0; timed.whole && repeat < (timed.seconds < 0.005 ? 8 : timed.seconds < 0.1 ? 3 : 1); ++repeat)
    timed.seconds = std::min(timed.seconds, run(scene, scene.inputs(), method, relative, limit).seconds);
  return timed;
}

void measure_pair(const std::string& file, const std::string& scene, double limit, Pair& pair) {
  const Simulation compiled = Study(file).scene(scene, {}, {.keep_all = false});
  if (compiled.program().state_names.empty() || compiled.program().output_names.empty()) return;
  const std::optional<Reference> reference = reference_of(compiled, compiled.inputs(), 4.0 * limit);
  if (!reference) return;
  for (std::size_t k = 0; k < kPairTolerances.size(); ++k) {
    std::array<double, 2> steps{}, seconds{}, errors{};
    bool whole = true;
    std::printf("%s %s\t%.0e", compiled.model().name.c_str(), compiled.inputs().scene.c_str(), kPairTolerances[k]);
    for (std::size_t m = 0; m < 2; ++m) {
      const Timed timed = timed_run(compiled, pair.methods[m], kPairTolerances[k], limit);
      whole = whole && timed.whole;
      steps[m] = static_cast<double>(timed.result.report.steps);
      seconds[m] = timed.seconds;
      if (timed.whole) {
        const std::vector<double> all = distances(timed.result.trace, reference->trace);
        for (std::size_t c = 0; c < all.size(); ++c)
          if (reference->own[c] < 0.1 * kPairTolerances[k]) errors[m] = std::max(errors[m], all[c]);
      }
      std::printf("\t%.0f\t%.3f\t%.1e", steps[m], 1e3 * seconds[m], errors[m]);
    }
    std::printf("%s\n", whole ? "" : "\tcut");
    std::fflush(stdout);
    if (!whole || steps[1] == 0.0) continue;
    Pair::Ratios& ratios = pair.ratios[k];
    ratios.steps.push_back(steps[0] / steps[1]);
    ratios.seconds.push_back(seconds[0] / seconds[1]);
    constexpr double kRounding = 1e-13;
    if (errors[0] < kRounding || errors[1] < kRounding) continue;
    ratios.errors.push_back(errors[0] / errors[1]);
    ratios.at_equal_error.push_back(ratios.seconds.back() * std::pow(ratios.errors.back(), 0.2));
  }
}

void print_pair(Pair& pair) {
  std::printf("\n%s over %s\ttolerance\tscenes\t10 in 100 below\t25\tmedian\t75\t90\tlargest\n",
              method_name(pair.methods[0]).c_str(), method_name(pair.methods[1]).c_str());
  const auto print = [](const char* what, double tolerance, std::vector<double>& all) {
    if (all.empty()) return;
    std::sort(all.begin(), all.end());
    std::printf("%s\t%.0e\t%zu", what, tolerance, all.size());
    for (const double part : {0.1, 0.25, 0.5, 0.75, 0.9, 1.0})
      std::printf("\t%.2f", all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1) + 0.5)]);
    std::printf("\n");
  };
  for (std::size_t k = 0; k < kPairTolerances.size(); ++k) {
    print("steps", kPairTolerances[k], pair.ratios[k].steps);
    print("processor time", kPairTolerances[k], pair.ratios[k].seconds);
    print("error", kPairTolerances[k], pair.ratios[k].errors);
    print("time at equal error", kPairTolerances[k], pair.ratios[k].at_equal_error);
  }
}

// --- random models

constexpr std::array<std::size_t, 16> kSizes{2, 4, 6, 8, 10, 12, 16, 20, 28, 40, 50, 70, 100, 140, 200, 300};
constexpr std::array kContenders{Method::automatic, Method::bdf, Method::radau, Method::erk5, Method::adams};
constexpr std::array<double, 3> kErrors{1e-3, 1e-5, 1e-7};

/// The least time of a method to each of kErrors.
std::array<double, 3> times_to(const Simulation& scene, const Reference& reference, Method method, double limit) {
  constexpr int kLoosest = 4, kTightest = 21, kRepeats = 3;
  std::array<double, 3> least;
  least.fill(std::numeric_limits<double>::infinity());
  for (int k = kLoosest; k <= kTightest; ++k) {
    const double relative = std::pow(10.0, -0.5 * k);
    Timed timed = run(scene, scene.inputs(), method, relative, limit);
    if (!timed.whole) {
      if (timed.seconds >= limit) break;
      continue;
    }
    double error = 0.0;
    const std::vector<double> all = distances(timed.result.trace, reference.trace);
    for (std::size_t c = 0; c < all.size(); ++c)
      if (reference.own[c] < 0.1 * kErrors.back()) error = std::max(error, all[c]);
    if (timed.seconds >= least.back()) break;
    for (int repeat = 1; repeat < kRepeats && timed.seconds < 0.05; ++repeat)
      timed.seconds = std::min(timed.seconds, run(scene, scene.inputs(), method, relative, limit).seconds);
    for (std::size_t e = 0; e < kErrors.size(); ++e)
      if (error <= kErrors[e]) least[e] = std::min(least[e], timed.seconds);
  }
  return least;
}

void measure_random(const std::string& family, std::uint32_t seeds, double limit, std::size_t fewest) {
  for (const std::size_t size : kSizes)
    for (std::uint32_t seed = 0; seed < seeds && size >= fewest; ++seed) {
      const Simulation scene = Study::from_text(bench::family_model(family, size, seed)).scene();
      const std::optional<Reference> reference = reference_of(scene, scene.inputs(), 4.0 * limit);
      if (!reference) {
        std::printf("%s\t%zu\t%u\tno reference\n", family.c_str(), size, seed);
        continue;
      }
      std::vector<std::array<double, 3>> times;
      double longest = limit;  // what takes ten times as long as another is of no interest
      for (const Method method : kContenders) {
        times.push_back(times_to(scene, *reference, method, longest));
        longest = std::min(longest, 10.0 * times.back().back());
      }
      for (std::size_t e = 0; e < kErrors.size(); ++e) {
        double best = std::numeric_limits<double>::infinity();
        for (const auto& of : times) best = std::min(best, of[e]);
        std::printf("%s\t%zu\t%u\t%.0e\t%.3f", family.c_str(), scene.program().state_names.size(), seed, kErrors[e],
                    1e3 * best);
        for (const auto& of : times) std::printf("\t%.2f", of[e] / best);
        std::printf("\n");
      }
      std::fflush(stdout);
    }
}

std::vector<std::string> all_models(const std::vector<const char*>& folders) {
  std::vector<std::string> files;
  for (const char* folder : folders)
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".json") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> items(argv + 1, argv + argc);
  double limit = 2.0;
  if (items.size() >= 2 && items[0] == "--seconds") {
    limit = std::stod(items[1]);
    items.erase(items.begin(), items.begin() + 2);
  }
  if (items.size() >= 2 && items[0] == "--random") {
    const auto seeds = static_cast<std::uint32_t>(std::stoul(items[1]));
    items.erase(items.begin(), items.begin() + 2);
    std::size_t fewest = 0;
    if (items.size() >= 2 && items[0] == "--from") {
      fewest = std::stoul(items[1]);
      items.erase(items.begin(), items.begin() + 2);
    }
    std::printf("family\tstates\tseed\terror\tbest, ms");
    for (const Method method : kContenders) std::printf("\t%s", method_name(method).c_str());
    std::printf("\n");
    for (const std::string& family : items.empty() ? bench::family_names() : items)
      measure_random(family, seeds, limit, fewest);
    return 0;
  }
  std::optional<Pair> pair;
  if (items.size() >= 3 && items[0] == "--pair") {
    pair.emplace();
    for (std::size_t m = 0; m < 2; ++m) pair->methods[m] = method_from(items[1 + m]).value();
    items.erase(items.begin(), items.begin() + 3);
    if (items.empty()) items = all_models({"models"});
    std::printf("scene\ttolerance\tsteps\tms\terror\tsteps\tms\terror\n");
  } else {
    if (items.empty()) items = all_models({"models", "tests/data/models"});
    std::printf(
        "scene\tstates\tloops\tmethod\ttolerance\tms\tsteps\trates\tJacobians\tfactorizations\terror\toutput\tby\n");
  }
  Totals totals;
  for (const std::string& item : items) {
    const std::size_t colon = item.rfind(':');
    const std::string file = item.substr(0, colon);
    try {
      const Study study(file);
      std::vector<std::string> scenes;
      if (colon != std::string::npos)
        scenes.push_back(item.substr(colon + 1));
      else
        for (const Scene& scene : study.model().scenes) scenes.push_back(scene.name);
      for (const std::string& scene : scenes)
        if (pair)
          measure_pair(file, scene, limit, *pair);
        else
          measure(file, scene, limit, totals);
    } catch (const ModelError&) {
      continue;  // a submodel, which has no scene
    }
  }
  if (pair) print_pair(*pair);
  std::sort(totals.ratios.begin(), totals.ratios.end());
  if (totals.ratios.empty()) return 0;
  const auto part = [&](double quantile) {
    return totals.ratios[static_cast<std::size_t>(quantile * static_cast<double>(totals.ratios.size() - 1) + 0.5)];
  };
  std::printf(
      "\n%zu runs by auto; cost over that of the best row at least as exact: median %.2f, 90 in 100 below %.2f, "
      "95 below %.2f, largest %.2f\n",
      totals.ratios.size(), part(0.5), part(0.9), part(0.95), part(1.0));
  for (const std::string& text : totals.dear) std::printf("%s\n", text.c_str());
}
