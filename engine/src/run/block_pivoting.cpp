#include "run/block_pivoting.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace bgsim {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Index = Eigen::Index;

constexpr std::size_t kKnown = 3;  ///< terms that are taken from the problem, from h^0 on
constexpr int kBehind = static_cast<int>(kKnown);
constexpr auto kLevels = static_cast<std::size_t>(PowerSeries::kTerms);  ///< of what is solved for, from h^-kBehind on
constexpr double kRounding = std::numeric_limits<double>::epsilon();
/// Pivots below this part of the largest are those of a singular matrix, above the second those of a regular one.
constexpr double kSingular = 1e-12, kRegular = 1e-9;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// The columns that are basic, as rows of series: divided by powers of h and combined, so that the leading
/// coefficients are a regular matrix.
class BasisRows {
 public:
  BasisRows(const Complementarity& problem, const std::vector<bool>& takes_z)
      : n_(static_cast<Index>(problem.size)),
        cells_(problem.size),
        right_(kLevels, Vector::Zero(n_)),
        right_off_(right_),
        terms_(problem.size, PowerSeries::kExact),
        lost_(problem.size, false) {
    for (Index i = 0; i < n_; ++i) {
      for (const bool z : {true, false})
        for (const auto& [column, value] : (z ? problem.z : problem.w)[at(i)]) {
          if (takes_z[column] != z || value.zero) continue;
          Cell& cell = cells_[at(i)].emplace_back();
          cell.column = static_cast<Index>(column);
          take(value, i, [&](std::size_t k, double term, double off) {
            cell.term[k] = term;
            cell.off[k] = off;
          });
        }
      sort_row(cells_[at(i)]);
      take(problem.r[at(i)], i, [&](std::size_t k, double value, double off) {
        right_[k + kKnown](i) = value;
        right_off_[k + kKnown](i) = off;
      });
    }
  }

  enum class Found : std::uint8_t { regular, singular, unclear };

  /// @param dependent  where it is singular: columns that the others determine
  Found reduce(std::vector<std::size_t>& dependent) {
    if (!possible_) return Found::unclear;
    for (Index i = 0; i < n_; ++i) begin_with_a_number(i);
    for (bool changed = true; changed;) {
      changed = false;
      dependent.clear();
      find_parts();
      for (const Part& part : parts_)
        if (!combine(part, dependent, changed)) return Found::unclear;
    }
    return dependent.empty() ? Found::regular : Found::singular;
  }

  /// Of the basic variables. @pre reduce() has found it regular.
  std::vector<PowerSeries> solve() {
    for (Part& part : parts_) part.inverse = matrix_of(part).inverse();
    std::vector<int> known(at(n_), PowerSeries::kExact);
    std::vector<Vector> x, off;
    for (std::size_t order = 0; order < kLevels; ++order) {
      Vector right = right_[order], right_off = right_off_[order] + kRounding * right.cwiseAbs();
      std::vector<bool> unknown(at(n_));
      for (Index i = 0; i < n_; ++i) unknown[at(i)] = static_cast<int>(order) - kBehind >= terms_[at(i)];
      for (std::size_t lower = 0; lower < order; ++lower)
        subtract(order, lower, x, off, known, right, right_off, unknown);
      x.emplace_back(Vector::Zero(n_));
      off.emplace_back(Vector::Zero(n_));
      for (const Part& part : parts_) {
        solve_part(part, right, right_off, x.back(), off.back());
        if (std::none_of(part.rows.begin(), part.rows.end(), [&](Index i) { return unknown[at(i)]; })) continue;
        for (const Index j : part.columns) known[at(j)] = std::min(known[at(j)], static_cast<int>(order));
      }
    }
    std::vector<PowerSeries> values;
    for (Index j = 0; j < n_; ++j) {
      std::array<double, kLevels> value{}, rounding{};
      for (std::size_t k = 0; k < kLevels; ++k) {
        value[k] = x[k](j);
        rounding[k] = off[k](j);
      }
      // What is behind the last order is not known either, unless all ends before.
      const bool exact = known[at(j)] == PowerSeries::kExact && x.back()(j) == 0.0;
      const PowerSeries s = PowerSeries::of(value, rounding, exact);
      values.push_back((exact ? s : s.known_below(known[at(j)])).times_power(-kBehind));
    }
    return values;
  }

 private:
  struct Part {
    std::vector<Index> rows, columns;
    Matrix inverse;
  };
  /// What a row has in one column, by powers of h.
  struct Cell {
    Index column = 0;
    std::array<double, kKnown> term{}, off{};
  };
  static void sort_row(std::vector<Cell>& row) {
    std::sort(row.begin(), row.end(), [](const Cell& a, const Cell& b) { return a.column < b.column; });
  }

