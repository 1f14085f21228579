/// Times that are known beforehand and that no step may pass.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/watch/source_pace.hpp"

namespace bgsim {

/// Changes of conditions on time, and edges of the sources' pulses (source_pace.hpp).
class Schedule {
 public:
  Schedule(const Program& program, Evaluator& evaluator, const RunInputs& inputs)
      : program_(program), evaluator_(evaluator), inputs_(inputs) {
    for (std::size_t i = 0; i < program.relations.size(); ++i)
      if (program.relations[i].kind == Relation::Kind::denominator && program.relations[i].time_only)
        denominators_.push_back(i);
  }

  /// Looks for the sources' pulses. To be called once, before the first step; cost as plan_sources.
  /// @return  BG615: a pulse that double precision cannot follow.
  std::optional<Diagnostic> plan();
  [[nodiscard]] const SourcePlan& sources() const { return sources_; }

  /// The first such time after @p t, up to the end of the scene.
  [[nodiscard]] std::optional<double> next(double t) const;
  /// Times at which to ask what the sources will do: spread over the scene from @p t on, and just after its first known
  /// events.
  [[nodiscard]] std::vector<double> samples(double t) const;
  /// Sets the modes of conditions on time to those beyond @p t.
  void pass(double t, Branch& branch) const { evaluator_.set_time_modes(t, branch); }
  /// Denominators that depend on time alone, as relations.
  [[nodiscard]] const std::vector<std::size_t>& denominators() const { return denominators_; }

 private:
  const Program& program_;
  Evaluator& evaluator_;
  const RunInputs& inputs_;
  SourcePlan sources_;
  std::vector<std::size_t> denominators_;
};

}  // namespace bgsim
