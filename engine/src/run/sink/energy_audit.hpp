/// The energy balance of a run, measured on the dense output.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/stopwatch.hpp"
#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/sink/gauss_rule.hpp"

namespace bgsim {

/// A sum that keeps what rounding would drop (Neumaier, ZAMM 54, 1974).
struct CompensatedSum {
  double sum = 0.0, lost = 0.0;
  void add(double value);
  [[nodiscard]] double value() const { return sum + lost; }
};

template <class Archive>
void carry(Archive& archive, CompensatedSum& sum) {
  archive("sum", sum.sum);
  archive("lost", sum.lost);
}

template <class Archive>
void carry(Archive& archive, EnergyCourse& course) {
  archive("times", course.times);
  archive("supplied", course.supplied);
  archive("stored", course.stored);
  archive("dissipated", course.dissipated);
  archive("exchanged", course.exchanged);
  archive("residual", course.residual);
}

/// Integrates the powers of all sources, resistors and stores over the run, and holds them against what the stores say
/// they hold. Junctions, TF and GY conserve power exactly, so the residual measures the solution's error (and a field
/// whose laws are not reciprocal).
class EnergyAuditor {
 public:
  EnergyAuditor(const Program& program, Evaluator& evaluator, const RunInputs& inputs, bool wanted);

  /// Asks for the terms at about @p points of the output times. To be called before begin().
  void record_course(const OutputTimes& output_times, std::size_t points);

  void begin(double t, const double* x, const Branch& branch);
  /// On to @p to, over a stretch on which the solution is smooth; @p solution(t, y, branch) gives it, @p branch being
  /// the one of a point nearby; @p order is that of its polynomial.
  template <class Solution>
  void add(double to, int order, const Branch& branch, Solution&& solution) {
    if (!measuring_) return;
    const Stopwatch watch(seconds_);
    double from = std::exchange(audited_, to);
    branch_ = branch;
    while (next_record_ < record_times_.size() && record_times_[next_record_] <= to) {
      const double at = record_times_[next_record_++];
      add_smooth(from, at, order, solution);
      if (!measuring_) return;
      solution(at, y_[0].data(), branch_);
      record(at);
      from = at;
    }
    add_smooth(from, to, order, solution);
  }
  /// Before and after an event sets states; the latter returns the energy that it brought to the stores. Stores whose
  /// energy is no function of what they hold alone are left out.
  void before_jump(double t, const double* x, const Branch& branch);
  double after_jump(double t, const double* x, const Branch& branch);

