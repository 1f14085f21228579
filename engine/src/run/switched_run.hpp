/// A switched run: what it knows from stretch to stretch. switched.cpp has its loop, switched_modes.cpp the jumps and
/// the way from one mode to the next, switched_diodes.cpp and switched_contacts.cpp the sides and impulses of these,
/// switched_sums.cpp the report, switched_snapshot.cpp what a snapshot holds.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bgsim/text.hpp"
#include "run/contacts.hpp"
#include "run/event_log.hpp"
#include "run/jump.hpp"
#include "run/kept_evaluators.hpp"
#include "run/mode_variation.hpp"
#include "run/run.hpp"
#include "run/stored.hpp"
#include "run/switched.hpp"
#include "run/watch/headway.hpp"

namespace bgsim {

class SwitchedRun {
 public:
  SwitchedRun(const SwitchedPrograms& programs, const SwitchedStart& start, const RunInputs& inputs,
              const SimulateOptions& options, const Clock& clock)
      : program_of_(programs.program_of),
        network_of_(programs.network_of),
        impact_of_(programs.impact_of),
        delayed_(programs.delayed),
        inputs_(inputs),
        options_(options),
        clock_(clock),
        start_mode_(start.mode),
        mode_(start.mode),
        is_diode_(start.diodes),
        stored_(start.stored),
        log_(options, inputs),
        logged_(start.mode),
        headway_(inputs.stop),
        begin_(clock()),
        diodes_(static_cast<std::size_t>(std::count(start.diodes.begin(), start.diodes.end(), true))),
        contacts_(diodes_.size()),
        rests_(diodes_.size()),
        rest_moves_(diodes_.size(), 0.0) {
    stored_.t = inputs.start;
    if (programs.variation != nullptr) variation_.emplace(*programs.variation, inputs);
    if (!diodes_.empty()) sights_[mode_of_switches()] = start.sight;
  }

  RunResult execute();

 private:
  static constexpr double kRounding = 1e-9;  ///< of the energies that a jump's loss is the difference of

  // --- one stretch

  /// From the present instant on in the present mode; false if the run ends with it.
  bool stretch();

  /// The stretch of the present mode, from the present instant on or, where @p resume is not empty, from that snapshot.
  bool stretch_in(const Program& in_mode, const std::string& resume);

  /// The sensitivities where the present mode begins.
  bool vary_into(const Program& program);
  /// Where @p run leaves a mode: what the sensitivities are to go on from.
  bool vary_out_of(const Program& program, Run& run);

  /// After what time the first of the contacts that have just left their wall is back; 0: none is known to be.
  [[nodiscard]] double soonest_return() const;

  /// The program of the present instant's mode, with the stores as they are after the jump into it.
  const Program* enter_mode();

  /// The sides that all are on once the first mode is found: what is found for diodes then is no change. Of a run
  /// that goes on from one without a log, at its snapshot @p t.
  void log_start(const Model& model, double t);

  /// Switches, or diodes and contacts, that are on another side than the log knows.
  /// @param which  whether it is asked for, of a diode or contact (true) or another switch.
  void log_sides(const Model& model, const std::function<bool(bool)>& which);

  /// Stores that jump from what is stored to the states @p x.
  void log_jump(Evaluator& evaluator, const std::vector<double>& x, std::optional<double> loss);

  // --- snapshots

  /// Goes on from the snapshot that the options name. False if the run ends with the stretch that it lies in.
  /// @throws ModelError BG171.
  bool resume();
  /// Of model and scene.
  [[nodiscard]] std::string own_fingerprint() const;
  [[nodiscard]] nlohmann::ordered_json state();
  /// Within a stretch. @param stretch  its own snapshot.
  void offer_stretch(double t, const std::string& stretch);
  /// Where the mode changed as the scene ended, and no stretch began: from the change on.
  void offer_end();
  void offer(double t, nlohmann::ordered_json state);

  template <class Archive>
  void carry(Archive& archive);
  template <class Archive, class Set>
  static void carry_set(Archive& archive, const char* name, Set& set);

  // --- contacts

