/// Program: the ordered equations as flat instructions.
///
/// Relations (comparisons, sign, step, floor, ceil, round, mod, linear tables) are frozen between events: each is a
/// mode, an input of the instructions, so that what the integrator sees within a step is smooth. The integrator watches
/// the guards and changes modes only at events.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// out = op(a, b, c) on slots. For tables b is the TableId and c the slot of the cell (kNoSlot: look it up).
struct Instruction {
  Op op = Op::constant;
  std::uint32_t out = 0, a = 0, b = 0, c = 0;
};
constexpr std::uint32_t kNoSlot = 0xffffffffU;

/// Instructions that can run as one loop: of one operator, and none needs another's result.
struct Strip {
  /// mixed: instructions of any operators, one after the other; of_one: of one operator, on any slots; in_rows: their
  /// results are in slots that follow each other, and the slots of each argument are equally far apart.
  enum class Kind : std::uint8_t { mixed, of_one, in_rows };
  Kind kind = Kind::mixed;
  std::int32_t a_step = 0, b_step = 0;  ///< in_rows: from one argument's slot to the next
  std::uint32_t first = 0, count = 0;   ///< of the code's instructions
};

/// Instructions in an order in which they can run, and the same as strips.
struct CodeList {
  std::vector<Instruction> instructions;
  std::vector<Strip> strips;
  std::uint32_t number = 0;  ///< among those of the program, 0 for Program::once: where an evaluator keeps what it made
                             ///< of it

  [[nodiscard]] auto begin() const { return instructions.begin(); }
  [[nodiscard]] auto end() const { return instructions.end(); }
  [[nodiscard]] std::size_t size() const { return instructions.size(); }
};

/// Instructions and solves of loops in turn: code[i] runs, then block solves[i]; the last code has no solve after it.
struct Routine {
  std::vector<CodeList> code;
  std::vector<std::uint32_t> solves;   ///< indices into Program::blocks
  std::vector<std::uint32_t> results;  ///< slots, in the order asked for
};

/// What a mode is frozen from.
struct Relation {
  /// denominator: no mode of anything, but a factor of a denominator that must not pass zero.
  enum class Kind : std::uint8_t { condition, sign, step, floor, round, cell, denominator };
  Kind kind = Kind::condition;
  ExprId origin;  ///< the comparison, sign, step, floor, round or table expression, not frozen, in Program::pool;
                  ///< denominator: the sign of the factor
  ExprId guard;   ///< condition, sign, step, denominator: changes sign where the mode changes; floor, round, cell: the
                  ///< argument
  Op comparison = Op::lt;   ///< condition: lt, le, gt, ge of the guard against 0
  TableId table;            ///< cell: whose knots
  bool structural = false;  ///< denominator: a resistance, capacitance, inertance or modulus itself
  bool negated = false;     ///< floor: of -x, in place of ceil(x); the mode is the negative of its value
  bool time_only = false;   ///< depends on time and parameters only: a scheduled event, no root function
  bool samples = false;     ///< stands behind a sampled signal: its changes are the instants of samples
  std::string text;         ///< in the model's own names, for messages
  Origin where;             ///< whose expression it is
  /// Two guards instead of one: the distances to both ends of the present cell.
  [[nodiscard]] bool has_borders() const { return kind == Kind::floor || kind == Kind::round || kind == Kind::cell; }
  /// Whether a mode is none of the two sides but between them: held at the border.
  [[nodiscard]] bool is_between(double mode) const {
    if (kind == Kind::sign) return mode != -1.0 && mode != 1.0;
    return (kind == Kind::condition || kind == Kind::step) && mode != 0.0 && mode != 1.0;
  }
};

/// A loop, ready to be solved: linear ones by elimination, the others by damped Newton iteration.
struct ProgramBlock {
  std::uint32_t first_tear = 0;  ///< its tears are this one and the following
  std::uint32_t size = 0;
  Routine residual;                                              ///< results: residuals
  Routine jacobian;                                              ///< results: partials in the order of `entries`
  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  ///< (residual, tear) within the block
  std::vector<bool> explicit_row;  ///< residual is `tear - expression`: of magnitude 1 in the tear's own unit
  bool linear = false;
  bool refined = false;               ///< see Block
  std::vector<std::string> tears;     ///< names
  std::vector<std::string> elements;  ///< names, junctions left out
  Place place;                        ///< of the first element
};

/// Sparsity by columns (CSC), rows increasing; the diagonal is always present.
struct Sparsity {
  std::size_t size = 0;
  std::vector<std::int64_t> column_start;
  std::vector<std::int64_t> row;
};

