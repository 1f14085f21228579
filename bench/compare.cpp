// bgsim against the same equations written by hand and given to CVODE, and against SciPy, at equal error: the tables
// "Against hand-written C" of docs/performance.md, as Markdown.
//   bench_compare BGSIM PYTHON [CASE]...     BGSIM: the command, for whole processes; PYTHON: "-" if there is no SciPy
//
// An error is the largest of all outputs at the scene's output times, relative to the output's range, against the more
// exact of two references by different programs or methods. Each contender is tried at tolerances from 1e-2 on, half a
// decade apart; of the first three that reach the error asked for the cheapest is its setting. Then all settings of a
// case are run in turn, and the medians of their processor times compared. bgsim is simulate(), without audit and
// estimate of errors, which the others do not have; all make their outputs at all output times.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "by_hand.hpp"

namespace {

using namespace bgsim;
using Columns = std::vector<std::vector<double>>;

double seconds_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// One run of a contender.
struct Timed {
  bool whole = false;
  double seconds = 0.0;
  long steps = 0;
  std::string by;
  Columns columns;
};

struct Contender {
  std::string name;
  std::function<Timed(double relative)> run;
  double must = 0.0;      ///< bgsim's time over this one's; 0: nothing is asked
  double longest = 20.0;  ///< seconds of a run, beyond which no tighter tolerance is tried
};

struct Case {
  std::string name;
  std::size_t states = 0;
  double error = 1e-4;
  std::vector<Contender> contenders;  ///< the first is bgsim
  std::vector<Timed> references;
};

Timed run_bgsim(const Program& program, RunInputs inputs, Method method, double relative) {
  inputs.method = method;
  inputs.max_order = 0;
  inputs.relative = relative;
  SimulateOptions options;
  options.energy_audit = options.error_estimate = false;
  const double begin = seconds_now();
  RunResult result = simulate(program, inputs, options);
  return {result.stop == StopReason::completed, seconds_now() - begin, static_cast<long>(result.report.steps),
          result.report.method, std::move(result.trace.columns)};
}

Timed run_hand(const bench::ByHand& model, const std::vector<double>& times, double relative) {
  const double begin = seconds_now();
  bench::HandRun run = bench::run_by_hand(model, times, relative);
  return {run.whole, seconds_now() - begin, run.steps, "CVODE BDF", std::move(run.columns)};
}

/// compare_scipy.py runs one case and prints its processor time, its steps, and the outputs by column.
Timed run_scipy(const std::string& python, const std::string& name, const char* method, double stop, std::size_t times,
                double relative) {
  std::ostringstream command;
  command << python << " bench/compare_scipy.py \"" << name << "\" " << method << ' ' << relative << ' ';
  command.precision(17);
  command << stop << ' ' << times << " 2>/dev/null";
  FILE* pipe = popen(command.str().c_str(), "r");
  Timed timed;
  timed.by = method;
  std::string text;
  char buffer[65536];
  for (std::size_t got = 0; (got = fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, got);
  if (pclose(pipe) != 0) return timed;
  std::istringstream lines(text);
  std::string line;
  lines >> timed.seconds >> timed.steps;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream values(line);
    timed.columns.emplace_back();
    for (double value = 0.0; values >> value;) timed.columns.back().push_back(value);
  }
  timed.whole = !timed.columns.empty() && timed.columns.front().size() == times;
  return timed;
}

double distance(const std::vector<double>& values, const std::vector<double>& reference) {
  const auto [low, high] = std::minmax_element(reference.begin(), reference.end());
  double largest = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) largest = std::max(largest, std::abs(values[i] - reference[i]));
  return *high > *low ? largest / (*high - *low) : largest > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
}

/// The largest error of the outputs that the references agree on to a tenth of what is asked for.
double error_of(const Case& one, const Columns& columns) {
  double largest = 0.0;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<double>& reference = one.references[0].columns[c];
    if (distance(one.references[1].columns[c], reference) > 0.1 * one.error) continue;
    largest = std::max(largest, distance(columns[c], reference));
  }
  return largest;
}

struct Setting {
  double relative = 0.0, error = 0.0, seconds = std::numeric_limits<double>::infinity();
  Timed timed;
};

