/// Which ideal diodes conduct.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/at_border.hpp"
#include "run/kept_evaluators.hpp"

namespace bgsim {

/// What diodes see of the rest of a model: the model with each of them as a resistor in series with a source,
/// e = r f + s. That does not fix what is an effort and what a flow, so one program serves for all of their modes.
struct DiodeNetwork {
  /// Integrals have been added: by diode s, and by border its place, with rate 0; then by diode f, f' and f'' as
  /// rates, and by border its guard and two derivatives of that.
  Program program;
  std::size_t first_signal = 0;          ///< the first of them
  std::vector<ParameterId> resistances;  ///< by diode: r
  std::vector<bool> out;                 ///< by diode: passes what flows out of it
  std::vector<std::string> names;
  std::vector<NetworkBorder> borders;
  /// By diode: of a contact its displacement; else none. A contact's flow is counted from that of its wall.
  std::vector<SignalId> displacements;
  /// Integrals behind those of the flows: for each contact one with the room that it has left as its rate, and one with
  /// the restitution at the present closing speed (0 where it does not close).
  std::size_t contacts = 0;
};

/// A mode in which contacts that are closed can have a speed of separation, for the jump of an impact.
struct ImpactProgram {
  Program program;                 ///< integrals have been added: by contact the impulse that it takes
  std::size_t first_signal = 0;    ///< the first of them
  std::vector<ParameterId> kicks;  ///< by contact: its speed of separation
};

/// Of a diode or contact, in the order of the model.
struct DiodeState {
  bool conducts = false;
  std::optional<bool> may_begin;    ///< its fire holds, or it has none; not known at the start of a run
  bool pinned = false;              ///< "conducts" without a flow, only since nothing else determines its effort
  double effort = 0.0, flow = 0.0;  ///< where they are known, else 0
  bool touches = false;             ///< a contact is closed, or has come to its gap
  bool sticks = false;              ///< a contact does not rebound here
};

/// Through which resistances a network is seen, kept from one time to the next. Empty: not looked for yet.
struct DiodeSight {
  std::vector<double> resistances;  ///< by diode: r
  std::vector<double> slopes;       ///< by diode, then order: of its flow and two derivatives by its source, magnitudes
};

/// Which contacts that close at one instant take impulses in one impact.
enum class ImpactOf {
  all,      ///< all that do not separate, with the rebound of each
  fastest,  ///< the one that closes fastest, as if the others did not touch; of equally fast ones the first
  rest,     ///< all that touch, without a rebound: the limit of infinitely many impacts
};

struct DiodeSides {
  std::vector<DiodeState> diodes;
  std::vector<bool> at_gap;  ///< by diode: a contact without room, though it may not have come to its gap just now
  /// By diode: whether what it has at this side is 0 as far as the series reach, so that they do not say which way it
  /// goes. Each store that conducting diodes tie to others takes an order from what is known.
  std::vector<bool> undecided;
  std::vector<double> flow_off, effort_off;      ///< how far each one's flow and effort can be off at this point
  std::vector<double> flow_error, effort_error;  ///< the same by the resolution of states and rounding alone
  std::vector<double> room;                      ///< by diode: of a contact that touches what it has left; else 0
  /// By diode: how far a contact that leaves its wall goes before what pushes it brings it back; else 0.
  std::vector<double> flight;
  std::vector<double> returns;       ///< by diode: after what time; else 0
  std::vector<double> least_flight;  ///< by diode: of a contact, a shorter one is lost in rounding
  /// By diode: a contact that takes an impulse leaves its wall at this speed, 0 or more. Empty where none takes one.
  std::vector<std::optional<double>> kick;
  std::vector<double> closing;      ///< by diode: speed at which such a contact closes
  std::vector<AtBorder> at_border;  ///< resistors whose laws are at their borders, as the sides were found
  std::optional<Diagnostic> failure;
  bool final = false;  ///< other sides would not help
};

/// The sides of all diodes an instant after @p t, with the stores as they are: 0 <= f, e <= e0, one of them at its
/// border, for all small times. Stores and sources change little in a small time h, so flows and efforts are series in
/// h: a coil's current that is cut off makes an effort of order 1/h, a diode that is just reached has a flow of order
/// h. One linear complementarity problem over such series says which diodes take over a current, which ones are tied to
/// stores with a jump, and which way those go whose flow and effort are both 0. Where laws are not linear it is
/// repeated at the solution found.
///
/// A contact that does not touch has no effort and any flow. One that touches is a diode on the level of speeds; where
/// it closes and its speed hangs on stores alone, the speed of separation is to be at least the restitution times the
/// closing speed (Newton's rule for all contacts at once, Moreau). Those with an effort of order 1/h take impulses. A
/// contact that separates as others close is away: what the impact makes it close at is another impact.
///
/// Laws that may be held at their border (dry friction) are part of the problem, since what holds them and what the
/// diodes carry depend on each other: 0 <= a <= 1 is the place of a law between its two sides, 0 where the guard falls
/// and 1 where it rises.
///
/// Where a mode leaves a current or an effort between ideal elements undetermined (two diodes in series that block, in
/// parallel that conduct), the sides are such that all are determined: one of them "conducts" with no flow, or "blocks"
/// with no effort.
///
/// Fails with BG622 where no sides are possible.
/// @param resolution  of a state: by how much it may be off
/// @param sight       of the network; looked for where it is empty, or the slopes of its laws have changed
/// @param span        duration of the scene
/// @param impact      of which contacts, where some close
DiodeSides diode_sides(const DiodeNetwork& network, const std::vector<double>& parameters, double t,
                       const Stored& stored, const std::function<double(const StateInfo&)>& resolution,
                       std::vector<DiodeState> before, KeptEvaluators& evaluators, DiodeSight& sight, double span,
                       ImpactOf impact = ImpactOf::all);

}  // namespace bgsim