  template <class Put>
  void take(const PowerSeries& s, Index row, const Put& put) {
    if (s.known != PowerSeries::kExact) terms_[at(row)] = static_cast<int>(kKnown);
    possible_ = possible_ && s.known >= static_cast<int>(kKnown) && (s.zero || s.order >= 0);
    for (int k = 0; k < PowerSeries::kTerms && !s.zero; ++k) {
      const int power = s.order + k;
      const double value = s.coefficient[static_cast<std::size_t>(k)];
      const bool inside = power >= 0 && power < static_cast<int>(kKnown);
      if (inside) put(static_cast<std::size_t>(power), value, s.rounding[static_cast<std::size_t>(k)]);
      if (!inside && value != 0.0) terms_[at(row)] = static_cast<int>(kKnown);
    }
  }

  /// Divides a row by h until its leading coefficients are not all 0. Where nothing is left of it, it is lost.
  void begin_with_a_number(Index row) {
    std::vector<Cell>& cells = cells_[at(row)];
    const auto empty = [&cells](std::size_t k) {
      return std::all_of(cells.begin(), cells.end(), [k](const Cell& cell) { return cell.term[k] == 0.0; });
    };
    if (!empty(0)) return;
    std::size_t first = 1;
    while (first < kKnown && empty(first)) ++first;
    if (first == kKnown || terms_[at(row)] <= static_cast<int>(first)) {
      lost_[at(row)] = true;
      return;
    }
    for (Cell& cell : cells)
      for (std::size_t k = 0; k < kKnown; ++k) {
        const bool inside = k + first < kKnown;
        cell.term[k] = inside ? cell.term[k + first] : 0.0;
        cell.off[k] = inside ? cell.off[k + first] : 0.0;
      }
    for (std::size_t k = 0; k < kLevels; ++k) {
      const bool inside = k + first < kLevels;
      right_[k](row) = inside ? right_[k + first](row) : 0.0;
      right_off_[k](row) = inside ? right_off_[k + first](row) : 0.0;
    }
    if (terms_[at(row)] != PowerSeries::kExact) terms_[at(row)] -= static_cast<int>(first);
  }

  /// Rows and columns that the leading coefficients tie to each other.
  void find_parts() {
    std::vector<std::size_t> up(2 * at(n_));
    std::iota(up.begin(), up.end(), std::size_t{0});
    const auto top = [&up](std::size_t i) {
      while (up[i] != i) i = up[i] = up[up[i]];
      return i;
    };
    for (Index i = 0; i < n_; ++i)
      for (const Cell& cell : cells_[at(i)])
        if (cell.term[0] != 0.0) up[top(at(i))] = top(at(n_ + cell.column));
    constexpr auto kNone = static_cast<std::size_t>(-1);
    std::vector<std::size_t> part_of(up.size(), kNone);
    parts_.clear();
    for (Index i = 0; i < 2 * n_; ++i) {
      if (i < n_ && lost_[at(i)]) continue;
      std::size_t& part = part_of[top(at(i))];
      if (part == kNone) {
        part = parts_.size();
        parts_.emplace_back();
      }
      (i < n_ ? parts_[part].rows : parts_[part].columns).push_back(i < n_ ? i : i - n_);
    }
    part_of_.assign(at(n_), kNone);
    place_.assign(at(n_), 0);
    for (std::size_t part = 0; part < parts_.size(); ++part)
      for (std::size_t k = 0; k < parts_[part].columns.size(); ++k) {
        part_of_[at(parts_[part].columns[k])] = part;
        place_[at(parts_[part].columns[k])] = static_cast<Index>(k);
      }
  }

  [[nodiscard]] Matrix matrix_of(const Part& part) const {
    Matrix m = Matrix::Zero(static_cast<Index>(part.rows.size()), static_cast<Index>(part.columns.size()));
    for (Index i = 0; i < m.rows(); ++i)
      for (const Cell& cell : cells_[at(part.rows[at(i)])])
        if (cell.term[0] != 0.0) m(i, place_[at(cell.column)]) = cell.term[0];
    return m;
  }

