/// Where the entries of a pattern are in a compressed matrix that has the diagonal of the states, too.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "bgsim/program.hpp"
#include "run/integrate/row_scales.hpp"

namespace bgsim {

struct SparsePlaces {
  /// @param states  of the pattern's unknowns, the first ones
  SparsePlaces(const Sparsity& of, std::size_t states) : scales(of.size, 1.0), pattern(of) {
    const auto n = static_cast<Eigen::Index>(pattern.size), with_diagonal = static_cast<Eigen::Index>(states);
    std::vector<Eigen::Triplet<double>> places;
    places.reserve(pattern.row.size() + states);
    each(pattern,
         [&](Eigen::Index row, Eigen::Index column) { places.emplace_back(to_int(row), to_int(column), 1.0); });
    for (Eigen::Index i = 0; i < with_diagonal; ++i) places.emplace_back(to_int(i), to_int(i), 1.0);
    matrix.resize(n, n);
    matrix.setFromTriplets(places.begin(), places.end());
    entries.reserve(pattern.row.size());
    each(pattern, [&](Eigen::Index row, Eigen::Index column) { entries.push_back(find(row, column)); });
    for (Eigen::Index i = 0; i < with_diagonal; ++i) of_states.push_back(find(i, i));
  }

  /// The scales of the rows (row_scales.hpp), and -h J by these into `matrix`. False if it is not finite.
  bool fill(double shift, double h, const double* jacobian, const double* weight) {
    row_scales::of_entries(pattern, of_states.size(), shift, h, jacobian, weight, scales);
    double* const values = matrix.valuePtr();
    std::fill(values, values + matrix.nonZeros(), 0.0);
    for (std::size_t k = 0; k < entries.size(); ++k) {
      values[entries[k]] = -h * jacobian[k] * scales[static_cast<std::size_t>(pattern.row[k])];
      if (!std::isfinite(values[entries[k]])) return false;
    }
    return true;
  }
  /// Adds to the diagonal of the states, by their scales.
  void shift(double by) {
    double* const values = matrix.valuePtr();
    for (std::size_t i = 0; i < of_states.size(); ++i) values[of_states[i]] += by * scales[i];
  }
  [[nodiscard]] Eigen::Map<const Eigen::ArrayXd> scale_of_rows() const {
    return {scales.data(), static_cast<Eigen::Index>(scales.size())};
  }

  Eigen::SparseMatrix<double> matrix;
  std::vector<Eigen::Index> entries;    ///< of the pattern, among its values
  std::vector<Eigen::Index> of_states;  ///< the states' diagonal, the same
  std::vector<double> scales;           ///< of the rows

 private:
  const Sparsity& pattern;
  static int to_int(Eigen::Index i) { return static_cast<int>(i); }
  template <class Visit>
  static void each(const Sparsity& pattern, Visit&& visit) {
    for (std::size_t column = 0; column < pattern.size; ++column)
      for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
           k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
        visit(static_cast<Eigen::Index>(pattern.row[k]), static_cast<Eigen::Index>(column));
  }
  [[nodiscard]] Eigen::Index find(Eigen::Index row, Eigen::Index column) const {
    const auto* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column];
    const auto* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, to_int(row)) - matrix.innerIndexPtr();
  }
};

}  // namespace bgsim
