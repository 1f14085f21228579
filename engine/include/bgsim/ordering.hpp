/// BlockOrder: in which order the unknowns can be computed, and which of them only together.
#pragma once

#include <string>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// Unknowns that depend on each other: an algebraic loop, cut at its tear variables.
struct Block {
  std::vector<SymbolId> members;    ///< all unknowns of the loop; the cut ones among them
  std::vector<SymbolId> tears;      ///< iteration variables
  std::vector<ExprId> residuals;    ///< one per tear, over states, time, parameters, tears of this and earlier blocks
  bool linear = false;              ///< the residuals' partials by this block's tears are free of them
  bool refined = false;             ///< tears may be far smaller than what they are the difference of
  std::vector<ElementId> elements;  ///< through which the loop runs, in model order
};

enum class SystemClass : std::uint8_t {
  explicit_ode,  ///< no loops
  local_blocks,  ///< loops small enough to be solved inside the right-hand side
  implicit_dae,  ///< a loop of more than kLargestLocalBlock tears: index-1 DAE for IDA
};
constexpr std::size_t kLargestLocalBlock = 64;

/// Everything substituted: what remains are states, time, parameters and tear variables.
struct BlockOrder {
  ExprPool pool;                ///< superset of the system's pool: its ids stay valid
  std::vector<Origin> origins;  ///< by ExprId
  std::vector<Block> blocks;    ///< in order of evaluation; only those that something needed depends on
  std::vector<ExprId>
      resolved;                 ///< by SymbolId: the unknown over states, time, parameters and tears (none if unneeded)
  std::vector<ExprId> rates;    ///< by state
  std::vector<ExprId> outputs;  ///< by output
  std::vector<ExprId> powers;   ///< by EquationSystem::energy
  std::vector<std::vector<ExprId>> port_powers;  ///< by EquationSystem::energy: of a field at each port; else empty
  std::vector<ExprId> stored;      ///< by EquationSystem::energy: a store's energy, none if it has no closed form
  std::vector<ExprId> continuous;  ///< by EquationSystem::continuous; none where the derivative is not needed
  std::vector<ExprId> switches;    ///< by EquationSystem::switches
  std::vector<ExprId> event_conditions, event_values;  ///< of EquationSystem::events; values event by event
  std::vector<ExprId> delayed, delayed_before;         ///< by EquationSystem::delays: value and by; initial, or 0
  std::vector<ExprId> diodes;                          ///< by EquationSystem::diodes: effort, flow, threshold, fires
  std::vector<ExprId> impulses, conjugates;            ///< by the terms and conjugates of EquationSystem::jump
  SystemClass system_class = SystemClass::explicit_ode;
};

/// Finds the strongly connected parts of the unknowns (Boost.Graph), tears them, and substitutes the rest away.
/// @throws ModelError BG411 structurally singular: a loop whose equations do not contain its own unknowns.
/// @note Time linear in the equations plus, for each loop, the product of its size and its number of tears.
BlockOrder order_equations(const Model& model, const EquationSystem& system);

}  // namespace bgsim
