/// Model: what the JSON files say, with submodels unfolded and every expression parsed. No ids of bonds' ends beyond
/// names resolved, no strokes, no invented defaults.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/diagnostic.hpp"
#include "bgsim/expression.hpp"
#include "bgsim/id.hpp"
#include "bgsim/method.hpp"
#include "bgsim/output_times.hpp"

namespace bgsim {

/// Kinds of elements; what is known of each is a row of the table in model/element_kinds.cpp. The modulated kinds (MSe,
/// MR, ...) are the same kinds with Element::modulated set.
enum class ElementKind : std::uint8_t {
  effort_source,
  flow_source,
  effort_detector,
  flow_detector,
  open_switch,  ///< an Sw, which is one of two kinds, as its side is: see bgsim/modes.hpp
  closed_switch,
  blocking_diode,
  conducting_diode,
  free_contact,  ///< a contact, whose sides are an effort source of 0 and a flow source of the gap's rate
  closed_contact,
  resistor,
  capacitor,
  inertia,
  transformer,
  gyrator,
  c_field,
  i_field,
  ic_field,
  r_field,
  zero_junction,
  one_junction,
};

/// The variables at a port: effort, flow, displacement (C), momentum (I).
enum class Variable : std::uint8_t { effort, flow, displacement, momentum };

/// The kind as it is written in a model: "MSe", "CC", "0".
std::string kind_text(ElementKind kind, bool modulated);
[[nodiscard]] bool is_junction(ElementKind kind);
[[nodiscard]] bool is_store(ElementKind kind);
[[nodiscard]] bool is_source(ElementKind kind);
/// What signals read an effort or flow at without taking power.
[[nodiscard]] bool is_detector(ElementKind kind);
/// An Sw: a source of no flow while it is open, of no effort while it is closed.
[[nodiscard]] bool is_switch(ElementKind kind);  ///< diodes and contacts among them
[[nodiscard]] bool is_diode(ElementKind kind);   ///< contacts among them
[[nodiscard]] bool is_contact(ElementKind kind);
/// What an element sets at its bond whatever the rest of the graph does: a source its own variable, a detector the
/// other one, which it keeps at zero. None for all other kinds.
[[nodiscard]] std::optional<Variable> imposed_variable(ElementKind kind);
char letter(Variable variable);  ///< 'e', 'f', 'q', 'p'

/// Meaning of a symbol in a model's expressions.
struct ModelSymbol {
  enum class Kind : std::uint8_t {
    time,
    parameter,      ///< parameter
    signal,         ///< signal
    port_variable,  ///< element, port, variable; for junctions port is 0 and variable what the junction's bonds share
    bond_variable,  ///< bond, variable (effort or flow)
    mode,           ///< element, a switch, diode or contact: 1 while it is closed (conducts, touches), else 0
  };
  Kind kind = Kind::time;
  ParameterId parameter;
  SignalId signal;
  ElementId element;
  std::uint32_t port = 0;
  BondId bond;
  Variable variable = Variable::effort;
};

struct Parameter {
  std::string name;  ///< full name, e.g. "left.m"
  ExprId value;      ///< over parameters only
  SymbolId symbol;
  std::string unit, about;
  Place place;        ///< the value's place
  std::string scope;  ///< "" or "left.": names in --set and in scenes are full names
  Place unit_place;   ///< of the unit's text, where there is one
};

struct Signal {
  enum class Kind : std::uint8_t {
    value,     ///< is `value` at each instant
    integral,  ///< a state: its rate is `value`
  };
  std::string name;
  ExprId value;
  SymbolId symbol;
  std::string unit, about;
  Place place;       ///< of the expression
  Place unit_place;  ///< of the unit's text, where there is one
  Kind kind = Kind::value;
  ExprId initial;  ///< of an integral, over parameters; none: 0
  Place initial_place;
  /// Of one that is delayed: its value is a table over the time since the start, which the run fills.
  struct Delay {
    ExprId value;    ///< what it was `by` earlier
    ExprId by;       ///< over parameters
    ExprId initial;  ///< what it was before the start, over t and parameters; none: what it is at the start
    TableId table;
    SignalId clock;  ///< the time since the start
    Place by_place, initial_place;
  };
  ExprId every, offset;  ///< of one that is sampled, over parameters: an integral of 0 that an event sets; else none
  Place every_place;
  std::optional<Delay> delay = {};
  [[nodiscard]] bool is_state() const { return kind == Kind::integral; }
};

/// One constitutive equation: `variable of port = right`, or `0 = right` of a resistor.
struct Law {
  std::uint32_t port = 0;  ///< of the variable alone on the left
  Variable variable = Variable::effort;
  ExprId right;
  Place place;        ///< of the whole text
  bool zero = false;  ///< "0 = right": nothing is alone on the left, and `variable` has no meaning
};

struct InitialValue {
  std::uint32_t port = 0;
  ExprId value;  ///< over parameters only
  Place place;
  bool conjugate = false;  ///< of the effort of a C or the flow of an I, from which the law gives what is stored
};

/// When an Sw goes to its other side. The conditions may depend on all that signals may depend on.
struct SwitchLaw {
  ExprId closes, opens;    ///< conditions; each matters on the other side alone
  bool locks = false;      ///< written as "locked": `opens` is the condition that was written
  bool remembers = false;  ///< written as "close" and "open"; else each of the two is the other's contrary
  Place closes_place, opens_place;
};

/// An ideal diode: with flow and effort counted the way that it passes, 0 <= f, e <= e0, and one of them is at its
/// border. e0, the threshold, is the element's coefficient.
struct DiodeLaw {
  bool out = false;  ///< passes what flows out of the element
  ExprId threshold;  ///< the coefficient
  ExprId fire;       ///< condition without which it does not begin to conduct; none: it needs none
  Place fire_place;
  ParameterId band;  ///< how far f or e may be beyond its border by rounding; none: not at all
  /// Of one with a fire: a flow of at most this has ended where the fire does not hold; none: it is not looked for.
  ParameterId holding;
};

/// A unilateral stop: 0 <= e, q <= gap, e (gap - q) = 0 with q' = f. It is a diode as well (Element::diode), which
/// passes out: its flow, counted that way, is the speed of separation. The gap is the element's coefficient.
struct ContactLaw {
  SignalId displacement;  ///< q, an integral among the signals
  ExprId speed;           ///< rate of the gap
  ExprId restitution;     ///< over parameters and the element's own f, which stands for the closing speed
  Place restitution_place;
  ParameterId kick;        ///< speed of separation after an impact, while that is computed; none: 0
  ParameterId rest;        ///< time at which infinitely many impacts end; none: nothing asks for mode("...")
  ParameterId rest_moves;  ///< by what is varied; none where `rest` is none
  bool settling = false;   ///< closed, though mode("...") does not say so before `rest`, where the program ends
};

/// An element as written. Which of the optional members are set follows from the kind:
/// sources `coefficient` (effort or flow); R, C, I `coefficient` (resistance, capacitance, inertance) or one `law`;
/// TF, GY `coefficient` (modulus); CC, II, IC `energy` or `laws`; RR `laws`; Sw `switches` (and the coefficient 0);
/// D `diode` and `coefficient` (the threshold); contact `diode`, `contact` and `coefficient` (the gap);
/// junctions nothing.
struct Element {
  std::string name;  ///< full name, e.g. "left.orifice"
  ElementKind kind = ElementKind::resistor;
  bool modulated = false;
  ExprId coefficient;  ///< none unless given
  ExprId energy;       ///< none unless given
  std::vector<Law> laws;
  std::vector<std::string> ports;  ///< fields as named; TF and GY "1", "2"; one-ports one empty name; junctions none
  std::vector<Variable> stored;    ///< of an IC: what each port holds, displacement or momentum; else empty
  SymbolId first_symbol;           ///< see port_variable()
  std::vector<InitialValue> initial;
  std::optional<SwitchLaw> switches;
  std::optional<DiodeLaw> diode;
  std::optional<ContactLaw> contact;
  /// Of a resistor beside diodes, in their modes (see use_own_borders): what is added to its guard, and to its sign.
  ParameterId own_border, share;
  bool stands_in = false;  ///< where another kind stands for a switch (ModePrograms): what its mode is there
  /// Of an Sw in a mode: of the other side's kind, since other switches set already what it would.
  bool idle = false;
  double priority = 0.0;  ///< stores: larger gets integral causality first; ties by the model's order
  std::string about;
  Place place;              ///< of the element's key
  Place coefficient_place;  ///< of coefficient, energy or modulus
};

/// Whether a port of a store holds displacement: each of a C or CC, those of an IC that say so. The others hold
/// momentum.
[[nodiscard]] bool stores_displacement(const Element& element, std::size_t port);
/// Number of ports of a non-junction element.
std::size_t port_count(const Element& element);
/// The symbol of a variable at a port. Every element's symbols exist from the start: a port's effort, flow and, for
/// stores, displacement or momentum stand one after the other, port after port; a junction has one symbol, for what its
/// bonds share.
SymbolId port_variable(const Element& element, std::size_t port, Variable variable);
/// "packet.wall" or "mass": the element and, where it has several, its port.
std::string port_name(const Element& element, std::size_t port);

/// One end of a bond as written.
struct BondEndText {
  ElementId element;
  std::optional<std::uint32_t> port;  ///< none where the text names no port (junctions, one-ports, TF and GY by arrow)
  Place place;
};

struct ModelBond {
  std::string name;  ///< "b1" by position, "left.b1" in a submodel, or as given
  BondEndText from, to;
  Place place;
};

/// What the model says shall happen at the instant at which a condition becomes true: stores and integrals are set.
struct ModelEvent {
  struct Set {
    ElementId element;  ///< none for an integral among the signals
    std::uint32_t port = 0;
    SignalId signal;  ///< none for what an element stores
    ExprId value;     ///< of the instant before
    Place place;      ///< of the value
    Place target_place;
  };
  std::string name;  ///< full name, e.g. "left.bounce"
  ExprId when;       ///< condition
  std::vector<Set> sets;
  double priority = 0.0;  ///< of events at one instant those with the largest come first
  bool at_start = false;  ///< it takes place at the start of a run, too, whatever its condition is there
  SignalId sampled;       ///< then at a start that is a sampling time of this signal only
  Place place;            ///< of the event's key
  Place when_place;
};

/// A column of the trace.
struct Output {
  std::string name;
  ExprId value;
  std::string unit;
  Place place;
  Place unit_place;  ///< of the unit's text, where there is one
};

/// The reference that a scene is held against (bgsim verify).
struct Reference {
  std::string file;  ///< resolved relative to the model's folder
  double relative = 1e-6;
  double absolute = 0.0;  ///< relative and absolute are of the column's largest magnitude and its unit
  double tube = 0.0;      ///< half width of the time tube, in units of t
  std::map<std::string, std::string> columns;  ///< output -> column of the CSV where the names differ
  Place place;
};

struct Scene {
  std::string name;
  std::string about;
  ExprId start, stop;                           ///< over parameters; start may be none (0)
  std::optional<std::size_t> samples;           ///< number of equidistant output times, both ends included
  ExprId interval;                              ///< distance of output times, or none
  std::optional<std::size_t> log_samples;       ///< number of output times that are evenly spaced by their logarithms
  ExprId log_from;                              ///< the first of these, or none (the start)
  std::vector<std::pair<ExprId, Place>> times;  ///< listed output times; empty unless given
  Place start_place, stop_place;                ///< of the values, where given
  Place interval_place;                         ///< of "interval", "samples" or "times"
  Place log_from_place;
  std::map<std::string, std::pair<ExprId, Place>> parameters;  ///< overrides by full name
  std::map<std::string, std::pair<ExprId, Place>> initial;     ///< by state name, e.g. "packet.air.q", "left.x"
  std::vector<std::string> outputs;                            ///< empty: all
  std::optional<double> relative;
  std::optional<double> absolute;
  std::map<std::string, double> absolute_by_state;
  Method method = Method::automatic;
  std::optional<double> step;               ///< length of the steps of a fixed-step method
  std::optional<int> max_order;             ///< of a multistep method
  bool close_zeno = true;                   ///< "zeno": "close"; false: "error"
  bool sequential_impacts = false;          ///< "impacts": "sequential"; false: "simultaneous"
  std::optional<std::uint64_t> max_events;  ///< a run with more events ends
  Place max_events_place;
  Place method_place;  ///< of "method", where given, else of the scene
  std::optional<Reference> reference;
  Place place;
};

/// A whole model. Element, bond, parameter and signal ids are positions in the vectors (file order; a submodel's items
/// stand where its element stands).
struct Model {
  std::shared_ptr<const Sources> sources;
  std::string name, about, source;
  ExprPool pool;
  std::vector<ModelSymbol> symbols;  ///< by SymbolId of the pool
  SymbolId time;
  std::vector<Parameter> parameters;
  std::vector<Signal> signals;
  std::vector<Element> elements;
  std::vector<ModelBond> bonds;
  std::vector<ModelEvent> events;
  std::vector<Output> outputs;
  std::vector<Scene> scenes;
  std::vector<Diagnostic> warnings;
};

/// The full name of a symbol: "x_ref", "left.packet.wall.q", "b3.e".
std::string symbol_name(const Model& model, SymbolId symbol);

/// What is said of a model outside of its files: which files it may name (submodels, data, references), since a model
/// from somebody else may name anything; and what takes effect as if the model's own file said it, of every scene.
struct ReadOptions {
  /// Further folders, beside the model's own, below which the files must lie.
  std::vector<std::string> roots;
  /// Folders in which a submodel is looked for, in this order, that is not beside the file that names it. Files below
  /// them may be named.
  std::vector<std::string> path;
  /// Any file may be named. The command sets this only for --allow-outside; a program's models are its own.
  bool allow_outside = true;
  /// JSON files of parameters and initial values, name -> value or { value, unit, about, source }; later ones go first.
  std::vector<std::string> parameter_files;
  std::optional<std::string> start, stop, interval;  ///< in place of every scene's; expressions over parameters
  std::optional<std::size_t> samples;
  std::vector<std::pair<std::string, std::string>> outputs;  ///< further outputs: name and expression
  /// In place of every scene's outputs: names of outputs or quantities, and the groups "all", "states", "outputs".
  std::vector<std::string> record;
};

/// Reads a model file and the submodels and data files it names.
/// @throws ModelError BG100..BG119 (file, JSON, keys, types, names), BG12x (expressions, data files), BG13x (bonds,
///         submodels, initial values), BG14x (scenes): all problems found, in file order, at most one per cause; after
///         100 of them BG105 tells how many there are.
/// @note Time and memory are linear in the unfolded model. Submodels may nest to any depth; a cycle is an error that
///       names it. A model of 1e6 elements and 1e6 bonds takes a few seconds.
Model read_model(const std::string& path, const ReadOptions& options = {});
/// The same from a text; @p path is used in messages and to find submodels and tables.
Model read_model_text(const std::string& path, std::string text, const ReadOptions& options = {});

/// Numbers for one run: a scene with its overrides worked out.
struct RunInputs {
  std::string scene;
  std::vector<double> parameters;  ///< by ParameterId
  std::vector<double> rounding;    ///< by ParameterId, as of initial values; empty where none are given
  struct Initial {
    ElementId element;  ///< none for an integral among the signals
    std::uint32_t port = 0;
    double value = 0.0;
    std::optional<Place> place;  ///< none when it comes from the command line
    SignalId signal;             ///< none for what an element stores
    double rounding = 0.0;       ///< how far the value can be off by the roundings of its expression
  };
  std::vector<Initial> initial;  ///< only those given, by increasing element and port, then signal; the rest are 0
  double start = 0.0, stop = 0.0;
  OutputTimes output_times;          ///< from start to stop
  std::vector<std::size_t> outputs;  ///< indices into Model::outputs, in order
  double relative = 1e-6;
  std::optional<double> absolute;
  std::map<std::string, double> absolute_by_state;
  Method method = Method::automatic;
  double step = 0.0;  ///< of a fixed-step method; else 0
  int max_order = 0;  ///< of a multistep method; 0: the method's own
  std::optional<Reference> reference;
  bool close_zeno = true;  ///< a contact whose impacts accumulate closes; else the run ends
  /// It does from flights on that are so many times as long as those that can be resolved: more shows what the flights
  /// that are left out do.
  double early_closing = 1.0;
  bool sequential_impacts = false;  ///< impacts of one instant take place one after the other; else at once
  std::uint64_t max_events = 0;     ///< a run with more events ends; 0: no limit
  std::optional<Place> max_events_place;
  std::vector<std::size_t> starting_events;  ///< indices into Model::events: those that take place at the start, too
  std::vector<Diagnostic> warnings;          ///< active elements and the like, which depend on the numbers
};

/// Overrides from the command line.
struct SceneOverrides {
  std::vector<std::string> set;  ///< "NAME=EXPR": a parameter, or a state's initial value ("mass.p=0.1")
  std::optional<double> relative, absolute;
  std::optional<Method> method;  ///< a method goes before the scene's together with the scene's step and order
  std::optional<double> step;
  std::optional<int> max_order;
};

/// Works out a scene: parameters in order of dependence (the scene's overrides, then those of the command line), times,
/// initial values.
/// @param name  of the scene; empty for the first.
/// @throws ModelError BG140 no such scene, BG141 --set not understood, BG12x in its expression, BG132 parameter cycle,
///         BG142 no finite number, BG143 stop before start, BG144 output times, BG145 capacitance or inertance not
///         positive, BG146 tolerances.
/// @note Time linear in the model.
RunInputs prepare_scene(const Model& model, const std::string& name, const SceneOverrides& overrides = {});

/// The model with what @p overrides set written into the scene @p name.
/// @throws ModelError as prepare_scene.
Model with_overrides(const Model& model, const std::string& name, const SceneOverrides& overrides);

}  // namespace bgsim
