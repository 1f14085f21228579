#include "run/complementarity.hpp"

#include <algorithm>
#include <optional>

#include "run/block_pivoting.hpp"

namespace bgsim {
namespace {

/// Columns: z, w, the covering variable, the right side.
class Tableau {
 public:
  explicit Tableau(const Complementarity& problem)
      : n_(problem.size), columns_(2 * n_ + 2), cells_(n_ * columns_), basis_(n_, kNone), is_basic_(2 * n_ + 1, false) {
    for (std::size_t i = 0; i < n_; ++i) {
      for (const Complementarity::Entry& entry : problem.z[i]) at(i, entry.column) = entry.value;
      for (const Complementarity::Entry& entry : problem.w[i]) at(i, n_ + entry.column) = entry.value;
      at(i, right()) = problem.r[i];
    }
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  [[nodiscard]] std::size_t cover() const { return 2 * n_; }
  [[nodiscard]] std::size_t right() const { return 2 * n_ + 1; }
  [[nodiscard]] std::size_t partner(std::size_t column) const { return column < n_ ? column + n_ : column - n_; }
  [[nodiscard]] std::size_t pair(std::size_t column) const { return column % n_; }
  PowerSeries& at(std::size_t row, std::size_t column) { return cells_[row * columns_ + column]; }
  [[nodiscard]] std::size_t basic(std::size_t row) const { return basis_[row]; }
  [[nodiscard]] bool is_basic(std::size_t column) const { return is_basic_[column]; }

  void pivot(std::size_t row, std::size_t column) {
    const PowerSeries factor = PowerSeries::number(1.0) / at(row, column);
    for (std::size_t j = 0; j < columns_; ++j)
      if (!at(row, j).zero) at(row, j) = j == column ? PowerSeries::number(1.0) : at(row, j) * factor;
    for (std::size_t i = 0; i < n_; ++i) {
      if (i == row || at(i, column).zero) continue;
      const PowerSeries multiple = at(i, column);
      for (std::size_t j = 0; j < columns_; ++j)
        if (!at(row, j).zero) at(i, j) = j == column ? PowerSeries() : at(i, j) - multiple * at(row, j);
    }
    if (basis_[row] != kNone) is_basic_[basis_[row]] = false;
    basis_[row] = column;
    is_basic_[column] = true;
  }

  /// The row without a basic variable in which the column's entry is of the lowest order, and largest there.
  std::optional<std::size_t> free_row(std::size_t column) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < n_; ++i) {
      const PowerSeries& cell = at(i, column);
      if (basis_[i] != kNone || cell.zero) continue;
      const auto better = [&](const PowerSeries& than) {
        return cell.order != than.order ? cell.order < than.order
                                        : std::abs(cell.coefficient[0]) > std::abs(than.coefficient[0]);
      };
      if (!best || better(at(*best, column))) best = i;
    }
    return best;
  }

 private:
  std::size_t n_, columns_;
  std::vector<PowerSeries> cells_;
  std::vector<std::size_t> basis_;
  std::vector<bool> is_basic_;
};

class Lemke {
 public:
  Lemke(const Complementarity& problem, const std::vector<bool>& first, const std::vector<bool>& held)
      : n_(problem.size), held_(held), table_(problem), complete_(find_basis(first)) {}

  ComplementarySides run() {
    ComplementarySides sides;
    if (complete_) solve(sides);
    sides.takes_z.resize(n_);
    sides.value.resize(n_);
    for (std::size_t row = 0; row < n_; ++row) {
      const std::size_t column = table_.basic(row);
      if (column == Tableau::kNone || column == table_.cover()) continue;
      sides.takes_z[table_.pair(column)] = column < n_;
      sides.value[table_.pair(column)] = table_.at(row, table_.right());
    }
    return sides;
  }

 private:
  /// One of each pair, such that the others at 0 determine them. For a monotone relation there is one whatever is
  /// chosen before; where neither of a pair has a row left, the relation is not monotone.
  bool find_basis(const std::vector<bool>& first) {
    // Held pairs go first: where w_i is determined, it is the one; what is left over takes z_i, at 0.
    for (const bool holding : {true, false})
      for (std::size_t i = 0; i < n_; ++i)
        if (held_[i] == holding) static_cast<void>(enter(holding || !first[i] ? n_ + i : i));
    bool all = true;
    for (std::size_t i = 0; i < n_; ++i) {
      if (table_.is_basic(i) || table_.is_basic(n_ + i)) continue;
      const std::size_t wanted = held_[i] || !first[i] ? n_ + i : i;
      all = (enter(wanted) || enter(table_.partner(wanted))) && all;
    }
    for (std::size_t row = 0; row < n_; ++row) start_.push_back(table_.basic(row));
    return all;
  }
  bool enter(std::size_t column) {
    const auto row = table_.free_row(column);
    if (row) table_.pivot(*row, column);
    return row.has_value();
  }

