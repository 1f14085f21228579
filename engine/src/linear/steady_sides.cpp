#include "linear/steady_sides.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

constexpr double kLeastOff = 1e-9;

/// By Program::switch_elements.
std::vector<bool> leaving(Evaluator& evaluator, double t, const std::vector<double>& x) {
  const Program& program = evaluator.program();
  std::vector<double> leaves(program.switch_elements.size(), 0.0);
  Branch branch = first_branch(program);
  if (!leaves.empty() &&
      (!evaluator.initialize_modes(t, x.data(), branch) || !evaluator.switches(t, x.data(), branch, leaves.data())))
    std::fill(leaves.begin(), leaves.end(), 0.0);
  std::vector<bool> result;
  for (const double leaves_side : leaves) result.push_back(leaves_side != 0.0);
  return result;
}

}  // namespace

std::vector<ElementId> left_sides(Evaluator& evaluator, double t, const std::vector<double>& x,
                                  std::span<const double> errors) {
  const Program& program = evaluator.program();
  std::vector<double> off;
  for (std::size_t i = 0; i < x.size(); ++i) off.push_back(std::max(errors[i], kLeastOff * std::abs(x[i])));
  std::vector<ElementId> result;
  std::vector<bool> left = leaving(evaluator, t, x);
  std::mt19937_64 random(20261127);
  constexpr int kTries = 16;
  // A flow that is 0 but for rounding, or a condition at its border, is on either side.
  for (int k = 0; k < kTries && std::find(left.begin(), left.end(), true) != left.end(); ++k) {
    std::vector<double> beside = x;
    for (std::size_t i = 0; i < x.size(); ++i) beside[i] += (random() >> 63U) == 0 ? off[i] : -off[i];
    const std::vector<bool> there = leaving(evaluator, t, beside);
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = left[i] && there[i];
  }
  for (std::size_t i = 0; i < left.size(); ++i)
    if (left[i]) result.push_back(program.switch_elements[i]);

  // What diodes() has as the flow of a contact is the room that it has left.
  std::vector<double> values(4 * program.diode_elements.size());
  Branch branch = first_branch(program);
  if (values.empty() || !evaluator.initialize_modes(t, x.data(), branch) ||
      !evaluator.diodes(t, x.data(), branch, values.data()))
    return result;
  for (std::size_t i = 0; i < program.diode_elements.size(); ++i) {
    const ElementId id = program.diode_elements[i];
    const Element& element = program.model->elements[id.index()];
    if (!element.contact || is_closed(element)) continue;
    double near = 0.0;
    for (std::size_t k = 0; k < x.size(); ++k)
      if (program.states[k].signal == element.contact->displacement) near = off[k];
    if (std::abs(values[4 * i + 1]) > near && std::find(result.begin(), result.end(), id) == result.end())
      result.push_back(id);
  }
  return result;
}

std::vector<std::string> side_notes(const Model& model, std::span<const ElementId> leaves) {
  std::vector<std::string> notes;
  for (const ElementId id : leaves) {
    const Element& element = model.elements[id.index()];
    notes.push_back(short_name(element.name) + (element.diode ? " " : " is ") + side_text(element, is_closed(element)) +
                    " in this mode, and its condition says otherwise at this point");
  }
  for (const Element& element : model.elements)
    if (element.idle)
      notes.push_back(short_name(element.name) + (element.diode ? " " : " is ") +
                      side_text(element, is_closed(element)) + (element.diode ? " and is idle" : " and idle") +
                      ": what depends on its " + (is_closed(element) ? "flow" : "effort") +
                      " is indefinite, and taken as if that were 0");
  return notes;
}

std::vector<std::string> held_by_contacts(const Model& model) {
  std::vector<std::string> names;
  for (const Element& element : model.elements)
    if (element.contact && !is_closed(element))
      names.push_back(model.signals[element.contact->displacement.index()].name);
  return names;
}

LinearSystem without_held_contacts(const Model& model, LinearSystem system) {
  const std::vector<std::string> names = held_by_contacts(model);
  if (names.empty()) return system;
  std::vector<bool> held;
  for (const LinearVariable& state : system.states)
    held.push_back(std::find(names.begin(), names.end(), state.name) != names.end());
  std::vector<std::uint32_t> position(held.size(), 0);
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < held.size(); ++i) position[i] = held[i] ? next : next++;
  const auto keep = [&](auto& values) {
    std::size_t at = 0;
    std::erase_if(values, [&](const auto&) { return held[at++]; });
  };
  keep(system.states);
  std::erase_if(system.a.entries, [&](const LinearMatrix::Entry& e) { return held[e.row] || held[e.column]; });
  for (LinearMatrix::Entry& e : system.a.entries) {
    e.row = position[e.row];
    e.column = position[e.column];
  }
  system.a.rows = system.a.columns = next;
  for (StoreRows& store : system.stores) {
    for (std::vector<double>& row : store.held) keep(row);
    for (std::vector<double>& row : store.conjugate) keep(row);
  }
  return system;
}

}  // namespace bgsim
