#include "run/integrate/separability.hpp"

#include <algorithm>

#include "base/codes.hpp"
#include "base/text.hpp"

namespace bgsim {

namespace {

/// Which states each rate depends on, loops included.
std::vector<std::vector<std::size_t>> dependences(const Program& program) {
  std::vector<std::vector<std::size_t>> depends(program.state_names.size());
  for (const JacobianPlan::Entry& entry : program.plan.rates_by_states) depends[entry.row].push_back(entry.column);
  for (const JacobianPlan::Entry& entry : program.plan.rates_by_tears) {
    const auto& columns = program.plan.blocks[program.plan.block_of_tear[entry.column]].columns;
    depends[entry.row].insert(depends[entry.row].end(), columns.begin(), columns.end());
  }
  return depends;
}

bool is_momentum(const std::string& state) { return state.ends_with(".p"); }

}  // namespace

std::optional<Halves> separate(const Program& program, NotSeparable& obstacle) {
  for (std::size_t part = 0; part < program.energy_names.size(); ++part)
    if (program.energy_roles[part] == EnergyPart::Role::dissipator)
      obstacle.losses.push_back(program.energy_names[part]);

  const std::size_t states = program.state_names.size();
  const auto depends = dependences(program);
  std::vector<std::vector<std::size_t>> linked(states);
  for (std::size_t row = 0; row < states; ++row)
    for (const std::size_t column : depends[row]) {
      linked[row].push_back(column);
      linked[column].push_back(row);
    }

  enum class Colour : std::uint8_t { none, kicked, drifting };
  std::vector<Colour> colour(states, Colour::none);
  std::vector<std::size_t> waiting;
  for (std::size_t first = 0; first < states; ++first) {
    if (colour[first] != Colour::none) continue;
    colour[first] = is_momentum(program.state_names[first]) ? Colour::kicked : Colour::drifting;
    waiting.assign(1, first);
    while (!waiting.empty()) {
      const std::size_t state = waiting.back();
      waiting.pop_back();
      for (const std::size_t other : linked[state]) {
        if (colour[other] == colour[state]) {
          const bool forward = std::find(depends[state].begin(), depends[state].end(), other) != depends[state].end();
          obstacle.state = forward ? state : other;
          obstacle.other = forward ? other : state;
          return std::nullopt;
        }
        if (colour[other] != Colour::none) continue;
        colour[other] = colour[state] == Colour::kicked ? Colour::drifting : Colour::kicked;
        waiting.push_back(other);
      }
    }
  }
  Halves halves(states);
  for (std::size_t i = 0; i < states; ++i) halves[i] = colour[i] == Colour::kicked;
  return halves;
}

Diagnostic not_separable_failure(const Program& program, const NotSeparable& obstacle) {
  const std::string state = in_quotes(program.state_names[obstacle.state]);
  Diagnostic diagnostic = diagnostic_of("BG610");
  diagnostic.situation = "the method \"verlet\" cannot be used: the rate of " + state + " depends on " +
                         (obstacle.state == obstacle.other ? state + " itself"
                                                           : in_quotes(program.state_names[obstacle.other]) +
                                                                 ", and the states do not fall into two halves");
  diagnostic.place = program.states[obstacle.state].place;
  if (!obstacle.losses.empty()) {
    constexpr std::size_t kMost = 5;
    std::string names;
    for (std::size_t i = 0; i < std::min(kMost, obstacle.losses.size()); ++i)
      names += (i == 0 ? "" : ", ") + in_quotes(obstacle.losses[i]);
    if (obstacle.losses.size() > kMost) names += " and " + std::to_string(obstacle.losses.size() - kMost) + " more";
    diagnostic.notes.push_back({std::nullopt, "the graph is not lossless: it has " + names});
  }
  diagnostic.rule =
      "Störmer-Verlet needs two groups of states, each driven by the other only, as in separable, lossless graphs";
  diagnostic.help = "use another method: auto, or rk4 for fixed steps";
  return diagnostic;
}

}  // namespace bgsim
