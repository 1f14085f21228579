/// What the stages found, in words: the texts of `bgsim check`, `equations` and `show`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bgsim/infer_units.hpp"
#include "bgsim/ordering.hpp"
#include "bgsim/program.hpp"

namespace bgsim {

/// What causality found, under one heading: rows of two columns, the second often empty. Long lists are cut, with the
/// count of what is not shown.
struct Finding {
  std::string heading;
  std::vector<std::pair<std::string, std::string>> rows;
  std::size_t more = 0;      ///< rows cut
  bool new_section = false;  ///< separated from what comes before
};

/// Counts; strokes and their reasons, states, dependent stores and why, free choices, laws not used as written, fields'
/// reciprocity, unconnected parts.
std::vector<Finding> causal_findings(const Model& model, const BondGraph& graph, const CausalGraph& causal);

/// `bgsim check`: the findings as text, and loops and through which elements they run.
std::string describe_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal);
/// What each mode of the switches makes of the stores, and which modes the graph does not allow; empty without
/// switches.
/// @note Causality and equations are derived for each mode, of up to 12 switches.
std::string describe_modes(const Model& model, const BondGraph& graph);
std::string describe_loops(const Model& model, const EquationSystem& system, const BlockOrder& order);
/// Which units are given, which follow from them, which remain unknown.
std::string describe_units(const Model& model, const UnitReport& units);

/// `bgsim equations`: the state equations in the model's own names.
std::string equations_text(const Model& model, const EquationSystem& system, const BlockOrder& order);
std::string equations_latex(const Model& model, const EquationSystem& system, const BlockOrder& order);

/// The same for a page: insides of <math> elements. A right side comes in the terms of its outermost sum, each with its
/// sign, so that a line may be broken between them.
struct EquationLine {
  std::string left;
  std::vector<std::string> right;
};
struct EquationGroup {
  std::string title;  ///< "state equations", "where", ...
  std::vector<EquationLine> lines;
};
std::vector<EquationGroup> equations_mathml(const Model& model, const EquationSystem& system, const BlockOrder& order);

/// `bgsim show --stage ...`: every stage's value as text; the same model gives the same bytes.
std::string show_model(const Model& model);
std::string show_graph(const Model& model, const BondGraph& graph);
std::string show_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal);
std::string show_units(const Model& model, const BondGraph& graph, const UnitReport& units);
std::string show_equations(const Model& model, const EquationSystem& system);
std::string show_order(const Model& model, const EquationSystem& system, const BlockOrder& order);
std::string show_program(const Program& program);

}  // namespace bgsim
