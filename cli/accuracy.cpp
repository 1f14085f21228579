#include <array>
#include <cstdio>
#include <iostream>

#include "bgsim/study.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trade.hpp"
#include "progress.hpp"
#include "run_search.hpp"

namespace bgsim::cli {

namespace {

std::optional<RunInputs> with_accuracy(const Simulation& scene, double accuracy, const RunLimits& limits, bool quiet) {
  if (scene.program().state_names.empty()) {
    if (!quiet)
      std::cerr << "accuracy " << number_text(accuracy)
                << ": there are no states to integrate; what the laws give is exact\n";
    return scene.inputs();
  }
  TradePick pick;
  {
    SettingWatch watch(quiet);
    TradeOptions how;
    how.tell = [&](const std::string& what) { watch.show(what); };
    how.goes_on = [] { return !was_interrupted(); };
    how.max_steps = limits.max_steps;
    how.time_limit = limits.seconds;
    try {
      pick = find_setting(scene, accuracy, how);
    } catch (const TradeFailure& failure) {
      if (!was_interrupted()) {
        watch.clear();
        std::cerr << render(failure.diagnostic, *scene.model().sources);
        return std::nullopt;
      }
    }
    if (was_interrupted()) {
      watch.clear();
      throw Interrupted("the search for --accuracy was interrupted; no setting is known, and no trace is written");
    }
  }
  if (!quiet) {
    std::array<char, 600> text{};
    std::snprintf(
        text.data(), text.size(),
        "accuracy %.3g: %s\n  error %.2g, between the output times %.2g, by %s; a second method, %s, comes to "
        "the same within %.2g%s\n  %.3g s a run; found in %zu runs and %.3g s\n",
        accuracy, setting_flags(pick.setting).c_str(), pick.error, pick.check_error,
        setting_flags(pick.reference.setting).c_str(), setting_flags(pick.reference.second).c_str(),
        pick.reference.error,
        pick.reference.error > accuracy ? ", and nearer with its tolerance, which is as far as it was followed" : "",
        pick.cpu_seconds, pick.runs, pick.search_seconds);
    std::cerr << text.data();
  }
  return with_setting(scene.inputs(), pick.setting);
}

}  // namespace

AccuracySearch accuracy_search(const Arguments& /*arguments*/) { return with_accuracy; }

}  // namespace bgsim::cli
