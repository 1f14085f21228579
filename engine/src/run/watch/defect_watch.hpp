/// Whether a step is what the rates along it add up to.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "run/integrate/integrator.hpp"
#include "run/tolerances.hpp"
#include "run/watch/sharp_laws.hpp"

namespace bgsim {

/// Has steps made again whose increments are not what the rates along them add up to (SharpLaws): shorter where a law
/// is sharper than the integrator could see, and up to the event where what was evaluated beyond it has come into the
/// dense output.
class DefectWatch {
 public:
  DefectWatch(const Program& program, const RunInputs& inputs, Evaluator& evaluator, const Tolerances& tolerances);

  /// The integrator's last step up to @p until, whose ends are @p ends: its end, or the event that cuts it.
  /// @return  false: the step is to be made again, from its beginning, with the integrator restarted. It has been given
  ///          the step to begin with, or limit() says how far it may go.
  bool look(Integrator& integrator, const StepEnds& ends, double until, bool event);
  /// The end of the next stretch, which is @p end at most.
  [[nodiscard]] double limit(double t, double end) const { return cut_ && *cut_ > t ? std::min(*cut_, end) : end; }
  /// Whether the integrator has to restart at @p t because a stretch ends here.
  [[nodiscard]] bool is_limit(double t) const { return cut_ && *cut_ == t; }

  /// State and time of the first step that stayed as it was though it is not known to hold.
  [[nodiscard]] std::optional<std::pair<std::size_t, double>> unseen() const {
    return unseen_state_.empty() ? std::nullopt : std::optional(std::pair(unseen_state_.front(), unseen_time_));
  }

  template <class Archive>
  void carry(Archive& archive) {
    archive("cut", cut_);
    archive("refused at", refused_at_);
    archive("refused", refused_);
    archive("unseen state", unseen_state_);
    for (const std::size_t state : unseen_state_) archive.check(state < program_.state_names.size());
    archive("unseen time", unseen_time_);
    archive("laws", laws_);
  }

 private:
  void leave(std::size_t state, double t);

  const Program& program_;
  Evaluator& evaluator_;
  bool fixed_;
  SharpLaws laws_;
  SharpStep step_;
  Branch branch_;
  Integrator* integrator_ = nullptr;
  std::vector<double> modes_;  ///< that the laws know
  std::optional<double> cut_;  ///< no step passes this time
  double refused_at_ = 0.0;    ///< where a step last had to be made again
  int refused_ = 0;            ///< how often there
  std::vector<std::size_t> unseen_state_;
  double unseen_time_ = 0.0;
};

}  // namespace bgsim
