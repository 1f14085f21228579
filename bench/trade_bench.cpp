// How well an accuracy is picked, and how well the energy residual tells the error, over scenes of all kinds.
//   trade_bench [--seconds S] [FILE:SCENE]...     default: the list below, from the project's folder
//
// For each scene and accuracy find_setting picks a setting; then measure_trade measures it beside the whole table,
// against a reference of its own at 1e-11 or 1e-13. The best in hindsight is the cheapest row of that table that has
// the accuracy.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace {

using namespace bgsim;

constexpr std::array<double, 2> kAccuracies{1e-3, 1e-5};
double budget = 25.0;  // seconds for a search, and for a table

/// Seed models, gallery, stiff ones, oscillators, events.
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
    "models/amplifier.json:",
    "models/coupled_coils.json:",
    "models/dc_motor.json:",
    "models/euler_top.json:",
    "models/gas_cylinder.json:",
    "models/lever.json:",
    "models/pendulum.json:",
    "models/quarter_car.json:",
    "models/rlc.json:",
    "models/robertson.json:",
    "models/skater.json:",
    "models/tanks.json:",
    "models/thermal_chain.json:",
    "models/van_der_pol.json:",
    "models/varying_capacitor.json:",
    "tests/data/models/bump_car.json:",
    "tests/data/models/cylinder.json:",
    "tests/data/models/drive_train.json:",
    "tests/data/models/driven_filter.json:",
    "tests/data/models/duffing.json:",
    "tests/data/models/geared_motor.json:",
    "tests/data/models/gas_spring.json:",
    "tests/data/models/pi_filter.json:",
    "tests/data/models/rc_ladder_100.json:",
    "tests/data/models/reaction.json:",
    "tests/data/models/resonance.json:",
    "tests/data/models/ring_modulator.json:",
    "tests/data/models/two_time_scales.json:",
};

struct Pick {
  double accuracy = 0.0;
  std::optional<TradeSetting> setting;
  std::string why_not;
  std::string verdict;              ///< of the table: whether the accuracy was achieved
  double error = 0.0, ratio = 0.0;  ///< against the table's reference, and of the costs
  std::string best;
  double search_over_run = 0.0;
};

struct Result {
  std::string name;
  std::vector<Pick> picks;
  std::vector<double> log_ratios;  ///< log10(energy residual / error) of the stable rows
  std::string why_not;
};

double part(std::vector<double> values, double quantile) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size() - 1) + 0.5)];
}

void judge_picks(const Trade& trade, Result& result) {
  for (Pick& pick : result.picks) {
    if (!pick.setting) continue;
    const TradeRow& own = *std::find_if(trade.rows.begin(), trade.rows.end(), [&](const TradeRow& candidate) {
      return setting_flags(candidate.setting) == setting_flags(*pick.setting);
    });
    pick.error = std::max(own.max_error, own.check_error);
    if (setting_flags(own.setting) == setting_flags(trade.reference.setting))
      pick.verdict = "is the reference";
    else if (!trade.reference.tells(pick.accuracy, 1.0))
      pick.verdict = "not judged";
    else
      pick.verdict = own.verdict == TradeVerdict::stable && pick.error <= pick.accuracy ? "yes" : "NO";
    double least = own.cpu_seconds;
    pick.best = setting_flags(own.setting);
    for (const TradeRow& other : trade.rows)
      if (other.verdict == TradeVerdict::stable && std::max(other.max_error, other.check_error) <= pick.accuracy &&
          other.cpu_seconds < least) {
        least = other.cpu_seconds;
        pick.best = setting_flags(other.setting);
      }
    pick.ratio = own.cpu_seconds / least;
  }
}

Result measure(const std::string& file, const std::string& scene) {
  const Simulation compiled = Study(file).scene(scene, {}, {.keep_all = true});
  const RunInputs& inputs = compiled.inputs();
  const Program& program = compiled.program();
  Result result;
  result.name = compiled.model().name + " " + inputs.scene;
  TradeOptions options;
  options.budget = budget;
  for (const double accuracy : kAccuracies) {
    Pick pick;
    pick.accuracy = accuracy;
    try {
      const TradePick found = find_setting(program, inputs, accuracy, options);
      pick.setting = found.setting;
      pick.search_over_run = found.search_seconds / found.cpu_seconds;
      options.also.push_back(found.setting);
    } catch (const TradeFailure& failure) {
      pick.why_not = failure.diagnostic.code + " " + failure.diagnostic.situation;
    }
    result.picks.push_back(std::move(pick));
  }
  try {
    const Trade trade = measure_trade(program, inputs, options);
    judge_picks(trade, result);
    for (const TradeRow& row : trade.rows)
      if (row.verdict == TradeVerdict::stable && row.energy_residual && *row.energy_residual > 0.0 &&
          row.max_error > 3.0 * trade.reference.error && row.max_error < 0.1)
        result.log_ratios.push_back(std::log10(*row.energy_residual / row.max_error));
  } catch (const TradeFailure& failure) {
    result.why_not = failure.diagnostic.code + " " + failure.diagnostic.situation;
    result.picks.clear();
  }
  return result;
}