/// How df/dx is put together from partial derivatives when loops are eliminated; and the implicit form's partials.
struct JacobianPlan {
  struct Entry {
    std::uint32_t row, column;  ///< column: state or tear
    std::uint32_t slot;
  };
  std::vector<Entry> rates_by_states, rates_by_tears;
  struct BlockPart {
    std::vector<Entry> by_states, by_earlier_tears, by_own_tears;  ///< rows and own columns within the block
    std::vector<std::uint32_t> columns;  ///< states that the block's tears depend on, increasing
  };
  std::vector<BlockPart> blocks;
  std::vector<std::uint32_t> block_of_tear;
  Routine routine;            ///< solves the loops and computes all slots above
  Routine implicit_routine;   ///< computes all slots above with the tears as given
  bool explicit_form = true;  ///< false where elimination would fill too much: only the implicit form can be integrated
};

/// What holds all along a step, with its partials by what it is solved for: in Program::pool, frozen.
struct ImplicitEquation {
  ExprId value;                                                      ///< 0 at the solution; not valid: it is not known
  std::vector<std::pair<std::uint32_t, ExprId>> by_tears, by_modes;  ///< (tear or relation, partial)
};

/// Partial derivatives by parameters and by time, and those of outputs, guards and what events set: what the adjoint
/// equations need beside the Jacobian's (see Evaluator::pull_back). Empty unless asked for (CompileOptions::columns).
struct TransposedPlan {
  std::vector<std::uint32_t> columns;  ///< ParameterIds; the last column of all, behind them, is time
  struct Rows {
    std::vector<JacobianPlan::Entry> by_states, by_tears, by_columns;
  };
  Rows outputs, guards, sets;                            ///< by output; by relation; by result of event_values
  std::vector<JacobianPlan::Entry> rates;                ///< by columns; by states and tears: JacobianPlan's
  std::vector<std::vector<JacobianPlan::Entry>> blocks;  ///< by block: by columns
  Routine routine;         ///< solves the loops and computes all slots above but those of guards and sets
  Routine events_routine;  ///< the same for these
};

/// The laws of a store without a closed-form energy: efforts (flows) of its ports over what they store.
struct LawsOfStore {
  std::vector<SymbolId> displacements;
  std::vector<ExprId> conjugates;  ///< in Program::pool, not frozen; empty if the audit does not need them
};

/// Whose state it is, or whose store in derivative causality.
struct StateInfo {
  Place place;             ///< where the model says what it is
  ElementId element;       ///< whose store it is; none for an integral
  std::uint32_t port = 0;  ///< of the element
  SignalId signal;         ///< whose integral it is; none for a store
};

/// How the stores move at once where the program's mode begins (see JumpEquations).
struct JumpPlan {
  struct Term {
    std::uint32_t state = 0, dependent = 0;
  };
  std::vector<Term> terms;
  Routine routine;  ///< results: the terms' factors, then the conjugates by the displacements of all energy parts
};

/// An event of the model.
struct ProgramEvent {
  std::string name;
  double priority = 0.0;
  Place place;
  struct Set {
    std::optional<std::uint32_t> state;  ///< none: it is dependent in this program
    std::string name;                    ///< "mass.p"
    Place place;
  };
  std::vector<Set> sets;
  std::uint32_t first_value = 0;  ///< among the results of Program::event_values
  bool memory = false;            ///< a sample or a change of a latch, and no event of the file
};

/// A delayed signal.
struct ProgramDelay {
  std::string name;
  TableId table;            ///< in Program::pool
  std::uint32_t clock = 0;  ///< state: the time since the start
  bool initial = false;     ///< the model says what was before the start
  Place place;
};

/// All that a run needs: it refers to nothing outside of itself, and nothing changes it.
struct Program {
  std::shared_ptr<const Model> model;
  ExprPool pool;                ///< frozen expressions, and the relations' origins
  std::vector<Origin> origins;  ///< by ExprId of `pool`
  /// Laws that are continued beyond their ends within a step, by ExprId of `pool`: as the model has them.
  std::unordered_map<std::uint32_t, ExprId> continued;
  std::vector<std::string> symbol_names;  ///< by SymbolId; modes follow the system's symbols
  SymbolId time;
  std::vector<SymbolId> parameters;  ///< by ParameterId
  std::vector<std::string> state_names, tear_names;
  std::vector<StateInfo> states;  ///< by state
  std::vector<std::string> dependent_names;
  std::vector<StateInfo> dependent;                     ///< by EquationSystem::dependent
  LeftOut left_out;                                     ///< what slice() took away
  std::vector<std::string> output_names, output_units;  ///< of the outputs compiled
  std::vector<std::string> indefinite_outputs;  ///< that depend on what idle switches and diodes leave indefinite
  std::vector<ElementId> indefinite_diodes;     ///< these diodes: their sides are one choice of several
  std::vector<std::string> energy_names;        ///< by energy part: element
  std::vector<ElementId> energy_elements;
  std::vector<EnergyPart::Role> energy_roles;
  std::vector<bool> energy_modulated;
  std::vector<LawsOfStore> store_laws;  ///< by energy part