Setting cheapest(const Case& one, const Contender& contender) {
  constexpr int kEnough = 3;
  Setting best;
  int reached = 0;
  for (int k = 4; k <= 27 && reached < kEnough; ++k) {
    const double relative = std::pow(10.0, -0.5 * k);
    Timed timed = contender.run(relative);
    const double error = timed.whole ? error_of(one, timed.columns) : std::numeric_limits<double>::infinity();
    if (error <= one.error) ++reached;
    const double seconds = timed.seconds;
    if (error <= one.error && seconds < best.seconds) best = {relative, error, seconds, std::move(timed)};
    if (seconds > contender.longest) break;
  }
  return best;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare(Case one) {
  if (!one.references[0].whole || !one.references[1].whole) {
    std::printf("| %s | %zu | no reference | | | | | | |\n", one.name.c_str(), one.states);
    return;
  }
  std::size_t unknown = 0;
  for (std::size_t c = 0; c < one.references[0].columns.size(); ++c) {
    const double own = distance(one.references[1].columns[c], one.references[0].columns[c]);
    if (own > 0.1 * one.error) ++unknown;
  }
  std::vector<Setting> settings;
  for (const Contender& contender : one.contenders) settings.push_back(cheapest(one, contender));
  std::vector<std::vector<double>> seconds(settings.size());
  const double longest = std::max_element(settings.begin(), settings.end(), [](const Setting& a, const Setting& b) {
                           return (std::isinf(a.seconds) ? 0.0 : a.seconds) < (std::isinf(b.seconds) ? 0.0 : b.seconds);
                         })->seconds;
  const int rounds = longest < 0.1 ? 15 : longest < 1.0 ? 7 : 3;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < settings.size(); ++i)
      if (settings[i].relative > 0.0) seconds[i].push_back(one.contenders[i].run(settings[i].relative).seconds);
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Setting& setting = settings[i];
    std::printf("| %s | %zu | %s | ", i == 0 ? one.name.c_str() : "", one.states, one.contenders[i].name.c_str());
    if (!(setting.relative > 0.0)) {
      std::printf("not reached | | | | | |\n");
      continue;
    }
    const double time = median(seconds[i]);
    std::printf("%.3g | %ld | %.1e | %.0e | ", 1e3 * time, setting.timed.steps, setting.error, setting.relative);
    if (i == 0 || seconds[0].empty()) {
      std::printf("%s | |\n", setting.timed.by.c_str());
      continue;
    }
    const double ratio = median(seconds[0]) / time;
    std::printf("**%.2g** | ", ratio);
    if (one.contenders[i].must > 0.0)
      std::printf("%.2g, %s |\n", one.contenders[i].must, ratio <= one.contenders[i].must ? "yes" : "no");
    else
      std::printf("|\n");
  }
  if (unknown > 0)
    std::printf("| | | %zu of %zu outputs left out: references differ | | | | | | |\n", unknown,
                one.references[0].columns.size());
  std::fflush(stdout);
}

// --- the cases

/// What lives as long as the runs of a case.
struct Prepared {
  Simulation scene;
  std::unique_ptr<bench::ByHand> hand;
  std::vector<double> times;
};

Case case_of(std::string name, Study study, const char* scene, std::unique_ptr<bench::ByHand> hand, Method second,
             double tight) {
  Simulation simulation = study.scene(scene, {}, {.energy_audit = false});
  const OutputTimes& wanted = simulation.inputs().output_times;
  std::vector<double> times;
  for (std::size_t i = 0; i < wanted.size(); ++i) times.push_back(wanted[i]);
  auto all = std::make_shared<Prepared>(Prepared{std::move(simulation), std::move(hand), std::move(times)});
  Case one;
  one.name = std::move(name);
  one.states = all->hand->start.size();
  const auto by = [all](Method method) {
    return [all, method](double relative) {
      return run_bgsim(all->scene.program(), all->scene.inputs(), method, relative);
    };
  };
  one.contenders.push_back({"bgsim", by(Method::automatic)});
  one.contenders.push_back({"C, packaged SUNDIALS", [all](double r) { return run_hand(*all->hand, all->times, r); }});
  one.references.push_back(by(second)(tight));
  one.references.push_back(one.states <= 8 ? by(Method::radau)(tight) : run_hand(*all->hand, all->times, tight));
  return one;
}

std::string ladder_json(std::size_t n, const std::vector<std::size_t>& nodes) {
  std::string elements = R"("source": { "kind": "Se", "effort": 1 })", bonds, outputs;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string k = std::to_string(i), before = i == 0 ? "source" : "node" + std::to_string(i - 1);
    elements += R"(, "loop)" + k + R"(": { "kind": "1" }, "node)" + k + R"(": { "kind": "0" }, "R)" + k +
                R"(": { "kind": "R", "resistance": "R" }, "C)" + k + R"(": { "kind": "C", "capacitance": "C" })";
    for (const auto& [from, to] : {std::pair{before, "loop" + k}, std::pair{"loop" + k, "R" + k},
                                   std::pair{"loop" + k, "node" + k}, std::pair{"node" + k, "C" + k}})
      bonds += (bonds.empty() ? R"({ "from": ")" : R"(, { "from": ")") + from + R"(", "to": ")" + to + "\" }";
  }
  for (const std::size_t node : nodes)
    outputs +=
        (outputs.empty() ? "\"e" : ", \"e") + std::to_string(node) + R"(": "node)" + std::to_string(node) + R"(.e")";
  const std::string part = "\"1/" + std::to_string(n) + "\"";
  return R"({ "bgsim": 1, "name": "ladder", "parameters": { "R": )" + part + R"(, "C": )" + part +
         R"( }, "elements": { )" + elements + R"( }, "bonds": [ )" + bonds + R"( ], "outputs": { )" + outputs +
         R"( }, "scenes": { "run": { "stop": 0.5, "samples": 51 } } })";
}

