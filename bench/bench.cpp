// Times every stage on generated ladders of growing size. Sizes are compared within one run, so that the machine's
// speed cancels: a stage that is linear in the model takes ten times as long for ten times as many elements.
//   bench [ELEMENTS]...      default: 1000 10000 100000
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "ladder.hpp"

namespace {

using namespace bgsim;

struct Stage {
  std::string name;
  double seconds = 0.0;
};

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<Stage> time_stages(std::size_t elements) {
  std::vector<Stage> stages;
  const auto timed = [&stages](const char* name, const std::function<void()>& work) {
    stages.push_back({name, seconds_of(work)});
  };
  const std::string text = bench::ladder_json(elements / 4, 2);
  std::optional<Study> study;
  timed("read", [&] { study = Study::from_text(text, "ladder.json"); });
  static_cast<void>(study->order());
  for (const auto& [name, seconds] : study->seconds()) stages.push_back({name, seconds});
  RunInputs inputs;
  timed("scene", [&] { inputs = prepare_scene(study->model(), ""); });
  const Simulation scene = study->scene(inputs, {.energy_audit = false, .keep_all = true});
  for (const auto& [name, seconds] : scene.seconds()) stages.push_back({name, seconds});
  SimulateOptions options;
  options.energy_audit = false;
  options.error_estimate = false;
  RunResult result;
  timed("simulate", [&] { result = scene.simulate(options); });
  if (result.stop != StopReason::completed) {
    std::fprintf(stderr, "the run of %zu elements did not end: %s\n", elements, result.failure->situation.c_str());
    std::exit(1);
  }
  return stages;
}

void print(const std::vector<std::size_t>& sizes, const std::vector<std::vector<Stage>>& runs) {
  std::printf("%-10s", "stage");
  for (const std::size_t size : sizes) std::printf("  %10zu el.", size);
  std::printf("   us/element  growth per tenfold\n");
  for (std::size_t s = 0; s < runs.front().size(); ++s) {
    std::printf("%-10s", runs.front()[s].name.c_str());
    for (const auto& run : runs) std::printf("  %11.4f s ", run[s].seconds);
    const double last = runs.back()[s].seconds;
    std::printf("  %10.3f", 1e6 * last / static_cast<double>(sizes.back()));
    if (runs.size() > 1) {
      const double growth = last / runs[runs.size() - 2][s].seconds;
      const double sizes_grow = static_cast<double>(sizes.back()) / static_cast<double>(sizes[sizes.size() - 2]);
      std::printf("  %10.1f", 10.0 * growth / sizes_grow);
    }
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::size_t> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10));
  if (sizes.empty()) sizes = {1000, 10000, 100000};
  std::vector<std::vector<Stage>> runs;
  for (const std::size_t size : sizes) runs.push_back(time_stages(size));
  print(sizes, runs);
}
