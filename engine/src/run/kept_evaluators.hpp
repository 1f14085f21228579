/// Evaluators that a run comes back to, since making one costs more than many evaluations.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "program/known_times.hpp"

namespace bgsim {

class KeptEvaluators {
 public:
  /// As a new one. It stays what it is until the same program is asked for with other parameters, or many others have
  /// been asked for.
  /// @param program  must outlive this.
  Evaluator& of(const Program& program, const std::vector<double>& parameters) {
    constexpr std::size_t kMost = 64;  // of large models in thousands of modes all together would take the memory
    auto found = kept_.find(&program);
    if (found == kept_.end()) {
      if (kept_.size() >= kMost) {
        retired_ = std::move(kept_);
        kept_.clear();
      }
      found = kept_.emplace(&program, Kept{}).first;
    }
    Kept& kept = found->second;
    if (kept.evaluator && kept.parameters == parameters) {
      kept.evaluator->begin_again();
      return *kept.evaluator;
    }
    kept.evaluator = std::make_unique<Evaluator>(program, parameters);
    kept.evaluator->share_known_times(times_);
    kept.parameters = parameters;
    return *kept.evaluator;
  }

 private:
  struct Kept {
    std::vector<double> parameters;
    std::unique_ptr<Evaluator> evaluator;
  };
  KnownTimes times_;                               ///< of all that are kept: to be destroyed after them
  std::map<const Program*, Kept> kept_, retired_;  ///< retired_: may still be in use
};

}  // namespace bgsim