std::string chain_json(std::size_t n, const std::vector<std::size_t>& masses) {
  std::string elements = R"-("wall": { "kind": "Sf", "flow": "0.5*sin(t)" })-", bonds, outputs;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string k = std::to_string(i), before = i == 0 ? "wall" : "at" + std::to_string(i - 1);
    elements += R"(, "link)" + k + R"(": { "kind": "0" }, "at)" + k + R"(": { "kind": "1" }, "spring)" + k +
                R"(": { "kind": "C", "law": "e = q + q^3" }, "m)" + k + R"(": { "kind": "I", "inertance": 1 }, "r)" +
                k + R"(": { "kind": "R", "resistance": 0.01 })";
    for (const auto& [from, to] :
         {std::pair{before, "link" + k}, std::pair{"link" + k, "spring" + k}, std::pair{"link" + k, "at" + k},
          std::pair{"at" + k, "m" + k}, std::pair{"at" + k, "r" + k}})
      bonds += (bonds.empty() ? R"({ "from": ")" : R"(, { "from": ")") + from + R"(", "to": ")" + to + "\" }";
  }
  for (const std::size_t mass : masses)
    outputs +=
        (outputs.empty() ? "\"v" : ", \"v") + std::to_string(mass) + R"(": "at)" + std::to_string(mass) + R"(.f")";
  return R"({ "bgsim": 1, "name": "chain", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { )" + outputs + R"( }, "scenes": { "run": { "stop": 60, "samples": 61 } } })";
}

std::string grid_json(std::size_t n, const std::vector<std::size_t>& nodes, const std::string& stop) {
  std::string elements =
      R"-("source": { "kind": "Se", "effort": "sin(t)" }, "inlet": { "kind": "1" }, "feed": { "kind": "R", "resistance": 1 })-";
  std::string bonds =
      R"({ "from": "source", "to": "inlet" }, { "from": "inlet", "to": "feed" }, { "from": "inlet", "to": "node0" })";
  std::string outputs;
  const auto tie = [&](const std::string& from, const std::string& to) {
    bonds += R"(, { "from": ")" + from + R"(", "to": ")" + to + "\" }";
  };
  for (std::size_t i = 0; i < n * n; ++i) {
    const std::string k = std::to_string(i);
    elements += R"(, "node)" + k + R"(": { "kind": "0" }, "C)" + k + R"(": { "kind": "C", "capacitance": 1 })";
    tie("node" + k, "C" + k);
    for (const std::size_t to : {i % n + 1 < n ? i + 1 : i, i + n < n * n ? i + n : i}) {
      if (to == i) continue;
      const std::string way = k + "_" + std::to_string(to);
      elements += R"(, "way)" + way + R"(": { "kind": "1" }, "R)" + way + R"(": { "kind": "R", "resistance": 1 })";
      tie("node" + k, "way" + way);
      tie("way" + way, "R" + way);
      tie("way" + way, "node" + std::to_string(to));
    }
  }
  for (const std::size_t node : nodes)
    outputs +=
        (outputs.empty() ? "\"e" : ", \"e") + std::to_string(node) + R"(": "node)" + std::to_string(node) + R"(.e")";
  return R"({ "bgsim": 1, "name": "grid", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { )" + outputs + R"( }, "scenes": { "run": { "stop": )" + stop + R"(, "samples": 61 } } })";
}

/// Processor time of whole processes, with everything that a run does by itself.
void time_process(const std::string& bgsim, const std::string& file, const std::string& scene, double must) {
  constexpr int kRounds = 15;
  std::vector<double> all;
  for (int round = 0; round < kRounds; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      if (freopen("/dev/null", "w", stderr) == nullptr) _exit(127);
      execl(bgsim.c_str(), "bgsim", file.c_str(), "--scene", scene.c_str(), "--quiet", "-o", "/dev/null", nullptr);
      _exit(127);
    }
    int status = 0;
    rusage used{};
    wait4(child, &status, 0, &used);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) std::exit(1);
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    all.push_back(seconds(used.ru_utime) + seconds(used.ru_stime));
  }
  const double time = 1e3 * median(all);
  std::printf("| `bgsim %s --scene %s` | %.1f | %.0f, %s |\n", file.c_str(), scene.c_str(), time, must,
              time <= must ? "yes" : "no");
  std::fflush(stdout);
}

