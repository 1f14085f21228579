/// The dense output of a step as a polynomial whose range over any part of the step is known.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "program/enclosure.hpp"

namespace bgsim {

/// Every integrator's dense output is a polynomial of known degree. Samples of it determine its Bernstein coefficients
/// on the step; de Casteljau's subdivision gives those on any part of the step, and the values lie between the least
/// and the largest of them.
class StepPolynomial {
 public:
  /// The integrator's method of the highest order, Adams.
  static constexpr int kHighestDegree = 12;

  /// @param unknowns  positions in what @p at gives: those that will be asked for.
  /// @param at        the dense output at a time within [begin, end]; called degree + 1 times, in order.
  void take(double begin, double end, int degree, std::span<const std::uint32_t> unknowns, std::size_t size,
            const std::function<void(double t, double* y)>& at);

  [[nodiscard]] double begin() const { return begin_; }
  [[nodiscard]] double end() const { return end_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The unknown at position @p which of the list, over [from, to] within the step.
  [[nodiscard]] Jet over(std::size_t which, double from, double to) const;
  /// All of them.
  void over(double from, double to, std::vector<Jet>& jets) const;
  /// Its value and its slope at a time within the step.
  [[nodiscard]] std::pair<double, double> at(std::size_t which, double t) const;
  /// The same of all of them.
  void at(double t, double* values, double* slopes) const;

 private:
  template <class Degree>
  void at(Degree degree, double t, double* values, double* slopes) const;

  double begin_ = 0.0, end_ = 0.0;
  std::size_t count_ = 0, degree_ = 0;
  std::vector<double> coefficients_;  ///< by unknown, degree + 1 of each
  std::vector<double> samples_, y_;
};

}  // namespace bgsim
