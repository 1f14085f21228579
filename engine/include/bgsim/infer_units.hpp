/// infer_units: which unit each quantity of a model has, and where the units that are given contradict each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/bond_graph.hpp"
#include "bgsim/unit.hpp"

namespace bgsim {

/// A quantity's unit.
struct QuantityUnit {
  std::optional<Unit> unit;  ///< none if nothing determines it
  std::string text;          ///< as given, else as computed; empty if unknown
  bool given = false;        ///< the model says it
};

/// The efforts and flows of bonds that meet at junctions: all efforts have one unit, and all flows.
struct UnitRegion {
  QuantityUnit effort, flow;
  std::vector<BondId> bonds;
  bool pseudo = false;  ///< effort times flow has a unit, which is no power
};

/// Units by name. What a model gives is never changed; the rest follows from laws, energies, junctions and signals.
struct UnitReport {
  bool any_given = false;                                  ///< a model that gives no units is not looked at
  std::vector<QuantityUnit> parameters, signals, outputs;  ///< by ParameterId, SignalId, position
  std::vector<UnitRegion> regions;
  std::vector<std::uint32_t> region_of_bond;  ///< by BondId
  std::string energy;  ///< the unit of effort times flow times t, if all regions have the same one, else empty
  std::vector<Diagnostic> problems;  ///< BG160 and BG163 (warnings), BG161, BG162, in file order
  bool complete = true;              ///< false: too entangled to be solved in the time that is allowed
};

/// Treats the logarithms of units as unknowns of a linear system: each law, energy, junction, signal, output and
/// initial value is an equation in them, t is in seconds. Units of a part of a graph that nothing else determines are
/// taken such that effort times flow is in watts.
///
/// Numbers in a sum, comparison or alternative, and numbers that stand alone, take the unit that is wanted; in a
/// product with quantities they are pure numbers (docs/design/units.md).
/// @param scene  a scene whose values override the model's definitions; empty for the model itself.
/// @return contradictions are reported in `problems`, not thrown: numbers are used as written, whatever their units.
/// @note Time linear in the model where propagation suffices, which is the rule; elimination is bounded.
UnitReport infer_units(const Model& model, const BondGraph& graph, const std::string& scene = {});

/// Errors in the units of the model and in each of its scenes, each once.
std::vector<Diagnostic> unit_problems(const Model& model, const BondGraph& graph);

}  // namespace bgsim
