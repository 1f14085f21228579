#include "read/other_keys.hpp"

#include <algorithm>
#include <array>

#include "base/text.hpp"

namespace bgsim {
namespace {

struct Key {
  std::string_view other;  ///< names that mean one thing, with a space on each side
  const char* help;
};

/// The help of the first row that lists the word, as it is written or in small letters.
template <std::size_t N>
std::string help_for(const std::array<Key, N>& keys, std::string_view word) {
  if (word.empty() || word.find(' ') != std::string_view::npos) return {};
  for (const std::string& text : {" " + std::string(word) + " ", " " + lower_case(word) + " "})
    for (const Key& key : keys)
      if (key.other.find(text) != std::string_view::npos) return key.help;
  return {};
}

constexpr std::array kResistorKeys{
    Key{" damping d b c r R B D damper damping_coefficient damping_constant friction viscosity viscous_friction drag "
        "ohm "
        "ohms impedance coefficient ",
        "for e = b f write \"resistance\": \"b\""},
    Key{" conductance g G admittance mobility ", "for f = G e write \"law\": \"f = G*e\", or \"resistance\": \"1/G\""},
};
constexpr std::array kCapacitorKeys{
    Key{" stiffness k K c_spring spring_constant spring_rate spring rate spring_stiffness elastance elasticity "
        "bulk_modulus ",
        "for e = k q write \"law\": \"e = k*q\", or \"capacitance\": \"1/k\""},
    Key{" compliance c C capacity farad farads flexibility accumulator ",
        "a C has e = q/C: write it as \"capacitance\""},
};
constexpr std::array kInertiaKeys{
    Key{" mass m M inertia j J moment_of_inertia inductance l L inductivity henry i I inertness inertia_moment ",
        "an I has f = p/I: write it as \"inertance\""},
};
constexpr std::array kStoreInitialKeys{
    Key{" init ic initial_condition initial_conditions initial_value initialvalue start state state0 x0 x_0 q0 q_0 p0 "
        "p_0 v0 i0 u0 q p ",
        "the start of what is stored is \"initial\": { \"q\": 0 } at a C, { \"p\": 0 } at an I"},
};
constexpr std::array kEffortKeys{
    Key{" voltage force torque pressure temperature u U v V e E F f tau T P p amplitude source moment ",
        "a source of effort has the key \"effort\" in every domain"},
    Key{" flow current velocity speed ", "Se gives an effort; a source of flow is of kind \"Sf\" or \"MSf\""},
};
constexpr std::array kFlowKeys{
    Key{" current velocity speed flow_rate angular_velocity omega i I v V f F q Q w amplitude source ",
        "a source of flow has the key \"flow\" in every domain"},
    Key{" effort voltage force torque pressure ", "Sf gives a flow; a source of effort is of kind \"Se\" or \"MSe\""},
};
constexpr std::array kSwitchKeys{
    Key{" condition gate control signal state on when if fire command ",
        "an Sw is closed while its condition holds: \"closed\": \"t >= 0.1\""},
    Key{" off opened open_when ", "write \"closed\": \"not (...)\", or \"close\" and \"open\" for a hysteresis"},
    Key{" lock engaged engage brake clutch ", "an Sw is rigid while \"locked\" holds: \"locked\": \"t >= 0.1\""},
    Key{" resistance Ron r_on ron R ", "an ideal switch has no resistance: put an R beside it"},
    Key{" start initially ",
        "the side at the start is \"initial\": \"open\" or \"closed\", with \"close\" and \"open\" only"},
};
constexpr std::array kDiodeKeys{
    Key{" forward_voltage forward voltage drop vf Vf v_f Vf0 effort e0 knee ",
        "the effort at which a D begins to conduct is its \"threshold\""},
    Key{" direction orientation way reverse reversed polarity from to anode cathode ",
        "a D conducts what flows into it; one the other way round has \"passes\": \"out\""},
    Key{" gate trigger on close closed condition firing fired ",
        "a thyristor is a D with a condition: \"fire\": \"mod(t, T) > t_fire\""},
    Key{" resistance Ron r_on ron R law ",
        "an ideal diode has no resistance: put an R beside it, or write an R with a law"},
};
constexpr std::array kContactKeys{
    Key{" clearance distance limit stop position play backlash wall q_max qmax x_max threshold ",
        "a contact closes where its displacement q comes to its \"gap\""},
    Key{" e cor COR epsilon bounce bounciness coefficient_of_restitution elasticity ",
        "the speed after an impact, of that before, is the \"restitution\", 0 to 1"},
    Key{" stiffness damping k d c spring law ",
        "a contact is rigid: one that gives way is a C with a law such as \"e = k*max(q, 0)\""},
    Key{" q q0 x0 ", "the displacement at the start is \"initial\": { \"q\": ... }"},
};
constexpr std::array kTransformerKeys{
    Key{" ratio n N m r gain factor transmission transmission_ratio gear gear_ratio turns turns_ratio lever area "
        "radius ",
        "a TF has e1 = n e2 and f2 = n f1: write n as \"modulus\""},
};
constexpr std::array kGyratorKeys{
    Key{" ratio r k K km Km kt Kt ke gain factor gyration gyrator_ratio motor_constant torque_constant ",
        "a GY has e1 = r f2 and e2 = r f1: write r as \"modulus\""},
};
constexpr std::array kJunctionKeys{
    Key{" ports bonds connections elements ",
        "a junction takes as many bonds as name it; they are listed in \"bonds\""},
};
constexpr std::array kElementKeys{
    Key{" type class component model ", "the kind of an element is its \"kind\""},
    Key{" name id label ", "the name of an element is its key in \"elements\""},
    Key{" description comment comments remark note notes doc title caption ", "remarks go into \"about\""},
    Key{" unit units ",
        "units belong to parameters: \"parameters\": { \"m\": { \"value\": 2, \"unit\": \"kg\" } }, and "
        "the element names the parameter"},
    Key{" causality stroke causal ",
        "leave it out: strokes are assigned by bgsim; \"priority\" prefers one store to "
        "another"},
    Key{" from to connected connect ", "connections are listed in \"bonds\": { \"from\": \"a\", \"to\": \"b\" }"},
};
/// Words for the one value that an element has; the help names the keys.
constexpr std::string_view kValueWords =
    " signal input value val parameter parameters param params constant gain coefficient expr expression formula "
    "equation equations "
    "function relation constitutive modulus ratio resistance capacitance inertance effort flow law laws energy ";

constexpr std::array kModelKeys{
    Key{" parameter params param constants constant variables_const ", "constants are \"parameters\""},
    Key{" nodes components element parts blocks ", "they are \"elements\""},
    Key{" edges connections connection links connect wires bond lines ",
        "they are \"bonds\": an array of { \"from\", "
        "\"to\" }"},
    Key{" simulation simulations simulate experiment experiments scene run runs settings solver options ",
        "times and tolerances of a run are a scene: \"scenes\": { \"run\": { \"stop\": 1 } }"},
    Key{" stop start samples interval relative absolute method step tstop t_end tolerance ",
        "it belongs to a scene: \"scenes\": { \"run\": { \"stop\": 1 } }"},
    Key{" equations equation variables functions inputs signal control algorithm ",
        "what is computed at each instant are \"signals\": name to expression"},
    Key{" output results record plot plots observe observables ",
        "columns of the trace are \"outputs\": name to expression"},
    Key{" initial initials initial_conditions ic ",
        "initial values belong to the stores, \"initial\": { \"q\": 0 } in the element, or to a scene"},
    Key{" submodels includes include imports import subsystems library ",
        "submodels are \"types\": name to file; their names are then kinds of elements"},
    Key{" junctions sources resistors stores ", "junctions and all others are \"elements\" with a \"kind\""},
    Key{" version format schema ", "the number of the format is \"bgsim\": 1"},
    Key{" description comment comments doc title notes ", "remarks go into \"about\""},
    Key{" author license reference ", "where a model comes from goes into \"source\""},
    Key{" units ", "units belong to parameters, signals and outputs, each with its \"unit\""},
};
constexpr std::array kBondKeys{
    Key{" source src tail start a begin head_from out ", "the half-arrow points \"from\" one element \"to\" another"},
    Key{" target dst dest destination head end b sink in ",
        "the half-arrow points \"from\" one element \"to\" another"},
    Key{" causality stroke causal ", "leave it out: strokes are assigned by bgsim"},
    Key{" effort flow e f ", "leave it out: the bond's variables are b1.e and b1.f, with its name before the dot"},
    Key{" id label ", "the name of a bond is its \"name\""},
    Key{" description comment remark ", "remarks go into \"about\""},
    Key{" elements between nodes ends ", "write { \"from\": \"a\", \"to\": \"b\" }"},
};
constexpr std::array kSceneKeys{
    Key{" tstop t_stop stoptime stop_time tend t_end tfinal t_final t1 end duration until final_time tmax t_max "
        "length ",
        "the time at which a scene ends is \"stop\""},
    Key{" tstart t_start starttime start_time t0 begin from ", "the time at which a scene begins is \"start\""},
    Key{" dt h stepsize step_size time_step timestep max_step maxstep output_interval sample_time ts ",
        "the distance of output times is \"interval\"; the length of steps of euler, rk4, ... is \"step\""},
    Key{" points n n_points npoints number_of_points numberofintervals intervals n_samples nsamples steps n_steps ",
        "the number of output times is \"samples\""},
    Key{" solver integrator algorithm integration ", "the integrator is \"method\": \"auto\", \"bdf\", \"rk4\", ..."},
    Key{" tolerance tol rtol reltol rel_tol relative_tolerance accuracy ", "the relative tolerance is \"relative\""},
    Key{" atol abstol abs_tol absolute_tolerance ", "the absolute tolerance is \"absolute\""},
    Key{" parameter params param set overrides values constants ", "values for a scene are its \"parameters\""},
    Key{" init ic initial_conditions initials x0 state states ",
        "the start of states is \"initial\": { \"mass.p\": 0 }"},
    Key{" output record columns variables plot ", "the columns of a scene are \"outputs\": a list of their names"},
    Key{" description comment title ", "remarks go into \"about\""},
    Key{" name ", "the name of a scene is its key in \"scenes\""},
    Key{" signals inputs elements bonds ",
        "a scene sets parameters and initial values; write the signal with a parameter that the scene sets"},
};
constexpr std::array kQuantityKeys{
    Key{" val expr expression default equation formula number nominal ", "its value is \"value\""},
    Key{" units dimension ", "its unit is \"unit\""},
    Key{" description comment label doc note name ", "remarks go into \"about\""},
    Key{" min max bounds range ", "bounds are not checked: leave them out, or write them into \"about\""},
    Key{" type ", "leave it out: every value is a number or an expression"},
};

constexpr std::array kKinds{
    Key{" resistor resistance res damper damping friction dissipator dissipative dashpot r: rs valve orifice "
        "restriction ",
        "a dissipative element is of kind \"R\""},
    Key{" capacitor capacitance cap spring compliance accumulator tank volume storage c: ",
        "a store of displacement (spring, capacitor, tank) is of kind \"C\""},
    Key{" inductor inductance inertia inertance mass body rotor flywheel coil i: l ",
        "a store of momentum (mass, inductor) is of kind \"I\""},
    Key{" transformer tr lever gear gearbox gear_ratio piston tf: rack ",
        "a transformer (lever, gear, piston) is of kind \"TF\""},
    Key{" gyrator motor dcmotor dc_motor gy: transducer ", "a gyrator (motor) is of kind \"GY\""},
    Key{" effort_source effortsource source_of_effort voltage_source voltagesource voltage force torque pressure "
        "pressure_source battery gravity v se: source_effort ",
        "a source of effort (voltage, force, pressure) is of kind \"Se\"; one that follows a signal of states is "
        "\"MSe\""},
    Key{" flow_source flowsource source_of_flow current_source currentsource current velocity pump speed sf: "
        "source_flow ",
        "a source of flow (current, velocity, pump) is of kind \"Sf\"; one that follows a signal of states is \"MSf\""},
    Key{" j0 junction0 0-junction 0junction junction_0 0_junction zero zerojunction zero_junction zero-junction "
        "p-junction "
        "parallel common_effort node j_0 e-junction 0j ",
        "a junction of one effort is of kind \"0\""},
    Key{" j1 junction1 1-junction 1junction junction_1 1_junction one onejunction one_junction one-junction s-junction "
        "series common_flow mesh j_1 f-junction 1j ",
        "a junction of one flow is of kind \"1\""},
    Key{" junction j ", "a junction of one effort is of kind \"0\", of one flow \"1\""},
    Key{" detector sensor ", "a detector of effort is of kind \"De\", one of flow of kind \"Df\""},
    Key{" effort_sensor effort_detector effortsensor voltmeter force_sensor forcesensor pressure_sensor "
        "voltage_sensor ",
        "a detector of effort is of kind \"De\", at a 0-junction"},
    Key{" flow_sensor flow_detector flowsensor ammeter tachometer velocity_sensor velocitysensor speed_sensor "
        "current_sensor ",
        "a detector of flow is of kind \"Df\", at a 1-junction"},
    Key{" ss source_sensor ", "a port to the outside is a junction in \"ports\""},
    Key{" diode d thyristor ",
        "an ideal diode is a \"D\"; with its characteristic it is an \"R\" with a law such as \"f = Is*(exp(e/Vt) - "
        "1)\""},
    Key{" sw switch x0 x1 clutch brake breaker ",
        "an ideal switch is an \"Sw\" with a condition: \"closed\" or \"locked\""},
    Key{" ce re chemical ", "write it as a \"C\" or \"R\" with its \"law\""},
    Key{" rs_thermal mrs rst ", "heat is not followed by itself: write an \"RR\" with a thermal port"},
    Key{" mcc mii mrr ", "fields may use any variable: leave the M out"},
    Key{" signal gain integrator sum constant block pid controller ",
        "what has no power is written under \"signals\", as an expression"},
};

constexpr std::array kMethods{
    Key{" ode45 rk45 dopri5 dp5 dormandprince dormand-prince tsit5 ", "erk5"},
    Key{" ode23 rk23 bs3 bogackishampine ", "erk3"},
    Key{" ode78 ode89 dop853 rk78 ", "erk8"},
    Key{" ode15s lsoda vode cvode gear stiff ndf fbdf ", "bdf"},
    Key{" ode23s ode23t ode23tb trbdf2 esdirk esdirk23a ", "dirk3"},
    Key{" rodas rodas4 rodas5 rodas5pr rosenbrock ", "rodas5p"},
    Key{" radau5 radauiia radau_iia radauiia5 radau-iia ", "radau"},
    Key{" radauiia9 radau_iia9 radauiia_9 ", "radau9"},
    Key{" radauiia13 radau_iia13 radauiia_13 ", "radau13"},
    Key{" ode113 adams-bashforth abm ", "adams"},
    Key{" dassl daskr ode15i daspk ", "ida"},
    Key{" rk runge-kutta rungekutta rungekutta4 runge_kutta ode4 ", "rk4"},
    Key{" forward_euler forwardeuler explicit_euler expliciteuler ode1 ", "euler"},
    Key{" backward_euler backwardeuler impliciteuler ", "implicit_euler"},
    Key{" leapfrog symplectic stoermer-verlet velocity_verlet ", "verlet"},
    Key{" heun ode2 midpoint ", "erk2"},
    Key{" default automatic variable ", "auto"},
};

std::string own_value_key(ElementKind kind) {
  switch (kind) {
    case ElementKind::effort_source:
      return "an effort source says it as \"effort\"";
    case ElementKind::flow_source:
      return "a flow source says it as \"flow\"";
    case ElementKind::open_switch:
    case ElementKind::closed_switch:
      return "an Sw has a condition: \"closed\", \"locked\", or \"close\" and \"open\"";
    case ElementKind::blocking_diode:
    case ElementKind::conducting_diode:
      return "a D has no law of its own; the effort at which it begins to conduct is its \"threshold\"";
    case ElementKind::free_contact:
    case ElementKind::closed_contact:
      return "a contact has a \"gap\", the displacement at which it closes, and a \"restitution\"";
    case ElementKind::resistor:
      return "an R has a \"resistance\" (e = R f) or a \"law\" such as \"f = G*e\"";
    case ElementKind::capacitor:
      return "a C has a \"capacitance\" (e = q/C) or a \"law\" such as \"e = k*q\"";
    case ElementKind::inertia:
      return "an I has an \"inertance\" (f = p/I) or a \"law\" such as \"f = p/m\"";
    case ElementKind::transformer:
      return "a TF has a \"modulus\" n: e1 = n e2, f2 = n f1";
    case ElementKind::gyrator:
      return "a GY has a \"modulus\" r: e1 = r f2, e2 = r f1";
    case ElementKind::c_field:
    case ElementKind::i_field:
    case ElementKind::ic_field:
      return "a field has an \"energy\", or \"laws\": one equation for each port";
    case ElementKind::r_field:
      return "an RR has \"laws\": one equation for each port";
    case ElementKind::effort_detector:
    case ElementKind::flow_detector:
    case ElementKind::zero_junction:
    case ElementKind::one_junction:
      break;
  }
  return {};
}

std::string instead_of_own_key(ElementKind kind, std::string_view key) {
  switch (kind) {
    case ElementKind::effort_source:
      return help_for(kEffortKeys, key);
    case ElementKind::flow_source:
      return help_for(kFlowKeys, key);
    case ElementKind::open_switch:
    case ElementKind::closed_switch:
      return help_for(kSwitchKeys, key);
    case ElementKind::blocking_diode:
    case ElementKind::conducting_diode:
      return help_for(kDiodeKeys, key);
    case ElementKind::free_contact:
    case ElementKind::closed_contact:
      return help_for(kContactKeys, key);
    case ElementKind::resistor:
      return help_for(kResistorKeys, key);
    case ElementKind::capacitor:
      return help_for(kCapacitorKeys, key);
    case ElementKind::inertia:
      return help_for(kInertiaKeys, key);
    case ElementKind::transformer:
      return help_for(kTransformerKeys, key);
    case ElementKind::gyrator:
      return help_for(kGyratorKeys, key);
    case ElementKind::zero_junction:
    case ElementKind::one_junction:
      return help_for(kJunctionKeys, key);
    case ElementKind::effort_detector:
    case ElementKind::flow_detector:
    case ElementKind::c_field:
    case ElementKind::i_field:
    case ElementKind::ic_field:
    case ElementKind::r_field:
      break;
  }
  return {};
}

}  // namespace

std::string instead_of_key(ElementKind kind, std::string_view key) {
  if (std::string own = instead_of_own_key(kind, key); !own.empty()) return own;
  if (is_store(kind))
    if (std::string own = help_for(kStoreInitialKeys, key); !own.empty()) return own;
  if (kValueWords.find(" " + lower_case(key) + " ") != std::string_view::npos)
    if (std::string own = own_value_key(kind); !own.empty()) return own;
  return help_for(kElementKeys, key);
}

std::string instead_of_key(std::string_view object, std::string_view key) {
  if (object == "a model") return help_for(kModelKeys, key);
  if (object == "a bond") return help_for(kBondKeys, key);
  if (object == "a scene") return help_for(kSceneKeys, key);
  if (object == "a parameter" || object == "a signal" || object == "an output") return help_for(kQuantityKeys, key);
  return {};
}

std::string instead_of_method(std::string_view method) {
  const std::string here = help_for(kMethods, method);
  return here.empty() ? here : "for " + std::string(method) + " write " + here + "; ";
}

std::string instead_of_kind(std::string_view kind) { return help_for(kKinds, kind); }

}  // namespace bgsim
