/// A routine at several points at once.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/program.hpp"
#include "program/machine_code.hpp"

namespace bgsim {

/// Runs each instruction for up to four points, the stages of a step or rows of a trace, before the next one: one
/// decision which operator it is, and vector instructions where there are any. Each value is, to the bit, what it would
/// be one point after the other.
class Lanes {
 public:
  /// Whether this pays for a routine, and can be done: it solves no loops.
  [[nodiscard]] static bool suits(const Routine& routine);

  /// @param constants  by slot: what neither states nor time nor modes move.
  Lanes(const Program& program, std::span<const double> constants);

  /// @param modes  of all points.
  /// @return  whether all results are finite.
  bool run(const Routine& routine, std::span<const double> modes, const Evaluator::Points& points, MachineCode& made);

 private:
  static constexpr std::size_t kLanes = Evaluator::Points::kMost;
  using Lane = std::array<double, kLanes>;
  void run(const CodeList& code, std::size_t count);
  void look_up(const Instruction& table, std::size_t count);

  const Program& program_;
  std::vector<Lane> slots_;
};

}  // namespace bgsim
