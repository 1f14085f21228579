/// When something happened in a run, and how far two runs of one scene are apart in that.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// Instants that a run has found by itself: sides of switches, diodes, contacts and latches, impacts, events of the
/// model. Those of samples and of conditions are left out: the first are known, the second are within the laws.
class EventTimes {
 public:
  void take(const RunEvent& event);

  /// By what happened, in order of time.
  [[nodiscard]] const std::map<std::string, std::vector<double>>& all() const { return times_; }

 private:
  std::map<std::string, std::vector<double>> times_;
};

/// Whether something can happen at instants that a run finds by itself.
bool has_events(const Model& model);

/// How far the instants of two runs are apart.
struct EventDistance {
  double largest = 0.0;  ///< from an event of one run to the nearest of its kind in the other
  std::string what;      ///< where that is so; empty: nowhere
  /// Times between an event and the nearest of its kind in the other run, in order, none overlapping. What is recorded
  /// there is before the event in one run and after it in the other.
  std::vector<std::pair<double, double>> between;

  /// Whether the runs are on different sides of an event at @p t.
  [[nodiscard]] bool parted(double t) const;
};

/// @param span  the distance to an event of which there is none in the other run.
EventDistance event_distance(const EventTimes& one, const EventTimes& other, double span);

}  // namespace bgsim