std::string first_line(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(key)) return line;
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::string bgsim = argv[1], python = argv[2];
  const std::vector<std::string> chosen(argv + 3, argv + argc);
  const auto wanted = [&](const std::string& name) {
    return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
  };
  std::printf("%s; %ld processors; load at the start %s\n\n", first_line("/proc/cpuinfo", "model name").c_str(),
              sysconf(_SC_NPROCESSORS_ONLN), first_line("/proc/loadavg", "").c_str());
  if (wanted("process")) {
    std::printf("| whole process | ms | must be, is |\n|---|---|---|\n");
    time_process(bgsim, "models/bellow.json", "step", 10.0);
    time_process(bgsim, "models/bellow.json", "tracking", 40.0);
    std::printf("\n");
  }
  std::printf("| case | states | by | ms | steps | error | tolerance | method; bgsim / this | must be, is |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  const auto scipy = [&](Case& one, const char* method, double stop, std::size_t times, double must) {
    if (python == "-") return;
    one.contenders.push_back(
        {std::string("SciPy ") + method,
         [=, name = one.name](double relative) { return run_scipy(python, name, method, stop, times, relative); }, must,
         10.0});
  };
  constexpr double kTight = 1e-12, kTracks = 12.566370614359172;
  struct Small {
    const char* scene;
    double must;
  };
  for (const Small small :
       {Small{"tracking", 0.03}, Small{"step", 0.15}, Small{"literal", 0.15}, Small{"physical", 0.15}}) {
    const std::string name = std::string("bellow ") + small.scene;
    if (!wanted(name)) continue;
    Case one = case_of(name, Study("models/bellow.json"), small.scene, bench::bellow_by_hand(small.scene),
                       Method::dirk5, kTight);
    one.contenders[1].must = small.must;
    if (name == "bellow tracking") {
      scipy(one, "LSODA", kTracks, 81, 0.02);
      scipy(one, "Radau", kTracks, 81, 0.02);
    } else if (name == "bellow step") {
      for (const char* method : {"LSODA", "BDF", "Radau"}) scipy(one, method, 0.5, 501, 0.02);
    }
    compare(std::move(one));
  }
  for (const char* scene : {"bending", "extension"}) {
    const std::string name = std::string("actuator ") + scene;
    if (!wanted(name)) continue;
    Case one =
        case_of(name, Study("models/actuator.json"), scene, bench::actuator_by_hand(scene), Method::dirk5, kTight);
    one.contenders[1].must = 0.03;
    compare(std::move(one));
  }
  for (const std::size_t n : {100UL, 1000UL, 10000UL}) {
    const std::string name = "ladder " + std::to_string(n);
    if (!wanted(name)) continue;
    std::vector<std::size_t> nodes;
    for (std::size_t k = 1; k <= 10; ++k) nodes.push_back(k * n / 10 - 1);
    Case one =
        case_of(name, Study::from_text(ladder_json(n, nodes)), "", bench::ladder_by_hand(n, nodes), Method::bdf, 1e-10);
    one.contenders[1].must = 0.35;
    if (n == 1000)
      for (const char* method : {"LSODA", "BDF"}) scipy(one, method, 0.5, 51, 0.3);
    compare(std::move(one));
  }
  for (const std::size_t n : {100UL, 1000UL, 10000UL}) {
    const std::string name = "chain " + std::to_string(n);
    if (!wanted(name)) continue;
    const std::vector<std::size_t> masses{0, 1, 2, 5, 10, 20, 30, 40};
    Case one = case_of(name, Study::from_text(chain_json(n, masses)), "", bench::chain_by_hand(n, masses), Method::erk5,
                       1e-10);
    one.contenders[1].must = n == 10000 ? 0.08 : 0.35;
    compare(std::move(one));
  }
  struct Plane {
    const char* name;
    std::size_t n;
    const char* stop;  // the last one: until heat has crossed the plane
    double must;
  };
  for (const Plane plane : {Plane{"grid 100", 100, "60", 0.2}, Plane{"grid 300", 300, "20", 0.2},
                            Plane{"slow grid 100", 100, "1e4", 0.2}}) {
    if (!wanted(plane.name)) continue;
    const std::size_t n = plane.n;
    const std::vector<std::size_t> nodes{0, 1, n + 1, 3 * n + 2, 6 * n + 6};
    Case one = case_of(plane.name, Study::from_text(grid_json(n, nodes, plane.stop)), "", bench::grid_by_hand(n, nodes),
                       Method::bdf, 1e-9);
    one.contenders[1].must = plane.must;
    compare(std::move(one));
  }
  std::printf("\nload at the end %s\n", first_line("/proc/loadavg", "").c_str());
}
