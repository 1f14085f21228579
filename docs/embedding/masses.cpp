// A mass on a spring, run with several masses in as many threads. Says for each how far the spring is stretched at
// most.
#include <algorithm>
#include <bgsim/bgsim.hpp>
#include <cmath>
#include <iostream>
#include <thread>
#include <vector>

const char* const kModel = R"({
  "bgsim": 1, "name": "swing",
  "parameters": { "m": 1, "k": 100 },
  "elements": {
    "speed":  { "kind": "1" },
    "mass":   { "kind": "I", "inertance": "m", "initial": { "p": 1 } },
    "spring": { "kind": "C", "law": "e = k*q" }
  },
  "bonds": [ { "from": "speed", "to": "mass" }, { "from": "speed", "to": "spring" } ],
  "outputs": { "x": "spring.q" },
  "scenes": { "free": { "stop": 2, "samples": 2001, "relative": 1e-8 } }
})";

int main() {
  try {
    const bgsim::Study study = bgsim::Study::from_text(kModel);
    std::cout << study.order().blocks.size() << " algebraic loops\n";

    const bgsim::Simulation scene = study.scene("free");
    const std::vector<double> masses{1.0, 4.0, 25.0};
    std::vector<double> largest(masses.size());
    {
      std::vector<std::jthread> threads;
      for (std::size_t i = 0; i < masses.size(); ++i)
        threads.emplace_back([&, i] {
          const bgsim::RunResult result = scene.with("m", masses[i]).simulate();
          if (result.stop == bgsim::StopReason::completed)
            largest[i] = *std::max_element(result.trace["x"].begin(), result.trace["x"].end());
        });
    }
    bool right = true;
    for (std::size_t i = 0; i < masses.size(); ++i) {
      std::cout << "m = " << masses[i] << ": " << largest[i] << " m\n";
      // p0/sqrt(k m); a record every ms misses the peak by less than 1e-4 of it
      right = right && std::abs(largest[i] * std::sqrt(100.0 * masses[i]) - 1.0) < 1e-4;
    }
    return right ? 0 : 1;
  } catch (const bgsim::ModelError& error) {
    std::cerr << bgsim::render(error);
    return 1;
  }
}
