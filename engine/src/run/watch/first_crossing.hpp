/// The first moment of a stretch of time at which one of several functions has crossed zero, by proof.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "program/enclosure.hpp"

namespace bgsim {

/// What is searched: functions of time that can be enclosed over a stretch and evaluated at a moment.
class CrossingFunctions {
 public:
  virtual ~CrossingFunctions() = default;
  CrossingFunctions(const CrossingFunctions&) = delete;
  CrossingFunctions& operator=(const CrossingFunctions&) = delete;

  /// Encloses all functions over [from, to]: jet() gives them. False at a fault.
  virtual bool enclose(double from, double to) = 0;
  [[nodiscard]] virtual Jet jet(std::size_t function) const = 0;
  /// Whether a function with these values has not crossed anywhere on the stretch.
  [[nodiscard]] virtual bool stays(std::size_t function, const Jet& jet) const = 0;
  /// Evaluates all functions at @p t: crossed() tells of them. False at a fault.
  virtual bool evaluate(double t) = 0;
  [[nodiscard]] virtual bool crossed(std::size_t function) const = 0;

 protected:
  CrossingFunctions() = default;
};

struct FirstCrossing {
  bool fault = false;  ///< in an evaluation
  /// A function has crossed at the second moment, none at the first, and none crosses twice between them.
  std::optional<std::pair<double, double>> bracket;
  /// Of which the work allowed gave no proof: they are judged by their values at single moments.
  std::vector<std::size_t> undecided;
  double undecided_at = 0.0;
  int enclosures = 0;
};

/// Bisection, left half first. A function is done with on a stretch where its enclosure keeps to its side, or where it
/// only rises or only falls, so that the ends tell.
/// @param functions  those in question; none has crossed at @p from.
/// @param work       enclosures at most.
FirstCrossing first_crossing(CrossingFunctions& functions, std::vector<std::size_t> candidates, double from, double to,
                             int work);

}  // namespace bgsim
