// Equilibria of models with switches: the search for the mode in which a point rests.
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <set>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/study.hpp"
#include "bgsim/text.hpp"
#include "linear/steady.hpp"
#include "model/add_symbols.hpp"
#include "model/replace_symbols.hpp"
#include "study/mode_programs.hpp"

namespace bgsim {
namespace {

/// The model with its time held where it is: a parameter more, the last one.
Model with_held_time(Model model) {
  const ParameterId held = add_parameter(model, "(time held)");
  replace_symbols(model, {{model.time, model.pool.symbol(model.parameters[held.index()].symbol)}});
  return model;
}

class ModeSearch {
 public:
  ModeSearch(const Study& study, const RunInputs& scene, const SteadyOptions& options)
      : study_(study), scene_(scene), options_(options) {
    made_.switches = switches_of(study.model()).size();
  }

  SteadyStates run() {
    const SwitchedStart start = ModePrograms(study_.shared_model(), {{}, false}).start(scene_);
    start_ = start.stored;
    look({start.mode, start_, "the start of the scene"});
    // Each change of all sides that are left is a step of block pivoting: of a ladder of diodes one more conducts.
    follow(all_sides_, kMostModes + made_.switches);
    if (!enough()) come_to_rest();
    follow(all_sides_, 2 * (kMostModes + made_.switches));
    follow(one_side_, kMostModes);
    look_at_all();
    if (made_.found.empty()) fail();
    made_.looked_at = seen_.size();
    return std::move(made_);
  }

 private:
  static constexpr std::size_t kMostModes = 64, kMostSwitches = 6;

  struct Place {
    Mode mode;
    Stored stored;
    std::string where;
  };

  [[nodiscard]] bool enough() const { return !options_.all && !made_.found.empty(); }

  /// Looks for equilibria of one mode, and adds the modes that these lead to to the lists.
  void look(const Place& from) {
    if (enough()) return;
    const bool first = seen_.empty();
    seen_.insert(from.mode);
    std::vector<Equilibrium> points;
    const Study mode = study_.in_mode(from.mode);
    try {
      // On the way to a mode through many others, one rest of each is enough.
      points = equilibria_from(mode.shared_model(), scene_, {from.stored, from.where, made_.switches <= kMostSwitches},
                               options_);
    } catch (const ModelError& error) {
      if (first) first_error_ = error;  // another mode may be impossible, or rest nowhere
      return;
    }
    for (Equilibrium& point : points) {
      if (point.leaves.empty()) {
        keep(std::move(point));
        continue;
      }
      const std::vector<ElementId> switches = switches_of(study_.model());
      Place next{from.mode, {scene_.start, point.values}, "where a mode rests that is left there"};
      for (const ElementId id : point.leaves) {
        const auto at = static_cast<std::size_t>(std::find(switches.begin(), switches.end(), id) - switches.begin());
        next.mode[at] = !next.mode[at];
        Place one = next;
        one.mode = from.mode;
        one.mode[at] = !one.mode[at];
        one_side_.push_back(std::move(one));
      }
      all_sides_.push_back(std::move(next));
      left_.push_back(std::move(point));
    }
  }

  /// The modes of a list, until so many have been looked at.
  void follow(std::deque<Place>& open, std::size_t most) {
    while (!open.empty() && !enough() && seen_.size() < most) {
      const Place next = std::move(open.front());
      open.pop_front();
      if (!seen_.contains(next.mode)) look(next);
    }
  }

  /// One point is on the border of several modes.
  void keep(Equilibrium point) {
    const auto same = [&](const Equilibrium& other) {
      for (std::size_t i = 0; i < point.values.size(); ++i) {
        const double a = point.values[i].value, b = other.values[i].value;
        const double off =
            std::max({point.values[i].rounding, other.values[i].rounding, 1e-9 * std::max(std::abs(a), std::abs(b))});
        if (std::abs(a - b) > off) return false;
      }
      return true;
    };
    for (const Equilibrium& other : made_.found)
      if (other.values.size() == point.values.size() && same(other)) return;
    made_.found.push_back(std::move(point));
  }

