/// On which sides switches, diodes and contacts are at a point of one mode.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/linear.hpp"

namespace bgsim {

/// Those that leave their sides at a point and beside it, and closed contacts that are not at their gaps.
/// @param errors  by state: what it may be off by; a billionth of it at least is taken
std::vector<ElementId> left_sides(Evaluator& evaluator, double t, const std::vector<double>& x,
                                  std::span<const double> errors);

/// What is to be known of a model's switches at a point where these leave their sides.
std::vector<std::string> side_notes(const Model& model, std::span<const ElementId> leaves);

/// The displacements of closed contacts, which stay at their gaps.
std::vector<std::string> held_by_contacts(const Model& model);

/// Without these. Of what poles() takes alone.
LinearSystem without_held_contacts(const Model& model, LinearSystem system);

}  // namespace bgsim