  /// Rows that others determine at the leading order are replaced by what is left of them. False where rounding
  /// decides which ones.
  bool combine(const Part& part, std::vector<std::size_t>& dependent, bool& changed) {
    Matrix m = matrix_of(part);
    if (m.size() == 1) return true;
    Vector scale = Vector::Ones(m.rows());
    for (int pass = 0; pass < 2 && m.size() > 0; ++pass) {
      for (Index i = 0; i < m.rows(); ++i) {
        const double largest = m.row(i).cwiseAbs().maxCoeff();
        m.row(i) /= largest;
        scale(i) *= largest;
      }
      for (Index j = 0; j < m.cols(); ++j) m.col(j) /= m.col(j).cwiseAbs().maxCoeff();
    }
    if (m.rows() == m.cols()) {
      const Eigen::PartialPivLU<Matrix> lu(m);
      // The estimate is meaningless where a pivot is 0.
      if (lu.matrixLU().diagonal().cwiseAbs().minCoeff() > kRegular && lu.rcond() > kRegular) return true;
    }
    Index rank = 0;
    std::vector<Index> columns(at(m.cols()));
    std::iota(columns.begin(), columns.end(), Index{0});
    if (m.size() > 0) {
      const Eigen::FullPivLU<Matrix> lu(m);
      const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
      while (rank < pivots.size() && pivots(rank) > kSingular * pivots(0)) {
        if (pivots(rank) < kRegular * pivots(0)) return false;
        ++rank;
      }
      for (Index j = 0; j < m.cols(); ++j) columns[at(j)] = lu.permutationQ().indices()(j);
      const auto lower = lu.matrixLU().topLeftCorner(rank, rank).triangularView<Eigen::UnitLower>();
      const auto origin = lu.permutationP().inverse().eval();
      for (Index i = rank; i < m.rows(); ++i) {
        const Vector l = lu.matrixLU().row(i).head(rank).transpose();
        Vector multiples = lower.transpose().solve(l);
        std::vector<Index> others;
        for (Index p = 0; p < rank; ++p) {
          others.push_back(part.rows[at(origin.indices()(p))]);
          multiples(p) *= scale(origin.indices()(i)) / scale(origin.indices()(p));
        }
        leave_rest(part.rows[at(origin.indices()(i))], others, multiples);
        changed = true;
      }
    }
    for (Index j = rank; j < m.cols(); ++j) dependent.push_back(at(part.columns[at(columns[at(j)])]));
    return true;
  }

  /// A row less multiples of others, which leaves nothing of its leading coefficients.
  void leave_rest(Index row, const std::vector<Index>& others, const Vector& multiples) {
    constexpr double kOfTerms = 16.0 * kRounding;
    std::vector<Cell> rest = cells_[at(row)];
    for (Cell& cell : rest)
      for (std::size_t k = 0; k < kKnown; ++k) cell.off[k] += kOfTerms * std::abs(cell.term[k]);
    std::vector<std::size_t> found(at(n_), rest.max_size());  // by column: which cell
    for (std::size_t c = 0; c < rest.size(); ++c) found[at(rest[c].column)] = c;
    for (std::size_t p = 0; p < others.size(); ++p) {
      const double y = multiples(static_cast<Index>(p));
      for (const Cell& other : cells_[at(others[p])]) {
        std::size_t& c = found[at(other.column)];
        if (c == rest.max_size()) {
          c = rest.size();
          rest.emplace_back().column = other.column;
        }
        for (std::size_t k = 0; k < kKnown; ++k) {
          rest[c].term[k] -= y * other.term[k];
          rest[c].off[k] += std::abs(y) * (other.off[k] + kOfTerms * std::abs(other.term[k]));
        }
      }
    }
    sort_row(rest);
    for (Cell& cell : rest)
      for (std::size_t k = 0; k < kKnown; ++k)
        if (k == 0 || std::abs(cell.term[k]) <= cell.off[k]) cell.term[k] = 0.0;
    cells_[at(row)] = std::move(rest);
    for (std::size_t k = 0; k < kLevels; ++k) {
      double value = right_[k](row), off = right_off_[k](row) + kOfTerms * std::abs(value);
      for (std::size_t p = 0; p < others.size(); ++p) {
        const double y = multiples(static_cast<Index>(p));
        value -= y * right_[k](others[p]);
        off += std::abs(y) * (right_off_[k](others[p]) + kOfTerms * std::abs(right_[k](others[p])));
      }
      right_[k](row) = value;
      right_off_[k](row) = off;
    }
    for (const Index other : others) terms_[at(row)] = std::min(terms_[at(row)], terms_[at(other)]);
    begin_with_a_number(row);
  }