  // Slots: time, states, tears, modes, parameters, then constants and computed values.
  std::size_t slots = 0;
  std::vector<double> initial_slots;    ///< constants in place, 0 elsewhere
  std::vector<ExprId> slot_expression;  ///< by slot
  std::uint32_t time_slot = 0, first_state = 0, first_tear = 0, first_mode = 0, first_parameter = 0;

  std::uint32_t code_lists = 1;  ///< number of the next one

  Routine once;  ///< everything that depends on parameters only
  Routine rates, outputs, guards;
  Routine powers;                                 ///< by energy part, then those of fields at each port
  std::vector<std::uint32_t> first_port_power;    ///< in `powers`, by energy part, plus one at the end
  Routine stored;                                 ///< by energy part; NaN slot where there is no closed form
  Routine displacements;                          ///< q or p of every store port, by energy part
  std::vector<std::uint32_t> first_displacement;  ///< by energy part, plus one at the end
  Routine dependents;                             ///< q or p of EquationSystem::dependent
  Routine switches;                               ///< by `switch_elements`: 1 where one leaves its side, else 0
  std::vector<ElementId> switch_elements;
  Routine diodes;  ///< by `diode_elements`: effort, flow (the way that it passes), threshold, 1 where it may fire
  std::vector<ElementId> diode_elements;
  Routine event_conditions;  ///< by `events`: 1 where its condition holds, else 0
  Routine event_values;      ///< of all that they set, event by event; with Variations then two slopes of each
  std::vector<ProgramEvent> events;
  Routine delayed;         ///< by `delays`: what is delayed, and by how much
  Routine delayed_before;  ///< by `delays`: what it was before the start; 0 where the model does not say
  std::vector<ProgramDelay> delays;
  JumpPlan jump;
  /// Of a system with Variations: so many states are the model's own; state i changes with the parameter by what state
  /// varied_states + i holds. 0 in all others.
  std::size_t varied_states = 0;
  Routine crossings;          ///< by relation: what its guard changes by with that parameter, and with time
  Routine continuous;         ///< by `must_not_jump`
  Routine implicit_residual;  ///< rates, then residuals of all blocks, with the tears as given
  std::vector<ProgramBlock> blocks;
  std::vector<Relation> relations;
  std::vector<Diagnostic> must_not_jump;  ///< what is said if a quantity jumps whose derivative the rates contain
  std::vector<bool> jumps_if_set;         ///< by `must_not_jump`: events set it, or what it follows
  std::vector<ExprId> sources;  ///< the largest expressions of time and parameters alone in rates and loops, not frozen
  std::vector<std::uint32_t>
      guarded;  ///< relations that are not time_only: result i of `guards` is of relation guarded[i]
  std::vector<ImplicitEquation> border_rates;    ///< by relation: how fast the guard of one that may be held moves
  std::vector<ImplicitEquation> loop_equations;  ///< by tear: residuals; where guards may be held, else none
  JacobianPlan plan;
  TransposedPlan transposed;
  Sparsity jacobian_pattern;  ///< df/dx with loops eliminated
  Sparsity implicit_pattern;  ///< of y = (states, tears), residual (x' - f(x, z), F(x, z))
  SystemClass system_class = SystemClass::explicit_ode;
};

/// The derivatives of a system by one parameter, which are states and loops of the same system (see with_variations).
struct Variations {
  std::size_t states = 0;  ///< those of the model itself, before their derivatives
  /// Of states, tears, time and parameters: their derivatives by the parameter and by time, in BlockOrder::pool. What
  /// is not listed does not change.
  std::vector<std::pair<SymbolId, ExprId>> by_parameter, by_time;
};

/// What is compiled.
struct CompileOptions {
  std::vector<std::size_t> outputs;        ///< positions in Model::outputs, in the order of the trace's columns
  bool energies = true;                    ///< the energy audit's powers and stored energies
  const Variations* variations = nullptr;  ///< none in most systems
  /// Parameters by which partials are taken for the adjoint equations (Program::transposed); null: no such equations.
  const std::vector<std::uint32_t>* columns = nullptr;
};

/// Compiles. Cost linear in the expressions, plus the Jacobian's symbolic partials.
Program compile(std::shared_ptr<const Model> model, const EquationSystem& system, const BlockOrder& order,
                const CompileOptions& options);

}  // namespace bgsim
