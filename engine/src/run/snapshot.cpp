#include "run/snapshot.hpp"

#include <bit>

#include "base/codes.hpp"

namespace bgsim {

namespace {

/// FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo; IETF draft-eastlake-fnv): against mistakes, not against forgery.
class Digest {
 public:
  void add(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte) {
      hash_ ^= value >> (8 * byte) & 0xffU;
      hash_ *= 0x100000001b3U;
    }
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const std::string& text) {
    add(text.size());
    for (const char c : text) add(std::uint64_t{static_cast<unsigned char>(c)});
  }
  void add(const Routine& routine) {
    for (const auto& code : routine.code) {
      add(code.size());
      for (const Instruction& i : code) {
        add(static_cast<std::uint64_t>(i.op));
        add(std::uint64_t{i.out} << 32U | i.a);
        add(std::uint64_t{i.b} << 32U | i.c);
      }
    }
    for (const std::uint32_t solve : routine.solves) add(std::uint64_t{solve});
    for (const std::uint32_t result : routine.results) add(std::uint64_t{result});
  }
  [[nodiscard]] std::string text() const {
    std::string digits;
    for (int nibble = 15; nibble >= 0; --nibble) digits += "0123456789abcdef"[hash_ >> (4 * nibble) & 0xfU];
    return digits;
  }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

std::string digest_of(const nlohmann::ordered_json& state) {
  Digest digest;
  digest.add(state.dump());
  return digest.text();
}

}  // namespace

void refuse_snapshot(const std::string& why, const std::shared_ptr<const Sources>& sources) {
  Diagnostic diagnostic = diagnostic_of("BG171", "the run cannot be continued: " + why);
  diagnostic.rule = "a snapshot holds the state of a run of one model, scene and method";
  diagnostic.help = "give the model, scene and options of the run that wrote it; output times and the end may differ";
  throw ModelError({std::move(diagnostic)}, sources);
}

SnapshotKept kept_by(const SimulateOptions& options) { return {options.energy_audit, options.error_estimate}; }

nlohmann::ordered_json state_of_snapshot(const std::string& text, const std::string& fingerprint, SnapshotKept kept,
                                         const std::shared_ptr<const Sources>& sources) {
  auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("bgsim_snapshot", nlohmann::ordered_json()) != kSnapshotFormat ||
      !json.contains("state") || !json["state"].is_object())
    refuse_snapshot("the text is no snapshot that this version of bgsim has written", sources);
  if (json.value("program", nlohmann::ordered_json()) != fingerprint)
    refuse_snapshot("the snapshot is one of another model, scene, method or set of outputs", sources);
  // What is read from here on is what was written: counts and places in it are not looked at one by one.
  if (json.value("digest", nlohmann::ordered_json()) != digest_of(json["state"]))
    refuse_snapshot("the snapshot is not as it was written", sources);
  const auto same = [&](const char* key, bool here, const std::string& what) {
    if (json.value(key, nlohmann::ordered_json()) == here) return;
    refuse_snapshot("the snapshot is of a run " + std::string(here ? "without" : "with") + " " + what +
                        ", and this one is " + (here ? "with" : "without") + " it",
                    sources);
  };
  same("energy_audit", kept.audit, "an energy audit");
  same("error_estimate", kept.errors, "an estimate of errors");
  return std::move(json["state"]);
}

std::string snapshot_text(const std::string& model, const std::string& scene, double t, const std::string& fingerprint,
                          SnapshotKept kept, nlohmann::ordered_json state) {
  const std::string digest = digest_of(state);
  const nlohmann::ordered_json json = {{"bgsim_snapshot", kSnapshotFormat},
                                       {"model", model},
                                       {"scene", scene},
                                       {"t", t},
                                       {"program", fingerprint},
                                       {"energy_audit", kept.audit},
                                       {"error_estimate", kept.errors},
                                       {"digest", digest},
                                       {"state", std::move(state)}};
  return json.dump(1, '\t') + "\n";
}

std::string fingerprint(const Program& program, const RunInputs& inputs) {
  Digest digest;
  for (const auto* const names : {&program.state_names, &program.tear_names, &program.energy_names})
    for (const std::string& name : *names) digest.add(name);
  for (const std::string& name : program.output_names) digest.add(name);
  for (const Routine* const routine :
       {&program.once, &program.rates, &program.guards, &program.powers, &program.event_conditions,
        &program.event_values, &program.switches, &program.diodes})
    digest.add(*routine);
  for (const double slot : program.initial_slots) digest.add(slot);
  for (const auto& table : program.pool.tables()) {
    if (table->delayed) continue;  // what the run fills
    for (std::size_t i = 0; i < table->x.size(); ++i) {
      digest.add(table->x[i]);
      digest.add(table->y[i]);
    }
  }
  for (const Relation& relation : program.relations) digest.add(relation.text);
  for (const ProgramEvent& event : program.events) {
    digest.add(event.name);
    digest.add(event.priority);
    for (const ProgramEvent::Set& set : event.sets) digest.add(set.name);
  }
  for (const double parameter : inputs.parameters) digest.add(parameter);
  for (const RunInputs::Initial& initial : inputs.initial) digest.add(initial.value);
  digest.add(inputs.start);
  digest.add(inputs.relative);
  digest.add(inputs.absolute.value_or(-1.0));
  for (const auto& [name, tolerance] : inputs.absolute_by_state) {
    digest.add(name);
    digest.add(tolerance);
  }
  digest.add(static_cast<std::uint64_t>(inputs.method));
  digest.add(inputs.step);
  digest.add(static_cast<std::uint64_t>(inputs.max_order));
  return digest.text();
}

}  // namespace bgsim
