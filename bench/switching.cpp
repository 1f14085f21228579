// A buck converter over ten thousand periods: bgsim, event-driven integration written by hand, and ngspice, with their
// errors against matrix exponentials; and what a change of the mode costs in ordinary steps. Tables of
// docs/performance.md, as Markdown.
//   bench_switching MODELS [NGSPICE|-] [PERIODS]
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace {

using namespace bgsim;

constexpr double kV = 24.0, kT = 2e-5, kL = 1e-4, kC = 1e-4, kR = 5.0;  // of models/buck.json; duty 0.5
constexpr int kEvery = 5;                                               // periods from record to record

template <class Real>
struct State {
  Real i = 0, u = 0;
};
using Records = std::vector<State<double>>;

double processor_time(int who) {
  rusage used{};
  getrusage(who, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

/// Largest difference of current and voltage from the exact ones, in parts of their ranges.
double error_of(const Records& records, const Records& exact) {
  State<double> off, low = exact.front(), high = low;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    if (k >= records.size()) return std::numeric_limits<double>::infinity();
    off.i = std::max(off.i, std::abs(records[k].i - exact[k].i));
    off.u = std::max(off.u, std::abs(records[k].u - exact[k].u));
    low = {std::min(low.i, exact[k].i), std::min(low.u, exact[k].u)};
    high = {std::max(high.i, exact[k].i), std::max(high.u, exact[k].u)};
  }
  return std::max(off.i / (high.i - low.i), off.u / (high.u - low.u));
}

// --- exact: exponentials between the changes of sides, the end of the coil's current by bisection ---

using Long = long double;

/// With the coil in a loop with @p source: i' = (source - u)/L, u' = (i - u/R)/C.
State<Long> coil_on(State<Long> from, Long source, Long time) {
  // About the rest point (source/R, source): exp(A t) = e^(a t) (cos(w t) + (A - a) sin(w t)/w).
  const Long resting_i = source / Long(kR), a = -1 / (2 * Long(kR) * Long(kC)),
             w = std::sqrt(1 / (Long(kL) * Long(kC)) - a * a);
  const Long x = from.i - resting_i, y = from.u - source, e = std::exp(a * time), c = std::cos(w * time),
             s = std::sin(w * time) / w;
  return {resting_i + e * (c * x + s * (-a * x - y / Long(kL))),
          source + e * (c * y + s * (x / Long(kC) - y / (Long(kR) * Long(kC)) - a * y))};
}

State<Long> freewheel(State<Long> from, Long time) {
  const State<Long> after = coil_on(from, 0, time);
  if (after.i >= 0) return after;
  Long low = 0, high = time;
  for (int k = 0; k < 100; ++k) {
    const Long middle = (low + high) / 2;
    (coil_on(from, 0, middle).i < 0 ? high : low) = middle;
  }
  return {0, coil_on(from, 0, high).u * std::exp(-(time - high) / (Long(kR) * Long(kC)))};
}

Records exact_records(int periods) {
  Records records;
  State<Long> now;
  for (int k = 0; k <= periods; ++k) {
    if (k % kEvery == 0) records.push_back({static_cast<double>(now.i), static_cast<double>(now.u)});
    now = coil_on(now, Long(kV), Long(kT) / 2);
    now = freewheel(now, Long(kT) / 2);
  }
  return records;
}

// --- by hand: Dormand and Prince 5(4) from event to event ---

enum class Side { closed, free, empty };

State<double> rate(Side side, const State<double>& x) {
  const double u = x.u;
  switch (side) {
    case Side::closed:
      return {(kV - u) / kL, (x.i - u / kR) / kC};
    case Side::free:
      return {-u / kL, (x.i - u / kR) / kC};
    case Side::empty:
      break;
  }
  return {0.0, -u / kR / kC};
}

struct ByHand {
  double tolerance;
  double h = 1e-6;
  long steps = 0;

  /// One step of length @p step (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, table II.5.2);
  /// the estimated error in parts of the tolerance.
  double try_step(Side side, const State<double>& x, double step, State<double>& result) const {
    static constexpr double kA[6][6] = {{1.0 / 5},
                                        {3.0 / 40, 9.0 / 40},
                                        {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static constexpr double kE[7] = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                                     -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
    std::array<State<double>, 7> k{rate(side, x)};
    for (std::size_t s = 0; s < 6; ++s) {
      result = x;
      for (std::size_t j = 0; j <= s; ++j) {
        result.i += step * kA[s][j] * k[j].i;
        result.u += step * kA[s][j] * k[j].u;
      }
      k[s + 1] = rate(side, result);
    }
    State<double> off;
    for (std::size_t s = 0; s < 7; ++s) {
      off.i += step * kE[s] * k[s].i;
      off.u += step * kE[s] * k[s].u;
    }
    return std::max(std::abs(off.i) / (tolerance * 13.0), std::abs(off.u) / (tolerance * 21.0));
  }

  /// Over a half period, to where the current ends at the latest; the time that is left.
  double go(Side side, State<double>& x, double time) {
    while (time > 0.0) {
      const double step = std::min(h, time);
      State<double> next;
      const double error = try_step(side, x, step, next);
      const double factor = std::clamp(0.9 * std::pow(std::max(error, 1e-10), -0.2), 0.2, 5.0);
      if (error > 1.0) {
        h = step * factor;
        continue;
      }
      ++steps;
      if (step == h || factor < 1.0) h = step * factor;
      if (side == Side::free && next.i < 0.0) {
        double low = 0.0, high = step;
        for (int b = 0; b < 60 && high - low > 1e-17; ++b) {
          const double middle = 0.5 * (low + high);
          try_step(side, x, middle, next);
          (next.i < 0.0 ? high : low) = middle;
        }
        State<double> ended;
        try_step(side, x, high, ended);
        x = {0.0, ended.u};
        return time - high;
      }
      x = next;
      time -= step;
      if (time < 1e-12 * kT) time = 0.0;
    }
    return 0.0;
  }

  Records run(int periods) {
    Records records;
    State<double> x;
    for (int k = 0; k <= periods; ++k) {
      if (k % kEvery == 0) records.push_back(x);
      go(Side::closed, x, kT / 2);
      const double left = go(Side::free, x, kT / 2);
      if (left > 0.0) go(Side::empty, x, left);
    }
    return records;
  }
};

// --- bgsim ---

struct BgsimRun {
  Records records;
  double seconds = 0.0;
  RunReport report;
};

BgsimRun run_bgsim(const Simulation& compiled, int periods, double relative, Method method = Method::automatic) {
  RunInputs inputs = compiled.inputs();
  inputs.start = 0.0;
  inputs.stop = kT * periods;
  inputs.relative = relative;
  inputs.method = method;
  std::vector<double> times;
  for (int k = 0; k <= periods; k += kEvery) times.push_back(k == periods ? inputs.stop : k * kT);
  inputs.output_times = times;
  SimulateOptions how;
  how.energy_audit = how.error_estimate = how.second_run = false;
  BgsimRun run;
  how.rows = [&run](double, std::span<const double> row) { run.records.push_back({row[0], row[1]}); };
  const double begin = processor_time(RUSAGE_SELF);
  run.report = compiled.simulate(inputs, how).report;
  run.seconds = processor_time(RUSAGE_SELF) - begin;
  return run;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// --- ngspice: voltage-controlled switches, the diode as one that its own voltage closes ---

struct NgspiceRun {
  Records records;
  double seconds = 0.0;
};

NgspiceRun run_ngspice(const std::string& program, int periods, double relative, double steps_a_period) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "bgsim_bench_switching";
  std::filesystem::create_directories(folder);
  const std::string netlist = (folder / "buck.cir").string(), data = (folder / "buck.txt").string();
  std::ofstream(netlist) << "buck\nv1 in 0 24\nvg g 0 pulse(1 0 1e-5 1e-11 1e-11 1e-5 2e-5)\n"
                         << "s1 in sw g 0 chop\n.model chop sw vt=0.5 vh=0 ron=1e-4 roff=1e7\n"
                         << "s2 0 sw 0 sw free\n.model free sw vt=0 vh=0 ron=1e-4 roff=1e7\n"
                         << "l1 sw out 1e-4 ic=0\nc1 out 0 1e-4 ic=0\nr1 out 0 5\n"
                         << ".options reltol=" << relative << " abstol=1e-9 vntol=1e-9 method=trap\n"
                         << ".save i(l1) v(out)\n.control\nset numdgt=12\ntran " << kT * kEvery << " "
                         << kT * periods * (1.0 + 1e-12) << " 0 " << kT / steps_a_period << " uic\nlinearize\nwrdata "
                         << data << " i(l1) v(out)\nquit\n.endc\n.end\n";
  const double begin = processor_time(RUSAGE_CHILDREN);
  const int status = std::system((program + " -b " + netlist + " > " + (folder / "log").string() + " 2>&1").c_str());
  NgspiceRun run;
  run.seconds = processor_time(RUSAGE_CHILDREN) - begin;
  if (status != 0) std::fprintf(stderr, "ngspice ended with %d: see %s\n", status, (folder / "log").c_str());
  std::ifstream file(data);
  for (double t = 0, i = 0, again = 0, u = 0; file >> t >> i >> again >> u;) run.records.push_back({i, u});
  std::filesystem::remove(data);
  return run;
}

void print_row(const std::string& what, const std::string& setting, double error, double seconds, double best) {
  std::printf("| %s | %s | %.1e | %.3g | %.3g |\n", what.c_str(), setting.c_str(), error, seconds, seconds / best);
  std::fflush(stdout);
}

std::string power_of_ten(double value) {
  char text[20];
  std::snprintf(text, sizeof text, "%.0e", value);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string models = argc > 1 ? argv[1] : "models", ngspice = argc > 2 ? argv[2] : "-";
  const int periods = argc > 3 ? std::atoi(argv[3]) : 10000;
  if (periods < kEvery || periods % kEvery != 0) {
    std::fprintf(stderr, "usage: bench_switching MODELS [NGSPICE|-] [PERIODS, a multiple of %d]\n", kEvery);
    return 2;
  }
  const std::string text = text_of(models + "/buck.json");
  const std::string condition = "phase < duty";
  if (text.find(condition) == std::string::npos) {
    std::fprintf(stderr, "%s/buck.json has another condition than this bench knows\n", models.c_str());
    return 2;
  }
  const Records exact = exact_records(periods);
  const Simulation compiled = Study::from_text(text).scene();

  std::printf("%d periods, %d changes of the switch\n\n", periods, 2 * periods);
  std::printf("| program | setting | largest error | processor time, s | of bgsim at 1e-6 |\n|---|---|---|---|---|\n");
  run_bgsim(compiled, kEvery, 1e-6);  // modes are derived once
  const double best = run_bgsim(compiled, periods, 1e-6).seconds;
  for (const double relative : {1e-3, 1e-6, 1e-9}) {
    const BgsimRun run = run_bgsim(compiled, periods, relative);
    print_row("bgsim", power_of_ten(relative), error_of(run.records, exact), run.seconds, best);
  }
  for (const double relative : {1e-4, 1e-6, 1e-9}) {
    ByHand by_hand{relative};
    const double begin = processor_time(RUSAGE_SELF);
    const Records records = by_hand.run(periods);
    print_row("by hand, Dormand-Prince 5(4)", power_of_ten(relative), error_of(records, exact),
              processor_time(RUSAGE_SELF) - begin, best);
  }
  if (ngspice != "-")
    for (const auto& [relative, steps] : std::vector<std::pair<double, double>>{{1e-3, 20}, {1e-4, 100}, {1e-6, 500}}) {
      const NgspiceRun run = run_ngspice(ngspice, periods, relative, steps);
      print_row("ngspice",
                power_of_ten(relative) + ", " + std::to_string(static_cast<int>(steps)) + " steps a period at least",
                error_of(run.records, exact), run.seconds, best);
    }

  // The same circuit with the switch closed for good, for what a step costs.
  std::string still = text;
  still.replace(still.find(condition), condition.size(), "t > -1");
  const Simulation plain = Study::from_text(still).scene();
  std::printf(
      "\n| tolerance | microseconds a step | changes of the mode | steps | microseconds a change | steps a change "
      "costs |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const double relative : {1e-6, 1e-9}) {
    const int more = relative < 1e-7 ? 20 : 200;  // long enough to be measured
    double step_seconds = 0.0;
    long plain_steps = 0;
    for (int k = 0; k < more; ++k) {
      const BgsimRun run = run_bgsim(plain, 200, relative, Method::radau);
      const BgsimRun none = run_bgsim(plain, kEvery, relative, Method::radau);
      step_seconds += run.seconds - none.seconds;
      plain_steps += static_cast<long>(run.report.steps) - static_cast<long>(none.report.steps);
    }
    const double step = step_seconds / static_cast<double>(plain_steps);
    const BgsimRun run = run_bgsim(compiled, periods, relative, Method::radau);
    const auto changes = static_cast<double>(run.report.mode_changes), steps = static_cast<double>(run.report.steps);
    const double change = (run.seconds - steps * step) / changes;
    std::printf("| %s | %.2f | %.0f | %.0f | %.2f | %.1f |\n", power_of_ten(relative).c_str(), 1e6 * step, changes,
                steps, 1e6 * change, change / step);
  }
  return 0;
}