void print(const Result& result) {
  if (!result.why_not.empty()) std::printf("| %s | not measured: %s |\n", result.name.c_str(), result.why_not.c_str());
  for (const Pick& pick : result.picks) {
    if (!pick.setting) {
      std::printf("| %s | %.0e | refused: %s | | | | |\n", result.name.c_str(), pick.accuracy, pick.why_not.c_str());
      continue;
    }
    std::printf("| %s | %.0e | `%s` | %.1e | %s | %.2f | `%s` | %.0f |\n", result.name.c_str(), pick.accuracy,
                setting_flags(*pick.setting).c_str(), pick.error, pick.verdict.c_str(), pick.ratio, pick.best.c_str(),
                pick.search_over_run);
  }
  std::fflush(stdout);
}

void print_residuals(const std::vector<Result>& results) {
  std::printf("\n| scene | rows | residual/error: 5 %% | median | 95 %% |\n|---|---|---|---|---|\n");
  std::vector<double> all;
  for (const Result& result : results) {
    if (result.log_ratios.empty()) continue;
    all.insert(all.end(), result.log_ratios.begin(), result.log_ratios.end());
    const auto at = [&](double quantile) { return std::pow(10.0, part(result.log_ratios, quantile)); };
    std::printf("| %s | %zu | %.1e | %.1e | %.1e |\n", result.name.c_str(), result.log_ratios.size(), at(0.05), at(0.5),
                at(0.95));
  }
  const auto within = [&](double decades) {
    const auto count = std::count_if(all.begin(), all.end(), [&](double r) { return std::abs(r) <= decades; });
    return 100.0 * static_cast<double>(count) / static_cast<double>(all.size());
  };
  const auto below = std::count_if(all.begin(), all.end(), [](double r) { return r < -1.0; });
  std::printf(
      "\n%zu rows: residual within a factor 10 of the error in %.0f %%, within 100 in %.0f %%; "
      "more than ten times too small in %.0f %%\n",
      all.size(), within(1.0), within(2.0), 100.0 * static_cast<double>(below) / static_cast<double>(all.size()));
}

void print_summary(const std::vector<Result>& results) {
  std::size_t picked = 0, achieved = 0, missed = 0, refused = 0;
  std::vector<double> ratios;
  for (const Result& result : results)
    for (const Pick& pick : result.picks) {
      if (!pick.setting) {
        ++refused;
        continue;
      }
      ++picked;
      if (pick.verdict == "yes") ++achieved;
      if (pick.verdict == "NO") ++missed;
      ratios.push_back(pick.ratio);
    }
  std::printf(
      "\n%zu requests: %zu refused, %zu picks, of which %zu achieved the accuracy, %zu did not, and %zu were not "
      "judged; "
      "cost over the best in hindsight: median %.2f, 90 %% below %.2f, largest %.2f\n",
      picked + refused, refused, picked, achieved, missed, picked - achieved - missed, part(ratios, 0.5),
      part(ratios, 0.9), part(ratios, 1.0));
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes(argv + 1, argv + argc);
  if (scenes.size() >= 2 && scenes[0] == "--seconds") {
    budget = std::stod(scenes[1]);
    scenes.erase(scenes.begin(), scenes.begin() + 2);
  }
  if (scenes.empty()) scenes = kScenes;
  std::printf(
      "| scene | accuracy | pick | its error | achieved | cost / best | best in hindsight | search / run |\n"
      "|---|---|---|---|---|---|---|---|\n");
  std::vector<Result> results;
  for (const std::string& item : scenes) {
    const std::size_t colon = item.rfind(':');
    try {
      results.push_back(measure(item.substr(0, colon), colon == std::string::npos ? "" : item.substr(colon + 1)));
      print(results.back());
    } catch (const ModelError& error) {
      std::fprintf(stderr, "%s: %s\n", item.c_str(), render(error).c_str());
      return 1;
    }
  }
  print_summary(results);
  print_residuals(results);
}
