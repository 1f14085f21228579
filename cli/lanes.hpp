/// Lanes of modes: which side each switch, diode, contact and latch is on over time, and when there were events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim::cli {

struct Lane {
  enum class Kind : std::uint8_t { switching, diode, contact, latch, friction, marks };
  Kind kind = Kind::marks;
  std::string name;
  std::string on, off;        ///< sides; empty where the run never came to them. Of marks `on` says what they are
  std::uint64_t changes = 0;  ///< of sides; with those that another followed in the same instant
  std::vector<double> from;   ///< beginnings of stretches, increasing; the first is that of the run
  std::vector<double> share;  ///< by stretch: 1 on, 0 off; between: part of the time on, where sides change too fast
  std::vector<double> marks;  ///< times, increasing: impacts of a contact, or what a lane of marks shows
};

/// "chop: closed (filled), open; 199 changes"
std::string lane_text(const Lane& lane);

/// Collects lanes from the events of a run, in the order in which they came.
class LaneBook {
 public:
  void take(const RunEvent& event);
  /// In order of appearance: switches, diodes, contacts, latches and friction that is held; then marks: impacts that
  /// set no contact's lane, events, jumps of stores, samples (signals of one rate share a lane).
  /// @param start  of the run: where a lane without a row for its start begins
  [[nodiscard]] std::vector<Lane> lanes(double start) const;

 private:
  struct Side {
    double t;
    std::string to;
  };
  struct Course {
    Lane::Kind kind;
    std::string name, first;  ///< the side before all
    bool held = false;        ///< friction: it was held once
    std::vector<Side> sides;
    std::vector<double> marks;
  };
  Course& course(Lane::Kind kind, const std::string& name);

  std::vector<Course> courses_;
  std::map<std::pair<Lane::Kind, std::string>, std::size_t> position_;
  std::map<std::string, std::vector<double>> events_, samples_;
  std::vector<std::string> event_names_, sample_names_;  ///< in order of appearance
  std::vector<double> jumps_;
};

/// The stretch from @p from to @p to, with no more stretches than can be drawn there one by one: the time is cut into
/// @p buckets, and those that a stretch shorter than a bucket reaches have the part of their time that is on, above 0
/// and below 1: nothing that happened looks like nothing. All other changes keep their times.
Lane merged(const Lane& lane, double from, double to, std::size_t buckets);

/// Which of many lanes are drawn: all up to @p most; else first those that change, in order.
/// @return indices, increasing
std::vector<std::size_t> lanes_to_draw(const std::vector<Lane>& lanes, std::size_t most);

}  // namespace bgsim::cli
