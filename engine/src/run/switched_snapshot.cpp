// Snapshots of a switched run: what it knows from stretch to stretch, with the snapshot of the stretch that it is in.
#include <nlohmann/json.hpp>

#include "run/snapshot.hpp"
#include "run/switched_run.hpp"

namespace bgsim {

template <class Archive>
void carry(Archive& archive, std::pair<std::string, double>& entry) {
  archive("name", entry.first);
  archive("value", entry.second);
}

template <class Archive>
void carry(Archive& archive, RunInputs::Initial& at) {
  archive("element", at.element.value);
  archive("port", at.port);
  archive("signal", at.signal.value);
  archive("value", at.value);
}

template <class Archive>
void carry(Archive& archive, Stored& stored) {
  archive("t", stored.t);
  archive("values", stored.values);
}

template <class Archive>
void carry(Archive& archive, ErrorMemory& memory) {
  archive("start", memory.sums.start);
  archive("steps", memory.sums.steps);
  archive("largest", memory.sums.largest);
  archive("bounded", memory.sums.bounded);
  archive("beyond", memory.sums.beyond);
  archive("least", memory.sums.least_value);
  archive("most", memory.sums.most_value);
  archive("late", memory.late);
  archive("exact", memory.exact);
}

/// Before a stretch; within one its run has them.
struct DelaysBetween {
  DelayMemory memory;
  const DelayTables* tables = nullptr;
  template <class Archive>
  void carry(Archive& archive) {
    carry_delays(archive, memory, *tables);
  }
};

template <class Archive>
void carry(Archive& archive, DiodeState& diode) {
  archive("conducts", diode.conducts);
  archive("may begin", diode.may_begin);
  archive("pinned", diode.pinned);
  archive("effort", diode.effort);
  archive("flow", diode.flow);
  archive("touches", diode.touches);
  archive("sticks", diode.sticks);
}

template <class Archive>
void carry(Archive& archive, ContactHistory& history) {
  archive("times", history.times);
  archive("longest", history.longest);
  archive("fastest", history.fastest);
  archive("rebound", history.rebound);
  archive("impacts", history.impacts);
}

template <class Archive>
void carry(Archive& archive, RunReport::SetEvent& event) {
  archive("name", event.name);
  archive("count", event.count);
  archive("energy", event.energy);
}

template <class Archive>
void carry(Archive& archive, EnergyAudit& energy) {
  archive("why not", energy.why_not);
  archive("supplied", energy.supplied);
  archive("stored", energy.stored);
  archive("dissipated", energy.dissipated);
  archive("exchanged", energy.exchanged);
  archive("switching", energy.switching);
  archive("impacts", energy.impacts);
  archive("events", energy.events);
  archive("residual", energy.residual);
  archive("turnover", energy.turnover);
  archive("least dissipation", energy.least_dissipation);
  archive("least dissipation of", energy.least_dissipation_element);
  archive("activity", energy.activity);
  archive("course", energy.course);
}

/// What is added up over the stretches, or is of the last of them.
template <class Archive>
void carry(Archive& archive, RunReport& report) {
  archive("method", report.method);
  archive("method reason", report.method_reason);
  archive("states", report.states);
  archive("algebraic", report.algebraic);
  archive("loops", report.loops);
  archive("absolute", report.absolute);
  archive("steps", report.steps);
  archive("rates", report.rate_evaluations);
  archive("jacobians", report.jacobian_evaluations);
  archive("factorizations", report.factorizations);
  archive("iterations", report.nonlinear_iterations);
  archive("error failures", report.error_test_failures);
  archive("convergence failures", report.convergence_failures);
  archive("loop iterations", report.loop_iterations);
  archive("time events", report.time_events);
  archive("state events", report.state_events);
  archive("set events", report.set_events);
  archive("impacts", report.impacts);
  archive("mode changes", report.mode_changes);
  archive("errors possible", report.errors.possible);
  archive("why no errors", report.errors.why_not);
  archive("notes", report.notes);
  archive("energy", report.energy);
}

template <class Archive>
void SwitchedRun::Departure::carry(Archive& archive) {
  archive("mode", mode);
  archive("stored", stored);
}

template <class Archive>
void SwitchedRun::Seen::carry(Archive& archive) {
  archive("switches", switches);
  archive("resistances", sight.resistances);
  archive("slopes", sight.slopes);
}

template <class Archive>
void SwitchedRun::Sequence::carry(Archive& archive) {
  archive("t", t);
  archive("first", fastest);  // as snapshots have it that were taken before it was the fastest
  archive("count", count);
  archive("ended", ended);
}

template <class Archive>
void SwitchedRun::carry_map(Archive& archive, const char* name, std::map<Key, double>& map) {
  std::vector<RunInputs::Initial> list;
  for (const auto& [at, value] : map)
    list.push_back({ElementId{std::get<0>(at)}, std::get<1>(at), value, {}, SignalId{std::get<2>(at)}});
  archive(name, list);
  map.clear();
  for (const RunInputs::Initial& at : list) map[{at.element.value, at.port, at.signal.value}] = at.value;
}

template <class Archive, class Set>
void SwitchedRun::carry_set(Archive& archive, const char* name, Set& set) {
  std::vector<typename Set::value_type> list(set.begin(), set.end());
  archive(name, list);
  set = Set(list.begin(), list.end());
}

template <class Archive>
void SwitchedRun::carry(Archive& archive) {
  const auto by_diode = [&](const char* name, auto& list) {
    archive(name, list);
    archive.check(list.empty() || list.size() == diodes_.size());
  };
  const std::size_t diodes = diodes_.size();
  archive("mode", mode_);
  archive("stored", stored_);
  archive("log", log_);
  archive("logged", logged_);
  archive("logged start", logged_start_);
  archive("last row", last_row_);
  archive("earlier row", earlier_row_);
  archive("steps", steps_);
  archive("diodes", diodes_);
  std::vector<Seen> seen;
  for (const auto& [switches, sight] : sights_) seen.push_back({switches, sight});
  archive("seen", seen);
  sights_.clear();
  for (const Seen& at : seen) {
    const std::size_t size = at.sight.resistances.size();
    archive.check(at.switches.size() == mode_.size() && (size == diodes || size == 0));
    archive.check(at.sight.slopes.size() == 3 * size);
    sights_[at.switches] = at.sight;
  }
  archive("contacts", contacts_);
  archive.check(diodes_.size() == diodes && contacts_.size() == diodes);
  by_diode("kick", kick_);
  by_diode("closing", closing_);
  by_diode("at gap", at_gap_);
  by_diode("flight", flight_);
  by_diode("least flight", least_flight_);
  by_diode("rests", rests_);
  archive("noted flights", noted_flights_);
  archive("sequence", sequence_);
  archive("sequential", sequential_);
  archive("simultaneous", simultaneous_);
  by_diode("flow off", flow_off_);
  by_diode("effort off", effort_off_);
  by_diode("flow error", flow_error_);
  by_diode("effort error", effort_error_);
  by_diode("bands", bands_);
  by_diode("tripped", tripped_);
  archive("left", left_);
  archive.check(left_.empty() || left_.size() == mode_.size());
  archive("parameters", parameters_);
  archive("x", x_);
  carry_map(archive, "scale", scale_);
  carry_map(archive, "tolerance", tolerance_);
  archive("events", events_);
  if (!delayed_.empty()) {
    bool between = delays_.has_value();
    archive("delays between", between);
    if (between) {
      DelaysBetween delays{delays_ ? std::move(*delays_) : DelayMemory{}, &delayed_};
      archive("delays", delays);
      delays_ = std::move(delays.memory);
    } else {
      delays_.reset();
    }
  }
  archive("errors", errors_);
  archive("exact", exact_);
  archive("estimates", estimates_);
  carry_set(archive, "met", met_);
  archive("departures", departures_);
  archive("instant", instant_);
  archive("changes", changes_);
  archive("locking", locking_);
  archive("switched", switched_);
  archive("audited", audited_);
  archive("lone jumps", lone_jumps_);
  archive("accumulations", accumulations_);
  carry_set(archive, "noted", noted_);
  carry_set(archive, "indefinite", indefinite_);
  archive("report", result_.report);
}

std::string SwitchedRun::own_fingerprint() const {
  std::string text = fingerprint(program_of_(start_mode_, {}), inputs_);
  if (!diodes_.empty()) text += fingerprint(network_of_(start_mode_).program, inputs_);
  return text;
}

nlohmann::ordered_json SwitchedRun::state() {
  SnapshotWriter writer;
  carry(writer);
  return writer.json();
}

void SwitchedRun::offer(double t, nlohmann::ordered_json state) {
  options_.snapshot(t, snapshot_text(program_of_(start_mode_, {}).model->name, inputs_.scene, t, own_fingerprint(),
                                     kept_by(options_), std::move(state)));
  snapshot_given_ = true;
}

void SwitchedRun::offer_stretch(double t, const std::string& stretch) {
  log_.reach(t);
  nlohmann::ordered_json json = state();
  json["stretch"] = nlohmann::ordered_json::parse(stretch);
  offer(t, std::move(json));
}

void SwitchedRun::offer_end() {
  if (!at_stop_ || snapshot_given_ || result_.stop != StopReason::completed) return;
  // What has been recorded of that instant is not recorded again.
  SnapshotWriter row;
  row("last row", last_row_);
  (*at_stop_)["last row"] = row.json()["last row"];
  (*at_stop_)["given events"] = log_.given();
  offer(stored_.t, std::move(*at_stop_));
}

bool SwitchedRun::resume() {
  const auto& sources = program_of_(start_mode_, {}).model->sources;
  const nlohmann::ordered_json state =
      state_of_snapshot(options_.resume, own_fingerprint(), kept_by(options_), sources);
  stored_.values.clear();
  sights_.clear();
  std::uint64_t given = 0;
  double t = 0.0;
  const auto stretch = state.find("stretch");
  try {
    SnapshotReader reader(state);
    carry(reader);
    if (stretch == state.end())
      reader("given events", given);
    else if (stretch->is_object() && stretch->contains("state"))
      SnapshotReader{(*stretch)["state"]}("t", t);
    if (!(stored_.t >= inputs_.start)) throw SnapshotError("\"t\" in it lies before the scene");
  } catch (const SnapshotError& error) {
    refuse_snapshot(error.what(), sources);
  }
  if (stored_.t > inputs_.stop)
    refuse_snapshot("the snapshot is of t = " + number_text(stored_.t) + " or later, after the end of the scene",
                    sources);
  if (stretch == state.end()) {
    log_.skip(given);
    return true;
  }
  const Program* const program = program_here();
  if (program == nullptr) return false;
  const std::size_t parameters = diodes_.empty() ? inputs_.parameters.size() : program->model->parameters.size();
  if (parameters_.size() != parameters || x_.size() != program->states.size())
    refuse_snapshot("a list in it is not as long as this model asks for", sources);
  log_start(*program->model, t);
  return stretch_in(*program, stretch->dump());
}

}  // namespace bgsim
