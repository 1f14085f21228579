/// EquationSystem: the model's equations, one for each unknown, as expressions. No order, no Jacobians, no solver.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// Meaning of a symbol in an EquationSystem's pool.
struct SystemSymbol {
  enum class Kind : std::uint8_t { time, parameter, state, unknown };
  Kind kind = Kind::unknown;
  std::uint32_t index = 0;  ///< ParameterId, index into states, or index into equations
  std::string name;         ///< "packet.wall.q", "orifice.f", "b3.e", "der(b3.e)"
};

/// Defines one unknown: explicitly, `unknown = expression`; or implicitly, `0 = expression` to be solved for `unknown`.
struct Equation {
  SymbolId unknown;
  ExprId expression;
  bool implicit = false;
  ElementId element;  ///< whose law or junction rule it is; none for signals
  Place place;
  /// `0 = loop_form` is the same law in the form in which a loop through it is solved for the unknown: without
  /// logarithms, which have no digits left where a diode blocks; without roots, whose slope has no bound where a pipe
  /// is at rest; without the conditions of an inverse by parts. None for most.
  ExprId loop_form = {};
  ExprId whole;  ///< of a derivative: what it is the derivative of, if that has to be looked at in a run (Continuous)
};

/// An independent store, or an integral among the signals: x' = rate.
struct State {
  std::string name;  ///< "packet.wall.q"; "left.x" of an integral
  SymbolId symbol;
  ExprId rate;
  ElementId element;  ///< whose store it is; none for an integral
  std::uint32_t port = 0;
  SignalId signal;  ///< whose integral it is; none for a store
};
/// Where the model says what the state is.
Place place_of(const Model& model, const State& state);

/// A store in derivative causality: its q or p is an unknown that the states determine.
struct DependentStore {
  std::string name;
  SymbolId symbol;
  ElementId element;
  std::uint32_t port = 0;
  ExprId rate;  ///< the symbol's total derivative
};

/// A one-port, field or source as the energy audit sees it.
struct EnergyPart {
  enum class Role : std::uint8_t { source, dissipator, store };
  Role role = Role::source;
  ElementId element;
  ExprId power;  ///< supplied (sources: out of the element) or taken in (others), over unknowns
  // stores only:
  ExprId energy;                        ///< energy as a function of `displacements`, or none if only laws are given
  std::vector<SymbolId> displacements;  ///< q or p of each port (states or unknowns)
  std::vector<ExprId> conjugates;       ///< e (or f) of each port as a function of `displacements`, time and parameters
  std::vector<ExprId> port_powers;      ///< of a field: taken in at each port, over unknowns
  bool modulated = false;  ///< energy depends on more than displacements and parameters: audited by its power alone
};

/// A quantity whose time derivative is needed, and which may jump: the run looks whether it does, where its conditions
/// change or a delayed signal in it has a jump, or where events of the model set it.
struct Continuous {
  SymbolId derivative;
  ExprId value;
  Diagnostic fault;     ///< BG402, for when it does
  bool is_set = false;  ///< by events: a signal, or a source that follows what they set
};

struct OutputEquation {
  std::string name;
  ExprId value;
  std::string unit;
};

/// Whose law or signal an expression comes from; both none for what belongs to no single place.
struct Origin {
  ElementId element;
  SignalId signal;
};

/// A switch of the model, on the side that it is on in this system.
struct SwitchEquation {
  ElementId element;
  ExprId leaves;  ///< 1 where the condition holds under which it goes to its other side, else 0
};

/// A diode or contact of the model. Counted the way that it passes; `flow` of a contact is the room that it has left,
/// gap - q, which stands for the flow: it is 0 or more, and 0 where there is an effort.
struct DiodeEquation {
  ElementId element;
  ExprId effort, flow;
  ExprId threshold;
  ExprId fires;  ///< 1 where it may begin to conduct, else 0
};

/// An event of the model.
struct EventEquation {
  ExprId when;  ///< 1 where its condition holds, else 0
  struct Set {
    std::optional<std::uint32_t> state;  ///< index into EquationSystem::states; none: it is dependent in this system
    std::string name;                    ///< "mass.p"
    ExprId value;                        ///< over unknowns, states, time and parameters of the instant before
  };
  std::vector<Set> sets;
};

/// What an impulse into a dependent store is to a state: per unit of the impulse, what the state gains.
struct ImpulseTerm {
  std::uint32_t state = 0;      ///< index into EquationSystem::states
  std::uint32_t dependent = 0;  ///< index into EquationSystem::dependent
  ExprId factor;                ///< over unknowns, states, time and parameters
};

/// How the stores move at once where a mode begins. An impulse that moves a dependent store moves the states that the
/// junctions, TF and GY between them connect it with, and nothing else: resistors, whose impulse would cost an energy
/// without bound, take none.
struct JumpEquations {
  std::vector<ImpulseTerm> terms;  ///< by state, then dependent store
  std::vector<ExprId> conjugates;  ///< effort of a C or flow of an I, port by port of `energy`'s displacements
};

/// What a run leaves out, since none of its outputs depends on it; and what its energy balance does not look at.
struct LeftOut {
  std::vector<std::string> states;       ///< names, in model order
  std::vector<std::string> elements;     ///< whose laws are not evaluated at all; junctions are not listed
  std::vector<std::string> signals;      ///< that are not evaluated
  std::vector<std::string> not_audited;  ///< elements whose power depends on what is left out
  std::size_t loops = 0;                 ///< algebraic loops
  [[nodiscard]] bool nothing() const { return states.empty() && elements.empty() && signals.empty() && loops == 0; }
};

struct EquationSystem {
  ExprPool pool;
  std::vector<Origin> origins;        ///< by ExprId: what it was first made for, for messages
  std::vector<SystemSymbol> symbols;  ///< by SymbolId of the pool
  SymbolId time;
  std::vector<SymbolId> parameters;      ///< by ParameterId
  std::vector<SymbolId> efforts, flows;  ///< by BondId: unknowns, counted along the half-arrow
  std::vector<SymbolId> signals;         ///< by SignalId: unknowns
  std::vector<State> states;             ///< in model order
  std::vector<DependentStore> dependent;
  std::vector<Equation> equations;      ///< one per symbol of kind unknown
  std::vector<OutputEquation> outputs;  ///< by position in Model::outputs
  std::vector<EnergyPart> energy;
  std::vector<Continuous> continuous;
  std::vector<SwitchEquation> switches;  ///< in model order
  std::vector<DiodeEquation> diodes;     ///< in model order
  std::vector<EventEquation> events;     ///< by position in Model::events
  /// By delayed signal, in model order.
  struct Delay {
    SignalId signal;
    ExprId value, by, initial;  ///< see Signal::Delay
  };
  std::vector<Delay> delays;
  JumpEquations jump;  ///< empty in a model without switches
  LeftOut left_out;    ///< by slice(); nothing before
  std::vector<Diagnostic> warnings;
};

/// Writes each element's law in the assigned causality: as written, inverted, or implicit; junctions, TF and GY
/// as their rules; dependent stores through symbolic differentiation (d/dt of moduli included).
///
/// @throws ModelError BG402 derivative of a jump (a store tied to a stepping source), BG403 more than eight
///         differentiations in a row (higher index).
/// @param in_pieces  derivatives of what jumps are those on the present side, instead of BG402
/// @note Time linear in bonds and laws, except for what is differentiated.
EquationSystem derive_equations(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                                bool in_pieces = false);

}  // namespace bgsim
