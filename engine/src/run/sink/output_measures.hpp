/// What the outputs are over a run: extremes, integrals, and when.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/sink/energy_audit.hpp"

namespace bgsim {

/// Measures each output on the dense output. Integrals by Gauss' rule with as many points as the energy audit takes.
/// Extremes are looked for among these points and the ends of each step; where one may be the largest so far, the dense
/// output between its neighbours is searched by Brent's method, so that what lies between the points is found, too.
class OutputMeasures {
 public:
  OutputMeasures(const Program& program, Evaluator& evaluator, bool wanted);

  /// Puts the solution at a time into the states, with the branch of a point nearby.
  using Solution = std::function<void(double t, double* x, Branch& branch)>;

  /// @param stop  the run's end.
  void begin(double t, const double* x, const Branch& branch, double stop);
  /// On to @p to, over a stretch on which the solution is smooth; @p order is that of its polynomial.
  void add(double to, int order, const Branch& branch, const Solution& solution);
  /// Where the run ended. Empty if it measured nothing, or an output had no value on the way.
  std::vector<OutputMeasure> finish(double t, const double* x, const Branch& branch);
  [[nodiscard]] const std::string& why_not() const { return why_not_; }

 private:
  struct Sample {
    double t = 0.0;
    std::vector<double> row;
  };
  bool evaluate(double t, const double* x, std::vector<double>& row);
  void add_piece(double from, double to, int order, const Solution& solution);
  void look_for_extreme(std::size_t output, double sign, const Solution& solution);
  void take(std::size_t output, double t, double value);

  Evaluator& evaluator_;
  bool measuring_;
  std::string why_not_;
  double measured_ = 0.0;
  double longest_ = 0.0;  ///< stretch that the rule is applied to in one piece
  Branch branch_;
  std::vector<double> x_, row_;
  std::vector<Sample> samples_;  ///< of the present piece: its beginning, the rule's points, its end
  std::vector<OutputMeasure> measures_;
  std::vector<CompensatedSum> integral_, square_;
};

/// What two parts of a run that follow each other measured, as one.
void append(std::vector<OutputMeasure>& whole, const std::vector<OutputMeasure>& part);

}  // namespace bgsim
