/// What happened in a run at single instants: handed to whoever asked for it, and counted against the scene's limit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// Costs nothing where neither a sink nor a limit is given. Its memory grows with the number of conditions and names of
/// a model, not with that of events.
class EventLog {
 public:
  EventLog(const SimulateOptions& options, const RunInputs& inputs)
      : sink_(options.events), most_(inputs.max_events), place_(inputs.max_events_place) {}

  [[nodiscard]] bool wanted() const { return sink_ || most_ > 0; }
  void add(const RunEvent& event);
  /// A change of side that lies ahead: it is added before the first that is later, or by reach().
  void add_later(const RunEvent& event);
  /// Whether an event of this name still lay ahead: it does not take place.
  bool take_back(const std::string& name);
  /// The time has come to @p t.
  void reach(double t);
  /// What the event @p event of the model has set.
  void add_set(double t, const Program& program, std::size_t event, std::span<const double> before,
               std::span<const double> after, std::optional<double> energy);

  /// From here on conditions are those of @p program. Their sides are known by their texts from programs before it.
  void watch(const Program& program);
  /// Adds the conditions that have changed since the last look. One that is seen for the first time has not changed.
  void look(double t, const Branch& branch);
  /// The sides are those of @p branch, which the log knows from before.
  void take_over(const Branch& branch);

  /// BG628, where there are more events than the scene allows.
  [[nodiscard]] std::optional<Diagnostic> full(double t) const;

  template <class Archive>
  void carry(Archive& archive) {
    archive("count", count_);
    archive("names", names_);
    archive("counts", counts_);
    std::vector<std::string> texts, sides;
    for (const auto& [text, side] : sides_) {
      texts.push_back(text);
      sides.push_back(side);
    }
    archive("later", later_);
    archive.check(std::is_sorted(later_.begin(), later_.end(),
                                 [](const Later& a, const Later& b) { return a.event.t < b.event.t; }));
    archive("texts", texts);
    archive("sides", sides);
    archive.check(names_.size() == counts_.size() && texts.size() == sides.size());
    for (std::size_t i = 0; i < texts.size(); ++i) sides_[texts[i]] = sides[i];
    for (std::size_t i = 0; i < names_.size(); ++i) position_[names_[i]] = i;
  }

  /// From here on the sink is not given the first @p count events: it has had them.
  void skip(std::uint64_t count) { skip_ = count; }
  /// Counts from the beginning what the sink is given.
  void count_given() { given_ = 0; }
  [[nodiscard]] std::uint64_t given() const { return given_; }

 private:
  struct Watched {
    std::size_t relation;
    double mode;
    std::string* side;  ///< in sides_
  };

  void put(const RunEvent& event);

  struct Later {
    RunEvent event;
    template <class Archive>
    void carry(Archive& archive) {
      auto kind = static_cast<std::uint32_t>(event.kind);
      archive("kind", kind);
      archive.check(kind <= static_cast<std::uint32_t>(RunEvent::Kind::start));
      event.kind = static_cast<RunEvent::Kind>(kind);
      archive("t", event.t);
      archive("name", event.name);
      archive("from", event.from);
      archive("to", event.to);
    }
  };

  const EventSink& sink_;
  std::uint64_t most_;
  std::optional<Place> place_;
  std::uint64_t count_ = 0, given_ = 0, skip_ = 0;
  std::vector<Later> later_;        ///< by time
  std::vector<std::string> names_;  ///< by kind and name: "impact \"ground\""
  std::vector<std::uint64_t> counts_;
  std::map<std::string, std::size_t> position_;  ///< in names_
  const Program* program_ = nullptr;
  std::map<std::string, std::string> sides_;  ///< by text of a condition
  std::vector<Watched> watched_;
};

}  // namespace bgsim
