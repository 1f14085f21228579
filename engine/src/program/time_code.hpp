/// Partial derivatives of rates and loops by time, as code that is made behind a program.
#pragma once

#include <cstdint>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// What Evaluator::time_slopes runs. One method alone asks for it, which is chosen when a run begins: programs are
/// compiled without it. The partials are those of the frozen expressions, as the Jacobian's are.
struct TimeCode {
  /// Nothing is taken where neither a rate nor a loop names the time. Cost: the expressions below these.
  explicit TimeCode(const Program& program);

  struct Entry {
    std::uint32_t row, slot;
  };
  std::vector<Entry> rates;
  std::vector<std::vector<Entry>> blocks;  ///< by loop: of its residuals
  std::vector<double> more_slots;          ///< behind those of the program: constants in place, 0 elsewhere
  std::vector<Instruction> once, code;     ///< what depends on parameters only; the rest, where the tears are known
  [[nodiscard]] bool empty() const { return empty_; }

 private:
  bool empty_ = true;
};

}  // namespace bgsim
