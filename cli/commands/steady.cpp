// bgsim steady: states in which all stores rest.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"
#include "linear_options.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

std::string stability_text(const Equilibrium& found) {
  switch (found.stability) {
    case Equilibrium::Stability::stable:
      return "stable";
    case Equilibrium::Stability::unstable: {
      double fastest = 0.0;
      for (const Pole& pole : found.poles) fastest = std::max(fastest, pole.s.real());
      return "unstable, leaves by exp(t/" + number_text(1.0 / fastest, 4) + " s)";
    }
    case Equilibrium::Stability::marginal:
      return std::any_of(found.poles.begin(), found.poles.end(),
                         [](const Pole& p) { return p.pair && p.s.real() == 0.0; })
                 ? "neither damped nor unstable in some states (poles on the imaginary axis)"
             : found.drifts ? "unstable: what is free, once pushed, moves on without end"
                            : "stable but for what is free";
    case Equilibrium::Stability::unknown:
      break;
  }
  return "of unknown stability: " + visible_line(found.not_linear);
}

/// How many modes were looked at; nothing without switches.
std::string modes_text(const SteadyStates& states) {
  if (states.switches == 0) return "";
  std::string text = " in " + std::to_string(states.looked_at);
  if (states.switches < 20) text += " of " + std::to_string(std::size_t{1} << states.switches);
  return text + (states.looked_at == 1 && states.switches >= 20 ? " mode" : " modes");
}

}  // namespace

Exit steady_command(const Arguments& arguments) {
  LinearArguments options;
  std::optional<double> time;
  bool one = false;
  CLI::App app("Steady states of a model: all stores and integrals rest, sources are held.", "bgsim steady");
  app.footer("Example: bgsim steady models/bellow.json --scene step");
  add_linear_options(app, options, "");
  app.remove_option(app.get_option("--at"));
  app.add_option("--time", time, "sources are held at their values just after this time (default: the scene's start)")
      ->type_name("T");
  app.add_flag("--first", one, "the one nearest to the scene's start alone; others are not looked for");
  parse_arguments(app, arguments);
  Study study = linear_study(options);
  RunInputs scene = scene_begun(study, options);
  print_warnings(scene.warnings, study.model());
  if (time) scene.start = *time;
  const SteadyStates states = options.mode.empty()
                                  ? steady_states(study, scene, {!one})
                                  : SteadyStates{equilibria(study.shared_model(), scene, {!one}), 1, 0};
  const std::vector<Equilibrium>& found = states.found;
  std::cout << visible_line(study.model().name) << ", scene " << short_name(scene.scene)
            << ", sources as at t = " << number_text(scene.start) << ": " << found.size()
            << (found.size() == 1 ? " steady state" : " steady states") << " found" << modes_text(states) << '\n';
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Equilibrium& each = found[i];
    std::cout << '\n' << i + 1 << ". " << stability_text(each);
    if (!each.mode.empty()) std::cout << "; " << visible_line(mode_text(study.model(), each.mode));
    std::cout << "\n   by " << visible_line(each.found) << "; residual " << number_text(each.residual, 2)
              << " of the rates' terms\n";
    TextTable table({"state", "value", "unit", ""});
    for (const LinearVariable& state : each.states)
      table.add({state.name, number_text(state.value, 9), state.unit,
                 state.value != 0.0 && state.error > 1e-8 * std::abs(state.value)
                     ? "known to " + number_text(state.error, 2)
                     : ""});
    std::cout << table.text();
    if (!each.free.empty()) {
      std::cout << "free: others of the same kind follow by moving";
      for (std::size_t k = 0; k < each.free.size() && k < 12; ++k)
        std::cout << (k > 0 ? ", " : " ") << short_name(each.free[k]);
      std::cout << (each.free.size() > 12 ? ", ..." : "") << '\n';
    }
  }
  return Exit::done;
}

}  // namespace bgsim::cli