  /// What the terms of one order of the variables make at a higher one.
  void subtract(std::size_t order, std::size_t lower, const std::vector<Vector>& x, const std::vector<Vector>& off,
                const std::vector<int>& known, Vector& right, Vector& right_off, std::vector<bool>& unknown) const {
    const std::size_t k = order - lower;
    const Vector& value = x[lower];
    const Vector& error = off[lower];
    const auto take_away = [&](Index i, const Cell& cell) {
      const Index j = cell.column;
      const bool is_known = known[at(j)] > static_cast<int>(lower);
      if (is_known && value(j) == 0.0 && error(j) == 0.0) return;
      if (static_cast<int>(k) >= terms_[at(i)]) {
        // A term that is not known times one that is not 0.
        unknown[at(i)] = unknown[at(i)] || !is_known || value(j) != 0.0;
        return;
      }
      if (k >= kKnown) return;
      const double a = cell.term[k], a_off = cell.off[k];
      unknown[at(i)] = unknown[at(i)] || (!is_known && a != 0.0);
      right(i) -= a * value(j);
      right_off(i) += std::abs(a) * error(j) + a_off * std::abs(value(j)) + 4.0 * kRounding * std::abs(a * value(j));
    };
    for (Index i = 0; i < n_; ++i)
      for (const Cell& cell : cells_[at(i)])
        if (cell.term != std::array<double, kKnown>{}) take_away(i, cell);
  }

  void solve_part(const Part& part, const Vector& right, const Vector& right_off, Vector& x, Vector& off) const {
    const auto size = static_cast<Index>(part.rows.size());
    Vector own(size), own_off(size);
    for (Index i = 0; i < size; ++i) {
      own(i) = right(part.rows[at(i)]);
      own_off(i) = right_off(part.rows[at(i)]);
    }
    if (own.isZero(0.0) && own_off.isZero(0.0)) return;
    const Matrix m = matrix_of(part);
    Vector value = part.inverse * own;
    value += part.inverse * (own - m * value);
    const std::size_t own_part = part_of_[at(part.columns.front())];
    for (Index i = 0; i < size; ++i)
      for (const Cell& cell : cells_[at(part.rows[at(i)])]) {
        if (part_of_[at(cell.column)] != own_part) continue;
        own_off(i) +=
            (cell.off[0] + 4.0 * kRounding * std::abs(cell.term[0])) * std::abs(value(place_[at(cell.column)]));
      }
    const Vector error = part.inverse.cwiseAbs() * own_off;
    for (Index j = 0; j < size; ++j) {
      off(part.columns[at(j)]) = error(j);
      x(part.columns[at(j)]) = std::abs(value(j)) > error(j) ? value(j) : 0.0;
    }
  }

  Index n_;
  std::vector<std::vector<Cell>> cells_;   ///< by row, then column
  std::vector<Vector> right_, right_off_;  ///< by order, from h^-kBehind on
  std::vector<int> terms_;                 ///< by row: how many of its coefficients are known
  std::vector<bool> lost_;                 ///< by row
  std::vector<Part> parts_;
  std::vector<std::size_t> part_of_;  ///< by column
  std::vector<Index> place_;          ///< by column: in its part
  bool possible_ = true;
};

}  // namespace

std::optional<ComplementarySides> solve_by_blocks(const Complementarity& problem, const std::vector<bool>& first,
                                                  const std::vector<bool>& held) {
  constexpr int kMostBases = 60, kPatience = 10;
  ComplementarySides sides;
  sides.takes_z.resize(problem.size);
  for (std::size_t i = 0; i < problem.size; ++i) sides.takes_z[i] = first[i] && !held[i];
  std::vector<bool> other(problem.size, false);  // where the wanted one depends on others
  std::size_t fewest = problem.size + 1;
  int patience = kPatience;
  for (int count = 0; count < kMostBases; ++count) {
    BasisRows basis(problem, sides.takes_z);
    std::vector<std::size_t> dependent;
    const BasisRows::Found found = basis.reduce(dependent);
    if (found == BasisRows::Found::unclear) return std::nullopt;
    if (found == BasisRows::Found::singular) {
      for (const std::size_t i : dependent) {
        if (other[i]) return std::nullopt;
        other[i] = true;
        sides.takes_z[i] = !sides.takes_z[i];
      }
      continue;
    }
    sides.value = basis.solve();
    other.assign(problem.size, false);
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < problem.size; ++i) {
      const int sign = sides.value[i].sign();
      if (held[i] && sides.takes_z[i] && sign != 0) return std::nullopt;
      if (!held[i] && sign < 0) wrong.push_back(i);
    }
    sides.solved = wrong.empty();
    if (sides.solved) return sides;
    // All at once, as long as they get fewer; then the last one, which ends where each basis is regular (Murty).
    if (wrong.size() < fewest) {
      fewest = wrong.size();
      patience = kPatience;
    } else if (patience-- <= 0) {
      wrong = {wrong.back()};
    }
    for (const std::size_t i : wrong) sides.takes_z[i] = !sides.takes_z[i];
  }
  return std::nullopt;
}

}  // namespace bgsim
