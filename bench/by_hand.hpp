/// Models as a user writes them who has the equations on paper: a function for the rates, one for the Jacobian, CVODE.
#pragma once

#include <functional>
#include <memory>
#include <vector>

namespace bgsim::bench {

/// What CVODE is given for one model.
struct ByHand {
  virtual ~ByHand() = default;
  virtual void rates(double t, const double* x, double* f) const = 0;
  /// Dense: all entries by columns. Sparse: `values` in the order of `column_start` and `row`.
  virtual void jacobian(double t, const double* x, double* values) const = 0;
  virtual void outputs(double t, const double* x, double* values) const = 0;

  std::vector<double> start;
  std::vector<double> scale;            ///< the absolute tolerances are these times the relative one
  std::vector<long> column_start, row;  ///< of a sparse Jacobian; empty: it is dense
  std::size_t output_count = 0;
};

struct HandRun {
  bool whole = false;
  long steps = 0;
  std::vector<std::vector<double>> columns;  ///< by output, at all times
};

/// CVODE's BDF from times.front() to times.back(), interpolated at all times: the packaged library with its own vectors
/// and its dense solver or KLU.
HandRun run_by_hand(const ByHand& model, const std::vector<double>& times, double relative);

/// The scenes of models/bellow.json ("tracking", "step", "literal", "physical"); outputs in the order of the file.
std::unique_ptr<ByHand> bellow_by_hand(const char* scene);
/// Of models/actuator.json ("bending", "extension").
std::unique_ptr<ByHand> actuator_by_hand(const char* scene);
/// A line of n resistors and n capacitors, all 1/n, on a source of 1; voltages at `nodes`.
std::unique_ptr<ByHand> ladder_by_hand(std::size_t n, const std::vector<std::size_t>& nodes);
/// n masses of 1 in a row, springs q + q^3 between them, a resistance of 0.01 on each; the first spring is moved by a
/// velocity of sin(t)/2. Velocities of `masses`.
std::unique_ptr<ByHand> chain_by_hand(std::size_t n, const std::vector<std::size_t>& masses);
/// n x n nodes in a plane, resistors and capacitors of 1, a source of sin(t) at the corner; voltages of `nodes`, by
/// rows.
std::unique_ptr<ByHand> grid_by_hand(std::size_t n, const std::vector<std::size_t>& nodes);

}  // namespace bgsim::bench