  [[nodiscard]] std::vector<ElementId> diode_elements(const Model& model) const;

  /// Impulses of contacts that close, with the speeds of their rebound.
  bool take_impact();

  void log_impacts(const std::vector<ElementId>& elements, const Model& model, const std::vector<double>& impulses,
                   std::optional<double> loss);

  /// Whether a contact opens, or rebounds not much further than the tolerance of its displacement. Multistep methods
  /// begin with order 1 and steps that suit the tolerance, and lose such a flight; one-step methods do not.
  [[nodiscard]] bool flies_short(const Program& program) const;

  /// Puts the displacements of contacts that touch to their gaps.
  void close_rooms(const DiodeNetwork& network, const std::vector<double>& room);

  /// Where contacts leave their sides. False where their impacts must not accumulate, and do.
  bool look_at_contacts(const Program& program);

  // --- diodes

  /// What a run saw of the diodes where it left its mode.
  void take_diodes(const std::vector<double>& values);

  /// Puts the diodes on the sides that the circuit makes them.
  bool settle_diodes();
  /// The sides of the switches; all diodes at none.
  [[nodiscard]] Mode mode_of_switches() const;

  /// Of which contacts the next impact of this instant is.
  [[nodiscard]] ImpactOf impact_of() const;

  /// Counts an impact of this instant. True where closing speeds have become nothing beside the first, or impacts have
  /// no end: then the sides are to be found again, for what is left of all.
  bool ends_sequence(const DiodeSides& sides);
  /// Whether the series of another contact ends with that of this one.
  [[nodiscard]] bool ends_with_others(const Program& program, std::size_t contact, const Accumulation& series) const;

  /// Whether sides can be found by trying: that knows no restitution, and helps nobody whose model is at fault.
  [[nodiscard]] bool may_try(const DiodeNetwork& network, const DiodeSides& sides) const;
  /// Contacts that do not touch stay free.
  [[nodiscard]] std::vector<bool> may_be_tried(const DiodeNetwork& network) const;

  void put_diodes();

  /// Where no linear problem says on which sides some diodes are. False where none are possible.
  bool try_sides(const std::function<double(const StateInfo&)>& resolution, const std::vector<bool>& free);

  /// What the stores hold after a jump.
  bool store_jumped(const Program& program, const std::vector<double>& parameters, const std::vector<double>& x);

  // --- errors of outputs

  /// The jump of the exact solution, beside that of the run.
  void jump_exactly(Evaluator& evaluator);
  /// The same as store_jumped().
  void store_exactly(Evaluator& evaluator);
  /// What the states of a mode are wrong by where it begins.
  void hand_errors(const Program& program, Run& run);
  void take_errors(const Program& program, Run& run, const RunResult& part);
  /// No estimate from here on. @param possible  false: of models like this one there is none.
  void lose_errors(const std::string& why, bool possible);

  /// Outputs that depend on a part that no equation of this mode determines (see put_shares).
  [[nodiscard]] std::vector<std::string> shared_outputs(const Program& program);
  /// By how much the border of a contact is moved that opens without a speed: what has just begun to push it is
  /// rounding at first, and turns as it likes. A small part of the tolerance of the displacement.
  [[nodiscard]] double lift_off_band(std::size_t i, const Element& contact) const;
  /// A flow or effort that is 0, or comes from 0, may be beyond its border by rounding: by so much the border is moved.
  /// False if a value is farther beyond: with a failure, or, if `try_others_`, without.
  /// The flow up to which a thyristor that is not fired has ended, in the mode that begins.
  [[nodiscard]] double holding_flow(std::size_t i, double flow) const;
  /// @param shared  laws that have the parts that the sides were found with, where the mode has no equation for these
  bool hold_bands(const Program& program, const std::vector<AtBorder>& shared);

  /// Takes sides that the graph allows in place of those that it has just refused. False if there are none.
  bool try_allowed();
  /// Where the sides that were found do not hold in their mode, those that tried_sides() finds, once an instant. False
  /// with a failure if there are none.
  bool hold_or_try(const Program& program, bool& tried);

  /// What a state is known to.
  [[nodiscard]] double resolution_of(const StateInfo& state) const;

