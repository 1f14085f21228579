/// The equations that a model puts up for its units, each with what it says in words.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/bond_graph.hpp"
#include "units/system.hpp"

namespace bgsim {

/// Whose text an equation comes from.
struct UnitSite {
  enum class Kind : std::uint8_t { parameter, signal, output, element, law, energy, initial, event, scene } kind;
  std::uint32_t index = 0;  ///< of the parameter, signal, output, element or event
  std::uint32_t port = 0;   ///< of a field; for initial values the position among them
};

/// What an equation between units says.
struct UnitEquation {
  enum class Kind : std::uint8_t {
    given,       ///< the model gives a quantity's unit
    value,       ///< a quantity (left) is what an expression (right) gives
    quotient,    ///< two variables (by name) make what a key (right) is
    energy,      ///< effort times displacement, or flow times momentum, at a port is the energy (right)
    one_energy,  ///< the ports of a store agree on what their energies are
    same_power,  ///< a two-port passes its power on
    sum,         ///< left and right are added, subtracted, compared, ...: operation
    pure,        ///< right must be a pure number: it is an argument of operation
    abscissa,    ///< right is where a table is read
  } kind;
  UnitSite site;
  Op operation = Op::add;
  ExprId left, right;
  UnitForm left_form;  ///< meaning of `left`; right makes the equation hold
  std::string name;    ///< kinds value and quotient: the left side in words
  Place place;
};

/// Efforts and flows that junctions make equal, as variables 2r and 2r + 1 of region r.
struct UnitRegions {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> of_bond;
};
UnitRegions unit_regions(const BondGraph& graph);

/// The system, with one equation in words for each of its equations.
struct UnitEquations {
  UnitSystem system;
  std::vector<UnitEquation> equations;
  UnitRegions regions;
  std::uint32_t first_parameter = 0, first_signal = 0;
  std::vector<std::optional<UnitForm>> outputs;  ///< none where any unit would do
};

/// Texts of units that are not understood are left out.
/// @param parameters  units given, by ParameterId; likewise signals and outputs.
struct GivenUnits {
  std::vector<std::optional<Unit>> parameters, signals, outputs;
};
UnitEquations unit_equations(const Model& model, const BondGraph& graph, const GivenUnits& given, const Scene* scene);

/// The unit of a symbol of the model's pool, over the system's variables.
UnitForm unit_form(const Model& model, const BondGraph& graph, const UnitEquations& equations, SymbolId symbol);

/// A unit in the words of a model.
using UnitName = std::function<std::string(const Unit&)>;
/// What would be if a unit that the model gives were not given.
struct UnitTrial {
  std::size_t contradictions = 0;
  std::optional<Unit> unit;  ///< what the quantity's unit would then be
};
using TryWithout = std::function<UnitTrial(const UnitEquation& given)>;
/// Puts what contradicts into words: one diagnostic for each cause.
std::vector<Diagnostic> unit_diagnostics(const Model& model, const BondGraph& graph, const UnitEquations& equations,
                                         const UnitName& name, const TryWithout& try_without);

/// What makes efforts and flows of a region that no power comes of.
Diagnostic no_power(const Model& model, const BondGraph& graph, const UnitEquations& equations, const UnitName& name,
                    std::uint32_t region);

}  // namespace bgsim
