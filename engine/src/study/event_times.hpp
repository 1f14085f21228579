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
  /// The same without changes of a side that were taken back within @p shortest: a condition that holds with equality
  /// at the start (c.e >= 0 of an empty store) may fail there for some roundings, in one run and not in the other.
  [[nodiscard]] std::map<std::string, std::vector<double>> lasting(double shortest) const;

 private:
  struct Change {
    double t = 0.0;
    std::string from, to;
  };
  struct Return {
    std::string there, back;  ///< as in times_
    double at, until;
  };
  std::map<std::string, std::vector<double>> times_;
  std::map<std::string, Change> last_;  ///< by element
  std::vector<Return> returns_;
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