  /// By value of Evaluator::diodes(): what rounding of the states, the time and all operations can have made of it.
  std::vector<double> diode_rounding(Evaluator& evaluator, Branch& branch) const;

  // --- the program of a mode, and the jump into it

  const Program* program_here();
  /// By switch: contacts that are closed, though their impacts have not ended yet; empty: none.
  [[nodiscard]] Mode settling() const;
  /// Those that the present stretch does not need.
  void forget_rests();
  void put_rests(const Model& model);

  void note_indefinite(const Program& program);
  [[nodiscard]] Diagnostic not_allowed(const ModelError& error) const;

  [[nodiscard]] std::string mode_words() const { return names_ ? mode_text(*names_, mode_) : "the first one"; }

  /// What a jump may seem to create: rounding, of what it moves and of what the run has moved.
  [[nodiscard]] double energy_of_rounding(const Jump& jump) const;
  /// What the stores hold as the mode begins.
  bool jump_into_mode(const Program& program, bool& moved);

  /// A store whose content vanishes at once, with nothing that takes it up.
  void note_lone_jumps(const Jump& jump);
  [[nodiscard]] SimulateOptions options_here();

  [[nodiscard]] RunInputs inputs_here(const Program& program);

  // --- from mode to mode

  /// Where some switches leave their sides. False if that leads nowhere.
  bool change_mode(const std::vector<double>& leaving, const Program& program);

  /// A mode that comes back within one instant, with the stores as they were when it was left; or a thousand changes in
  /// one instant.
  bool runs_in_circles(const Program& program);

  [[nodiscard]] bool same_values(const std::vector<RunInputs::Initial>& values) const;

  /// A hundred changes in a row, on average less than 1e-9 of the scene apart: as with other events, an end is not in
  /// sight.
  bool chatters(const Program& program);

  /// At the pace that the stretches keep the run takes longer than a run may.
  bool takes_too_long();

  [[nodiscard]] static std::optional<Place> place_of_switches(const Program& program);

  bool fail(Diagnostic diagnostic);

  // --- sums

  using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
  template <class Archive>
  static void carry_map(Archive& archive, const char* name, std::map<Key, double>& map);
  static Key key(const StateInfo& state) { return {state.element.value, state.port, state.signal.value}; }
  [[nodiscard]] std::vector<double> scales(const Program& program) const;

  /// A stretch's result to the whole run's.
  void add(const RunResult& part);

  /// Where a loop has one solution, it is named once, and not again wherever a mode begins.
  [[nodiscard]] bool solved_before(const std::string& note) const;

  /// A contact that opens without a speed is near its gap for a while: nearer than what can be decided there.
  [[nodiscard]] bool of_lift_off(const std::string& note) const;

  void add_energy(const EnergyAudit& own);

  /// Wall time outside of stretches: modes derived, sides found, jumps.
  void add_mode_seconds();
  void finish();

  struct Departure {
    Mode mode;
    std::vector<RunInputs::Initial> stored;
    template <class Archive>
    void carry(Archive& archive);
  };

  struct Seen {
    Mode switches;
    DiodeSight sight;
    template <class Archive>
    void carry(Archive& archive);
  };

