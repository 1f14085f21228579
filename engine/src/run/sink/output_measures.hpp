/// What the outputs are over a run: extremes, integrals, and when.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/sink/energy_audit.hpp"
#include "run/sink/gauss_rule.hpp"
#include "run/sink/output_bounds.hpp"

namespace bgsim {

/// Measures each output on the dense output. Integrals by Gauss' rule with as many points as the energy audit takes,
/// over parts of a step on which it agrees with the same rule over both halves: an output may vary faster than the
/// states, for which the step is made, and on which its enclosure leaves no room for more than they show. Extremes are
/// looked for among these points and the ends of each step; where one may be the largest so far, the dense output
/// between its neighbours is searched by Brent's method, so that what lies between the points is found, too. Of several
/// peaks that are as high to the run's tolerance the first gives the time: which of them is higher by a rounding says
/// nothing.
class OutputMeasures {
 public:
  OutputMeasures(const Program& program, std::span<const double> parameters, Evaluator& evaluator, bool wanted);

  /// Puts the solution at a time into the states, with the branch of a point nearby.
  using Solution = std::function<void(double t, double* x, Branch& branch)>;

  /// @param stop  the run's end.
  /// @param relative  to this the integrals over each part agree with those over its halves.
  void begin(double t, const double* x, const Branch& branch, double stop, double relative);
  /// At an instant of which no stretch knows: conditions have changed and what they set off has not been done yet.
  void look(double t, const double* x, const Branch& branch);
  /// On to @p to, over a stretch on which the solution is smooth; @p order is that of its polynomial.
  void add(double to, int order, const Branch& branch, const Solution& solution);
  /// Where the run ended. Empty if it measured nothing, or an output had no value on the way.
  std::vector<OutputMeasure> finish(double t, const double* x, const Branch& branch);
  [[nodiscard]] const std::string& why_not() const { return why_not_; }
  /// Outputs whose integrals are less accurate than asked for, since all parts that the run may take were used up.
  [[nodiscard]] const std::vector<std::size_t>& coarse() const { return coarse_; }

 private:
  struct Sample {
    double t = 0.0;
    std::vector<double> row;
  };
  struct Piece {
    double from = 0.0, to = 0.0;
    std::vector<Sample> samples;                 ///< its beginning, the rule's points, its end
    std::vector<std::vector<double>> states;     ///< at these, where outputs are enclosed
    std::vector<double> integral, square, size;  ///< by output; of the magnitude
  };
  bool evaluate(double t, const double* x, std::vector<double>& row);
  bool measure(Piece& piece, double from, double to, int order, const Solution& solution);
  /// Whether an output's integrals over the whole and over its halves differ, or its values at the ends from those of
  /// the polynomial through the points of both halves: a kink before the first point or behind the last one is seen by
  /// neither rule.
  [[nodiscard]] bool differ(const Piece& whole, const std::array<Piece, 2>& halves) const;
  /// By how much the output's values at the piece's ends differ from that polynomial, at most.
  [[nodiscard]] static double off_at_ends(const std::array<Piece, 2>& halves, std::size_t output,
                                          const GaussRule& rule);
  bool enclose(std::span<const Piece> pieces);
  double found_in(double from, double to, std::size_t which, const Solution& solution);
  /// Whether an output may be something else between the points of the halves: by more than they differ, and than
  /// matters beside the largest that it is known to be.
  bool hide(const std::array<Piece, 2>& halves, bool whole, const Solution& solution);
  /// Magnitude of an output so far, or in a pulse of the piece that is being halved.
  [[nodiscard]] double largest(std::size_t output) const;
  void add_piece(const Piece& piece, int order, std::size_t depth, const Solution& solution);
  void look_for_extreme(const std::vector<Sample>& samples, std::size_t output, double sign, const Solution& solution);
  void take(std::size_t output, double t, double value);

  /// Of the largest value, or of the smallest with the other sign: the one whose time is kept, and whether the output
  /// has clearly come down from there since.
  struct Peak {
    double value = 0.0;
    bool left = false;
  };
  static void take(Peak& peak, double value, double t, double within, double& most, double& at);

  Evaluator& evaluator_;
  bool measuring_;
  std::optional<OutputBounds> bounds_;
  std::vector<double> modes_, times_;        ///< of the bounds: modes; points of two halves
  std::vector<std::vector<double>> states_;  ///< there
  std::string why_not_;
  double measured_ = 0.0;
  double longest_ = 0.0;  ///< stretch that the rule is applied to in one piece
  Branch branch_;
  std::vector<double> x_, row_;
  std::vector<bool> hidden_;   ///< by output: what it is between points was left open
  std::vector<double> found_;  ///< by output: the largest in a pulse of the piece that is halved first
  Piece piece_, probe_;
  std::deque<std::array<Piece, 2>> halves_;  ///< of the present piece, of one of these, ...
  int spare_ = 0, spare_here_ = 0;           ///< parts that may still be halved: of the run, of a step's piece
  double relative_ = 0.0, span_ = 0.0;
  std::vector<std::size_t> coarse_;
  std::vector<OutputMeasure> measures_;
  std::vector<CompensatedSum> integral_, square_, size_, left_;  ///< left: differences from the halves
  std::vector<std::array<Peak, 2>> peaks_;
  std::vector<std::pair<double, double>> extremes_;  ///< of a piece: time, value
};

/// What two parts of a run that follow each other measured, as one.
void append(std::vector<OutputMeasure>& whole, const std::vector<OutputMeasure>& part);

}  // namespace bgsim