  void solve(ComplementarySides& sides) {
    // Held: w_i may have any sign, and z_i, where it stands for w_i that nothing determines, has to be 0.
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < n_; ++row) {
      const std::size_t column = table_.basic(row);
      if (!held_[table_.pair(column)]) {
        rows.push_back(row);
      } else if (column < n_ && table_.at(row, table_.right()).sign() != 0) {
        sides.unbounded = {column};
        return;
      }
    }
    bool negative = false;
    for (const std::size_t row : rows) {
      negative = negative || table_.at(row, table_.right()).sign() < 0;
      table_.at(row, table_.cover()) = PowerSeries::number(-1.0);
    }
    if (!negative) {
      sides.solved = true;
      return;
    }
    std::size_t leaving = rows.front();
    for (const std::size_t row : rows)
      if (row != leaving && compare(row, leaving, true) < 0) leaving = row;
    std::size_t entering = table_.partner(table_.basic(leaving));
    table_.pivot(leaving, table_.cover());
    for (std::size_t count = 0; count < 50 * (n_ + 10); ++count) {
      column_ = entering;
      std::optional<std::size_t> best, covering;
      for (const std::size_t row : rows) {
        if (table_.at(row, entering).sign() <= 0) continue;
        if (table_.basic(row) == table_.cover()) covering = row;
        if (!best || compare(row, *best, false) < 0) best = row;
      }
      // Where the covering variable comes to 0 together with others, as far as the series are known, this is a
      // solution.
      if (covering && best != covering && compare_right(*covering, *best, false) == 0) best = covering;
      if (!best) {
        for (const std::size_t row : rows)
          if (table_.basic(row) != table_.cover() && table_.at(row, entering).sign() != 0)
            sides.unbounded.push_back(table_.pair(table_.basic(row)));
        sides.unbounded.push_back(table_.pair(entering));
        return;
      }
      const std::size_t out = table_.basic(*best);
      table_.pivot(*best, entering);
      if (out == table_.cover()) {
        sides.solved = true;
        return;
      }
      entering = table_.partner(out);
    }
  }

  /// Sign of the difference of two rows' ratios: right side and, where these are equal, the columns that were the first
  /// basis, each divided by the entry of the entering column.
  int compare(std::size_t a, std::size_t b, bool cover) {
    if (const int sign = compare_right(a, b, cover); sign != 0) return sign;
    for (const std::size_t column : start_)
      if (const int sign = compare_in(column, a, b, cover); sign != 0) return sign;
    return 0;
  }
  int compare_right(std::size_t a, std::size_t b, bool cover) { return compare_in(table_.right(), a, b, cover); }
  int compare_in(std::size_t column, std::size_t a, std::size_t b, bool cover) {
    const PowerSeries one = PowerSeries::number(1.0);
    const PowerSeries da = cover ? one : table_.at(a, column_), db = cover ? one : table_.at(b, column_);
    return (table_.at(a, column) * db - table_.at(b, column) * da).sign();
  }

  std::size_t n_;
  const std::vector<bool>& held_;
  Tableau table_;
  std::vector<std::size_t> start_;  ///< columns of the first basis
  std::size_t column_ = 0;
  bool complete_;  ///< the last: from all of the above
};

/// Whether each value is known as far as its number: rounding on the way may leave nothing of it, which is no 0.
bool is_known(const ComplementarySides& sides) {
  return std::none_of(sides.value.begin(), sides.value.end(),
                      [](const PowerSeries& s) { return s.zero && s.known <= 0; });
}

/// Whether each value that is 0 is so as far as the problem itself is known. Where rows had to be divided by h the
/// values are known less far, and one of them may go below 0 at the next order.
bool is_decided(const Complementarity& problem, const ComplementarySides& sides) {
  int known = PowerSeries::kExact;
  for (const PowerSeries& right : problem.r) known = std::min(known, right.known);
  return std::none_of(sides.value.begin(), sides.value.end(),
                      [known](const PowerSeries& s) { return s.zero && s.known < known; });
}

}  // namespace

void scale(Complementarity& problem, const ComplementarityUnits& units) {
  for (std::size_t i = 0; i < problem.size; ++i) {
    for (auto& [j, value] : problem.z[i]) value = value.times_two_to(units.z[j] - units.row[i]);
    for (auto& [j, value] : problem.w[i]) value = value.times_two_to(units.w[j] - units.row[i]);
    problem.r[i] = problem.r[i].times_two_to(-units.row[i]);
  }
}

void scale_back(ComplementarySides& sides, const ComplementarityUnits& units) {
  for (std::size_t i = 0; i < sides.value.size(); ++i)
    sides.value[i] = sides.value[i].times_two_to((sides.takes_z[i] ? units.z : units.w)[i]);
}

ComplementarySides solve_complementarity(const Complementarity& problem, const std::vector<bool>& first,
                                         const std::vector<bool>& held, bool open) {
  if (problem.size == 0) return {true, {}, {}, {}};
  const auto by_blocks = [&](const std::vector<bool>& from) {
    auto sides = solve_by_blocks(problem, from, held);
    return sides && is_decided(problem, *sides) ? std::move(sides) : std::nullopt;
  };
  // A few pivots cost less than factorizations do, and their rounding is small.
  constexpr std::size_t kFew = 4;
  const bool few = problem.size <= kFew;
  if (!few)
    if (auto sides = by_blocks(first)) return std::move(*sides);
  ComplementarySides sides = Lemke(problem, first, held).run();
  if (sides.solved && is_known(sides)) {
    // On the way the covering variable spreads what the right side of one row is off by over all others: the values of
    // the basis found are computed once more, without it.
    if (sides.takes_z == first) return sides;
    ComplementarySides direct = Lemke(problem, sides.takes_z, held).run();
    return direct.solved && is_known(direct) ? direct : sides;
  }
  // Rounding grows with each pivot, and may make a ray: the way is gone again from where it ended, in numbers that have
  // none.
  if (auto others = by_blocks(sides.takes_z)) return std::move(*others);
  if (few)
    if (auto others = by_blocks(first)) return std::move(*others);
  constexpr int kTimes = 3;
  std::vector<bool> from = sides.takes_z;
  for (int i = 0; i < kTimes; ++i) {
    ComplementarySides again = Lemke(problem, from, held).run();
    if (again.solved && (is_known(again) || !sides.solved)) return again;
    if (again.takes_z == from) break;
    from = std::move(again.takes_z);
  }
  if (open && !sides.solved)
    if (auto others = solve_by_blocks(problem, first, held)) return std::move(*others);
  return sides;
}

}  // namespace bgsim