  const ProgramOfMode& program_of_;
  const NetworkOfMode& network_of_;
  const ImpactOfMode& impact_of_;
  const DelayTables& delayed_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  const Clock& clock_;
  const Mode start_mode_;
  Mode mode_;
  std::vector<bool> is_diode_;  ///< by switch
  Stored stored_;               ///< where the last stretch ended
  EventLog log_;
  Mode logged_;  ///< the mode that the log knows
  bool logged_start_ = false;
  bool try_others_ = false;  ///< sides that do not hold are no failure yet
  Headway headway_;
  double begin_;
  double asked_ = 0.0;  ///< seconds since then at which the caller was asked last
  std::shared_ptr<const Model> names_;
  RunResult result_;
  std::optional<double> last_row_, earlier_row_;   ///< times of the last row, and of the last before this stretch
  std::uint64_t steps_ = 0, next_snapshot_ = 0;    ///< of all stretches before the present one
  std::optional<nlohmann::ordered_json> at_stop_;  ///< the state before a stretch that begins where the scene ends
  bool snapshot_given_ = false;                    ///< in the present stretch
  std::optional<DelayMemory> delays_;
  EventMemory events_;  ///< empty before the first stretch
  KeptEvaluators evaluators_;
  std::optional<ModeVariation> variation_;  ///< of a run with variations
  std::vector<DiodeState> diodes_;
  std::map<Mode, DiodeSight> sights_;         ///< by the sides of the switches alone
  std::vector<ContactHistory> contacts_;      ///< by diode
  std::vector<std::optional<double>> kick_;   ///< by diode: see DiodeSides::kick
  std::vector<double> closing_;               ///< by diode: see DiodeSides::closing
  std::vector<bool> at_gap_;                  ///< by diode: see DiodeSides::at_gap
  std::vector<double> flight_;                ///< by diode: see DiodeSides::flight
  std::vector<double> returns_;               ///< by diode: see DiodeSides::returns; of the last settle_diodes()
  std::vector<double> least_flight_;          ///< by diode: see DiodeSides::least_flight
  std::vector<std::optional<double>> rests_;  ///< by diode: where the impacts end after which it has closed
  std::vector<double> rest_moves_;            ///< by diode: t' of that, in a run with variations
  bool noted_flights_ = false;
  bool lifts_off_ = false;     ///< a contact opens without a speed in this stretch
  bool short_flight_ = false;  ///< in this stretch; see flies_short()
  struct Sequence {
    double t = -std::numeric_limits<double>::infinity();
    double fastest = 0.0;  ///< closing speed of its fastest impact
    std::uint64_t count = 0;
    bool ended = false;
    template <class Archive>
    void carry(Archive& archive);
  };
  Sequence sequence_;          ///< of impacts that follow each other, in the latest instant that had any
  bool sequential_ = false;    ///< such a sequence had more than one impact
  bool simultaneous_ = false;  ///< several contacts have taken impulses at once
  std::vector<double> flow_off_, effort_off_;      ///< by diode: what they may be off by
  std::vector<double> flow_error_, effort_error_;  ///< the same, without an allowance
  std::vector<AtBorder> held_;       ///< laws that the last stretch held where it ended, if no store has jumped since
  std::vector<AtBorder> at_border_;  ///< see DiodeSides::at_border
  std::vector<bool> undecided_;      ///< by diode: on its border, as far as rounding lets one see
  double again_at_ = std::numeric_limits<double>::quiet_NaN();  ///< when diodes left a mode that was found again
  std::vector<double> bands_;                                   ///< by diode, of the present program
  std::vector<bool> tripped_;          ///< by diode: it left its side in the last change of the mode
  Mode left_;                          ///< from where that was
  std::vector<double> parameters_;     ///< of the present program: with the bands of diodes
  std::vector<double> x_;              ///< by state of the present program: after the jump
  std::map<Key, double> scale_;        ///< largest magnitude of each state, in whatever mode
  std::map<Key, double> tolerance_;    ///< absolute, where it was last a state
  std::optional<ErrorMemory> errors_;  ///< of the last stretch
  std::vector<double> exact_;          ///< by state of the present program: after the exact solution's jump
  bool estimates_ = true;
  std::set<Mode> met_;
  std::vector<Departure> departures_;  ///< from modes, within the present instant
  double instant_ = -std::numeric_limits<double>::infinity();
  std::deque<double> changes_;  ///< times of the latest that conditions on states made
  bool locking_ = false;        ///< the last change was one of a switch that is written as locked
  bool switched_ = true;        ///< the last change was not one of diodes alone, which cut no flow that is not 0
  bool audited_ = true, remarked_ = false;
  std::size_t lone_jumps_ = 0;
  static constexpr std::size_t kNotedAccumulations = 4;
  std::size_t accumulations_ = 0;     ///< of impacts, at which a contact closed
  std::set<std::string> indefinite_;  ///< outputs that have been noted
  std::set<std::string> noted_;       ///< stores that have jumped alone
};

}  // namespace bgsim