  /// Where the scene comes to if its sources are held: the mode, and stores from which a rest in it is found.
  void come_to_rest() {
    constexpr std::uint64_t kMostSteps = 200000;
    constexpr double kMostSeconds = 5.0, kLonger[] = {1.0, 30.0, 1000.0};
    const Study held(std::make_shared<const Model>(with_held_time(study_.model())));
    RunInputs inputs = scene_;
    // Just after it: sources jump at the start of the scene, too.
    inputs.parameters.push_back(std::nextafter(scene_.start, std::numeric_limits<double>::infinity()));
    inputs.outputs.clear();
    SimulateOptions how;
    how.energy_audit = how.error_estimate = how.second_run = false;
    how.max_steps = kMostSteps;
    how.time_limit = kMostSeconds;
    const double span = scene_.stop > scene_.start ? scene_.stop - scene_.start : 1.0;
    for (const double longer : kLonger) {
      inputs.stop = scene_.start + longer * span;
      inputs.output_times = {inputs.start, inputs.stop};
      RunResult result;
      try {
        result = held.scene(inputs, {false, true}).simulate(how);
      } catch (const ModelError&) {
        return;
      }
      if (result.stored.values.empty() || result.mode.empty()) return;
      // Looked at again where it was met on another way, since contacts close in a run alone.
      look({result.mode, result.stored, "where a run comes to that holds the sources"});
      if (!made_.found.empty() || result.stop != StopReason::completed) return;
    }
  }

  void look_at_all() {
    if (enough() || made_.switches > kMostSwitches) return;
    for (std::size_t bits = 0; bits < (std::size_t{1} << made_.switches); ++bits) {
      Mode mode;
      for (std::size_t i = 0; i < made_.switches; ++i) mode.push_back(((bits >> i) & 1U) != 0);
      if (seen_.contains(mode)) continue;
      look({mode, start_, "the start of the scene"});
    }
  }

  [[noreturn]] void fail() {
    if (left_.empty() && first_error_) throw *first_error_;
    constexpr std::size_t kMost = 4;
    std::vector<Note> notes;
    std::set<Mode> named;
    for (std::size_t i = 0; i < left_.size() && notes.size() < kMost; ++i) {
      if (!named.insert(left_[i].mode).second) continue;
      std::string names;
      for (const ElementId id : left_[i].leaves)
        names += (names.empty() ? "" : ", ") + in_quotes(short_name(study_.model().elements[id.index()].name));
      notes.push_back({study_.model().elements[left_[i].leaves.front().index()].place,
                       "in the mode " + mode_text(study_.model(), left_[i].mode) + " there is a rest at which " +
                           names + (left_[i].leaves.size() > 1 ? " leave their sides" : " leaves its side")});
    }
    throw ModelError(
        {diagnostic_of("BG412",
                       "no steady state was found near the scene " + short_name(scene_.scene) + " in " +
                           std::to_string(seen_.size()) + (seen_.size() == 1 ? " mode" : " modes") +
                           " of its switches: where the model rests a switch leaves the side that it is on",
                       {},
                       "in a steady state all stores and integrals rest, sources held at their values at t = " +
                           number_text(scene_.start) + ", and no switch, diode or contact changes its side",
                       "a model that keeps switching has none: run the scene instead", std::move(notes))},
        study_.model().sources);
  }

  const Study& study_;
  const RunInputs& scene_;
  const SteadyOptions options_;
  SteadyStates made_;
  Stored start_;
  std::set<Mode> seen_;
  std::deque<Place> all_sides_, one_side_;  ///< modes that equilibria of others lead to
  std::vector<Equilibrium> left_;           ///< equilibria that leave their modes
  std::optional<ModelError> first_error_;
};

}  // namespace

SteadyStates steady_states(const Study& study, const RunInputs& scene, const SteadyOptions& options) {
  if (switches_of(study.model()).empty()) return {equilibria(study.shared_model(), scene, options), 1, 0};
  return ModeSearch(study, scene, options).run();
}

}  // namespace bgsim