  template <class Archive>
  void carry(Archive& archive) {
    archive("by events", by_events_);
    archive("gross of events", gross_events_);
    archive("measuring", measuring_);
    archive("why not", why_not_);
    archive("totals", total_);
    archive("activity", activity_);
    archive("gross source", gross_source_);
    archive("gross dissipation", gross_dissipation_);
    archive("swing", swing_);
    archive("least power", least_power_);
    archive("least part", least_part_);
    archive.check(!least_part_ || *least_part_ < program_.energy_roles.size());
    archive("energy before", energy_before_);
    archive("displaced before", displaced_before_);
    archive("audited", audited_);
    archive("course", course_);
    while (next_record_ < record_times_.size() && record_times_[next_record_] <= audited_) ++next_record_;
    if (course_.times.empty()) next_record_ = record_times_.size();  // its beginning was not asked for
  }
  EnergyAudit finish(double t, const double* x, const Branch& branch);
  [[nodiscard]] double audited() const { return audited_; }  ///< the balance holds up to here
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  struct Rule : GaussRule {
    std::vector<std::vector<double>> fine;  ///< values at equal distances from the values at the positions
  };
  struct Terms {
    CompensatedSum supplied, stored, dissipated, exchanged, residual;
  };
  template <class Solution>
  void add_smooth(double from, double to, int order, Solution&& solution) {
    if (!measuring_ || !(to > from)) return;
    // Where the solution is a straight line a step may be most of the run, but powers need not be polynomials of it.
    // (Of the shortest scene that there is, 5e-324 s, a sixty-fourth is 0.)
    const double pieces = longest_ > 0.0 ? std::clamp(std::ceil((to - from) / longest_), 1.0, kMostPieces) : 1.0;
    const Rule& rule = pieces > 1.0 ? rules_.back() : rules_[rule_for(order)];
    const double length = (to - from) / pieces;
    start_stretch();
    for (double piece = 0.0; piece < pieces && measuring_; ++piece) {
      for (std::size_t i = 0; i < rule.position.size() && measuring_;)
        i = add_points(rule, i, from, piece, length, solution);
      if (measuring_) add_activities(rule, length);
    }
    finish_stretch();
  }
  /// The points from @p first on, as many as the evaluator takes at once. @return  the next one
  template <class Solution>
  std::size_t add_points(const Rule& rule, std::size_t first, double from, double piece, double length,
                         Solution&& solution) {
    Evaluator::Points at;
    at.count = together_ ? std::min(rule.position.size() - first, Evaluator::Points::kMost) : 1;
    bool same = true;  // modes that are held differ from point to point
    for (std::size_t k = 0; k < at.count; ++k) {
      at.t[k] = from + length * (piece + rule.position[first + k]);
      solution(at.t[k], y_[k].data(), branch_);
      if (k == 0 && at.count > 1) modes_ = branch_.modes;
      same = same && (k == 0 || branch_.modes == modes_);
      at.x[k] = y_[k].data();
      at.values[k] = power_[k].data();
    }
    const bool known = at.count > 1 && same && evaluator_.powers(at, branch_);
    for (std::size_t k = 0; k < at.count && measuring_; ++k) {
      if (!known) {
        if (at.count > 1) solution(at.t[k], y_[k].data(), branch_);
        if (!see_powers(at.t[k], k)) break;
      }
      add_point(first + k, k, at.t[k], length * rule.weight[first + k]);
    }
    return first + at.count;
  }
  static constexpr double kMostPieces = 64.0;  ///< of the run, or of a stretch of it up to the run's end
  static Rule rule_with(int points);
  /// By number of points, from 1 on.
  static const std::vector<Rule>& all_rules();
  [[nodiscard]] std::size_t rule_for(int order) const;
  void start_stretch();
  bool see_powers(double t, std::size_t k);
  void add_point(std::size_t point, std::size_t k, double t, double weight);
  void add_activities(const Rule& rule, double length);
  void finish_stretch();
  void give_up(const std::string& why);
  bool look_at_stores(double t, const double* x, const char* when);
  [[nodiscard]] Terms terms() const;
  void record(double t);
  void append(double t, const Terms& now);
  [[nodiscard]] std::optional<double> change_of_store(std::size_t part) const {
    return change_of_store(part, energy_before_, displaced_before_);
  }
  [[nodiscard]] std::optional<double> change_of_store(std::size_t part, const std::vector<double>& energy,
                                                      const std::vector<double>& displaced) const;

  const Program& program_;
  Evaluator& evaluator_;
  bool measuring_;
  double audited_ = 0.0, seconds_ = 0.0;
  /// What the rule is applied to in one piece. No part of a snapshot: a run may be continued to another end.
  const double longest_;
  std::string why_not_;
  Branch branch_;        ///< at y_
  const bool together_;  ///< powers of several points are evaluated at once
  std::vector<double> modes_;
  const std::vector<Rule>& rules_;
  std::array<std::vector<double>, Evaluator::Points::kMost> y_, power_;  ///< of points that are evaluated at once
  std::vector<double> stretch_, activity_, samples_;                     ///< samples: powers by part and point
  std::vector<CompensatedSum> total_;                                    ///< by energy part, then by port of fields
  double gross_source_ = 0.0, gross_dissipation_ = 0.0, swing_ = 0.0;
  void take_least(std::size_t part, std::size_t k, double t);
  double least_power_ = 0.0;
  std::optional<std::size_t> least_part_;
  std::vector<double> rounding_;  ///< of powers, at rounding_at_
  double rounding_at_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> energy_before_, energy_after_, displaced_before_, displaced_after_;
  CompensatedSum by_events_;
  double gross_events_ = 0.0;
  std::vector<double> energy_at_jump_, displaced_at_jump_;
  std::vector<double> record_times_;  ///< none left: no course is asked for, or it is complete
  std::size_t next_record_ = 0;
  EnergyCourse course_;
};

}  // namespace bgsim
