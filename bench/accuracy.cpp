// What --accuracy costs: the processor time of its search over that of the run that it finds.
//   bench_accuracy [FILE:SCENE]...     default: the scenes of bellow and actuator
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace {

using namespace bgsim;

constexpr std::array<double, 3> kAccuracies{1e-4, 1e-6, 1e-9};

const std::vector<std::string> kScenes{
    "models/bellow.json:tracking",
    "models/bellow.json:step",
    "models/bellow.json:literal",
    "models/bellow.json:physical",
    "models/bellow_compliance.json:tracking",
    "models/bellow_paper_eq3.json:tracking",
    "models/bellow_paper_eq3.json:step",
    "models/actuator.json:bending",
    "models/actuator.json:extension",
    "models/actuator_masses.json:bending",
    "models/actuator_masses.json:quarter",
};

void measure(const std::string& file, const std::string& scene, std::vector<double>& ratios) {
  const Simulation compiled = Study(file).scene(scene, {}, {.keep_all = true});
  const std::string name = compiled.model().name + " " + compiled.inputs().scene;
  for (const double accuracy : kAccuracies) {
    try {
      const TradePick pick = find_setting(compiled.program(), compiled.inputs(), accuracy, {});
      const double ratio = pick.search_seconds / pick.cpu_seconds;
      ratios.push_back(ratio);
      std::printf("| %s | %.0e | `%s` | %.1e | `%s` | %.1e | %zu | %.1f |\n", name.c_str(), accuracy,
                  setting_flags(pick.setting).substr(2).c_str(), std::max(pick.error, pick.check_error),
                  setting_flags(pick.reference.second).substr(2).c_str(), pick.reference.error, pick.runs, ratio);
    } catch (const TradeFailure& failure) {
      std::printf("| %s | %.0e | %s %s | | | | | |\n", name.c_str(), accuracy, failure.diagnostic.code.c_str(),
                  failure.diagnostic.situation.c_str());
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes(argv + 1, argv + argc);
  if (scenes.empty()) scenes = kScenes;
  std::printf(
      "| scene | accuracy | found | its error | second method | agrees to | runs | search / run |\n"
      "|---|---|---|---|---|---|---|---|\n");
  std::vector<double> ratios;
  for (const std::string& item : scenes) {
    const std::size_t colon = item.rfind(':');
    measure(item.substr(0, colon), colon == std::string::npos ? "" : item.substr(colon + 1), ratios);
  }
  if (ratios.empty()) return 0;
  std::sort(ratios.begin(), ratios.end());
  std::printf("\n%zu found; search over run: median %.1f, largest %.1f\n", ratios.size(), ratios[ratios.size() / 2],
              ratios.back());
}
