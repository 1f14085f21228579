// Which modes of the switches a graph allows, and what each makes of the stores.
#include "bgsim/modes.hpp"

#include <optional>

#include "base/text_rows.hpp"
#include "bgsim/describe.hpp"
#include "bgsim/text.hpp"
#include "equations/idle_switches.hpp"
#include "equations/solvable_causality.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kMostSwitches = 12;
constexpr std::size_t kMostRows = 64;

/// "; "b", "c" idle": switches that set what others set already.
std::string idle_words(const Model& model) {
  std::string names;
  for (const Element& element : model.elements)
    if (element.idle) names += (names.empty() ? "; \"" : ", \"") + element.name + "\"";
  return names.empty() ? names : names + " idle";
}

/// What a mode makes of the model, in a line. @p allowed: whether the graph allows it.
std::string consequence(const Model& model, BondGraph graph, bool& allowed) {
  for (std::size_t i = 0; i < model.elements.size(); ++i) graph.kinds[i] = model.elements[i].kind;
  try {
    const CausalGraph causal = solvable_causality(model, graph);
    derive_equations(model, graph, causal);
    allowed = true;
    if (causal.dependent.empty()) return "all stores independent" + idle_words(model);
    std::string text = "dependent:";
    constexpr std::size_t kMost = 8;
    for (std::size_t i = 0; i < causal.dependent.size() && i < kMost; ++i) {
      const Element& store = model.elements[causal.dependent[i].element.index()];
      text += (i == 0 ? " " : ", ") + port_name(store, causal.dependent[i].port) +
              (stores_displacement(store, causal.dependent[i].port) ? ".q" : ".p");
    }
    if (causal.dependent.size() > kMost) text += " and " + std::to_string(causal.dependent.size() - kMost) + " more";
    return text + idle_words(model);
  } catch (const ModelError& error) {
    allowed = false;
    return "not allowed: " + error.diagnostics.front().situation + " (" + error.diagnostics.front().code + ")";
  }
}

}  // namespace

std::string describe_modes(const Model& model, const BondGraph& graph) {
  const std::size_t count = switches_of(model).size();
  if (count == 0) return {};
  if (count > kMostSwitches)
    return "modes of " + std::to_string(count) + " switches: too many to be listed; --mode looks at one\n\n";
  const std::size_t modes = std::size_t{1} << count;
  std::string rows;
  std::size_t refused = 0, listed = 0;
  for (std::size_t number = 0; number < modes; ++number) {
    Mode mode(count);
    for (std::size_t i = 0; i < count; ++i) mode[i] = (number >> (count - 1 - i) & 1U) != 0;
    const Model moded = in_mode(model, mode);
    bool allowed = false;
    std::string text = consequence(moded, graph, allowed);
    if (!allowed)
      if (const Model idle = with_idle_switches(moded); has_idle_switches(idle))
        text = consequence(idle, graph, allowed);
    refused += allowed ? 0U : 1U;
    if (++listed <= kMostRows) rows += "  " + mode_text(model, mode) + ": " + visible_line(text) + "\n";
  }
  if (modes > kMostRows) rows += "  and " + std::to_string(modes - kMostRows) + " more\n";
  return "modes of the switches: " + std::to_string(modes) + ", of which the graph allows " +
         std::to_string(modes - refused) + "\n" + rows + "\n";
}

}  // namespace bgsim
