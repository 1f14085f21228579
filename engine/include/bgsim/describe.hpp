/// What the stages found, in words: the texts of `bgsim check`, `equations` and `show`.
#pragma once

#include <string>

#include "bgsim/infer_units.hpp"
#include "bgsim/ordering.hpp"
#include "bgsim/program.hpp"

namespace bgsim {

/// `bgsim check`: strokes and their reasons, states, dependent stores and why, loops and through which elements,
/// fields' reciprocity, unconnected parts.
std::string describe_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal);
std::string describe_loops(const Model& model, const EquationSystem& system, const BlockOrder& order);
/// Which units are given, which follow from them, which remain unknown.
std::string describe_units(const Model& model, const UnitReport& units);

/// `bgsim equations`: the state equations in the model's own names.
std::string equations_text(const Model& model, const EquationSystem& system, const BlockOrder& order);
std::string equations_latex(const Model& model, const EquationSystem& system, const BlockOrder& order);

/// `bgsim show --stage ...`: every stage's value as text; the same model gives the same bytes.
std::string show_model(const Model& model);
std::string show_graph(const Model& model, const BondGraph& graph);
std::string show_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal);
std::string show_units(const Model& model, const BondGraph& graph, const UnitReport& units);
std::string show_equations(const Model& model, const EquationSystem& system);
std::string show_order(const Model& model, const EquationSystem& system, const BlockOrder& order);
std::string show_program(const Program& program);

}  // namespace bgsim
