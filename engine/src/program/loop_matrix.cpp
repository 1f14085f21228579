#include "program/loop_matrix.hpp"

#include <klu.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace bgsim {

namespace {

/// Smaller matrices are factorized faster as a whole.
constexpr std::size_t kLargestDense = 64;

int parity(const int* permutation, int size) {
  std::vector<bool> seen(static_cast<std::size_t>(size), false);
  int sign = 1;
  for (int i = 0; i < size; ++i)
    for (int at = permutation[i]; !seen[static_cast<std::size_t>(i)] && at != i; at = permutation[at]) {
      seen[static_cast<std::size_t>(at)] = true;
      sign = -sign;
    }
  return sign;
}

}  // namespace

/// Columns as KLU takes them, and its factors (T. A. Davis, E. Palamadai Natarajan, ACM TOMS 37 (2010) 36).
struct LoopMatrix::Sparse {
  klu_common common{};
  std::vector<int> column_start, row;
  std::vector<std::size_t> position;  ///< by entry
  std::vector<double> values;
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;
  double fresh_growth = 0.0;  ///< max |a| / max |u| over columns, the least, with pivots of the matrix itself

  /// Whether no pivot is rounding beside the largest.
  [[nodiscard]] bool pivots_serve(double singular) const {
    const Eigen::Map<const Eigen::VectorXd> pivots(static_cast<const double*>(numeric->Udiag), numeric->n);
    return pivots.cwiseAbs().minCoeff() > singular * std::max(1.0, pivots.cwiseAbs().maxCoeff());
  }

  Sparse() { klu_defaults(&common); }
  Sparse(const Sparse&) = delete;
  Sparse& operator=(const Sparse&) = delete;
  ~Sparse() {
    klu_free_numeric(&numeric, &common);
    klu_free_symbolic(&symbolic, &common);
  }
};

LoopMatrix::LoopMatrix(LoopMatrix&&) noexcept = default;
LoopMatrix::~LoopMatrix() = default;

LoopMatrix::LoopMatrix(std::size_t size, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& entries,
                       bool refined)
    : row_scale(static_cast<Eigen::Index>(size)),
      column_scale(static_cast<Eigen::Index>(size)),
      entries_(entries),
      row_balance_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(size))),
      column_balance_(row_balance_),
      refined_(refined && size <= kLargestDense) {
  if (size <= kLargestDense) {
    dense_.resize(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(size));
    factors_ = Eigen::PartialPivLU<Eigen::MatrixXd>(static_cast<Eigen::Index>(size));
    return;
  }
  sparse_ = std::make_unique<Sparse>();
  Sparse& s = *sparse_;
  s.common.scale = 0;  // it is equilibrated already
  // Pivots as in dense factorization: entries of 1 beside slopes of 1e-11 (diodes that block) leave no digits to
  // growth.
  s.common.tol = 1.0;
  // Columns are ordered for any rows that pivoting takes (COLAMD): KLU's own order expects pivots on the diagonal, and
  // in a grid of pipes these fill in several times as much.
  s.common.ordering = 1;
  std::vector<std::size_t> order(entries.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(entries[a].second, entries[a].first) < std::pair(entries[b].second, entries[b].first);
  });
  s.position.resize(entries.size());
  s.column_start.assign(size + 1, 0);
  for (std::size_t k = 0; k < order.size(); ++k) {
    s.position[order[k]] = k;
    s.row.push_back(static_cast<int>(entries[order[k]].first));
    ++s.column_start[entries[order[k]].second + 1];
  }
  std::partial_sum(s.column_start.begin(), s.column_start.end(), s.column_start.begin());
  s.values.resize(entries.size());
  s.symbolic = klu_analyze(static_cast<int>(size), s.column_start.data(), s.row.data(), &s.common);
}

LoopOutcome LoopMatrix::factorize(std::span<double> values, const std::vector<bool>& explicit_row, double singular,
                                  Pivots pivots) {
  for (const double value : values)
    if (!std::isfinite(value)) return LoopOutcome::not_finite;
  if (refined_) balance(values);
  row_scale.setZero();
  for (std::size_t i = 0; i < values.size(); ++i) {
    double& scale = row_scale[entries_[i].first];
    scale = std::max(scale, std::abs(values[i]));
  }
  for (Eigen::Index r = 0; r < row_scale.size(); ++r) {
    // `tear - expression` has terms of magnitude 1, even where they cancel.
    if (explicit_row[static_cast<std::size_t>(r)])
      row_scale[r] = std::max(row_scale[r], 1.0 / (row_balance_[r] * column_balance_[r]));
    if (row_scale[r] == 0.0) return LoopOutcome::singular;
  }
  for (std::size_t i = 0; i < values.size(); ++i) values[i] /= row_scale[entries_[i].first];
  if (row_scale.size() > 1) {
    column_scale.setZero();
    for (std::size_t i = 0; i < values.size(); ++i) {
      double& scale = column_scale[entries_[i].second];
      scale = std::max(scale, std::abs(values[i]));
    }
    if (column_scale.minCoeff() == 0.0) return LoopOutcome::singular;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] /= column_scale[entries_[i].second];
  } else {
    column_scale[0] = 1.0;
  }
  if (refined_) {
    row_scale.array() *= row_balance_.array();
    column_scale.array() *= column_balance_.array();
  }
  return sparse_ ? factorize_sparsely(values, singular, pivots) : factorize_densely(values, singular);
}

/// Divides by the roots of the largest in each row and in each column (D. Ruiz, RAL-TR-2001-034). By rows first, those
/// of the rates of two dependent stores would be all but the same beside a state that is 1e15 times smaller; by columns
/// first, those of two small states beside a dependent store that is large.
void LoopMatrix::balance(std::span<double> values) {
  row_balance_.setZero();
  column_balance_.setZero();
  for (std::size_t i = 0; i < values.size(); ++i) {
    double &row = row_balance_[entries_[i].first], &column = column_balance_[entries_[i].second];
    row = std::max(row, std::abs(values[i]));
    column = std::max(column, std::abs(values[i]));
  }
  const auto divisor = [](double most) { return most > 0.0 ? std::sqrt(most) : 1.0; };
  row_balance_ = row_balance_.unaryExpr(divisor).eval();
  column_balance_ = column_balance_.unaryExpr(divisor).eval();
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] /= row_balance_[entries_[i].first] * column_balance_[entries_[i].second];
}

LoopOutcome LoopMatrix::factorize_densely(std::span<const double> values, double singular) {
  factorized_ = true;
  if (row_scale.size() == 1) {
    const double pivot = dense_(0, 0) = values[0];
    return std::abs(pivot) > singular * std::max(1.0, std::abs(pivot)) ? LoopOutcome::solved : LoopOutcome::singular;
  }
  dense_.setZero();
  for (std::size_t i = 0; i < values.size(); ++i) dense_(entries_[i].first, entries_[i].second) = values[i];
  factors_.compute(dense_);
  const auto pivots = factors_.matrixLU().diagonal().cwiseAbs();
  return pivots.minCoeff() > singular * std::max(1.0, pivots.maxCoeff()) ? LoopOutcome::solved : LoopOutcome::singular;
}

/// With the pivots of the last factorization. False where these no longer serve.
bool LoopMatrix::refactorize(double singular) {
  constexpr double kOfFreshGrowth = 0.1;  // a digit
  Sparse& s = *sparse_;
  if (klu_refactor(s.column_start.data(), s.row.data(), s.values.data(), s.symbolic, s.numeric, &s.common) == 0 ||
      !s.pivots_serve(singular))
    return false;
  klu_rgrowth(s.column_start.data(), s.row.data(), s.values.data(), s.symbolic, s.numeric, &s.common);
  return s.common.rgrowth >= kOfFreshGrowth * s.fresh_growth;
}

LoopOutcome LoopMatrix::factorize_sparsely(std::span<const double> values, double singular, Pivots pivots) {
  Sparse& s = *sparse_;
  if (s.symbolic == nullptr) return LoopOutcome::singular;
  for (std::size_t i = 0; i < values.size(); ++i) s.values[s.position[i]] = values[i];
  if (pivots == Pivots::kept && factorized_ && refactorize(singular)) return LoopOutcome::solved;
  klu_free_numeric(&s.numeric, &s.common);
  s.numeric = klu_factor(s.column_start.data(), s.row.data(), s.values.data(), s.symbolic, &s.common);
  factorized_ = s.numeric != nullptr;
  s.fresh_growth = std::numeric_limits<double>::infinity();  // the pivots of a singular matrix are not kept
  if (!factorized_ || !s.pivots_serve(singular)) return LoopOutcome::singular;
  klu_rgrowth(s.column_start.data(), s.row.data(), s.values.data(), s.symbolic, s.numeric, &s.common);
  s.fresh_growth = s.common.rgrowth;
  return LoopOutcome::solved;
}

void LoopMatrix::solve(const Eigen::VectorXd& right, Eigen::VectorXd& result) const {
  if (right.size() == 1) {  // as most loops: an implicit law between two stores
    result.setConstant(1, right[0] / dense_(0, 0));
    return;
  }
  if (!sparse_) {
    result = factors_.solve(right);
    if (refined_) refine(right, result);
    return;
  }
  result = right;
  klu_solve(sparse_->symbolic, sparse_->numeric, static_cast<int>(result.size()), 1, result.data(), &sparse_->common);
}

/// Elimination leaves the roundings of the largest component in all others. Corrected by what is left of the equations,
/// in the same precision, the solution is that of a matrix each of whose entries has been changed by some roundings of
/// its own (R. D. Skeel, Math. Comp. 35, 1980). The end is that of LAPACK's xGERFS.
void LoopMatrix::refine(const Eigen::VectorXd& right, Eigen::VectorXd& result) const {
  constexpr int kMost = 5;
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < kMost; ++pass) {
    const Eigen::VectorXd left = right - dense_ * result;
    const Eigen::VectorXd terms = dense_.cwiseAbs() * result.cwiseAbs() + right.cwiseAbs();
    double most = 0.0;
    for (Eigen::Index r = 0; r < left.size(); ++r)
      if (left[r] != 0.0) most = std::max(most, std::abs(left[r]) / terms[r]);
    if (!(most > std::numeric_limits<double>::epsilon() && most <= before / 2)) return;
    result += factors_.solve(left);
    before = most;
  }
}

void LoopMatrix::solve_transposed(const Eigen::VectorXd& right, Eigen::VectorXd& result) const {
  // M = row_scale E column_scale, E being what was factorized.
  result = right.cwiseQuotient(column_scale);
  if (sparse_)
    klu_tsolve(sparse_->symbolic, sparse_->numeric, static_cast<int>(result.size()), 1, result.data(),
               &sparse_->common);
  else if (right.size() == 1)
    result[0] /= dense_(0, 0);
  else
    result = factors_.transpose().solve(result).eval();
  result = result.cwiseQuotient(row_scale);
}

int LoopMatrix::orientation() const {
  if (!factorized_) return 0;
  int sign = 1;
  if (sparse_) {
    const auto size = static_cast<int>(row_scale.size());
    sign = parity(sparse_->numeric->Pnum, size) * parity(sparse_->symbolic->Q, size);
    const auto* const pivots = static_cast<const double*>(sparse_->numeric->Udiag);
    for (int i = 0; i < size; ++i) sign = pivots[i] < 0.0 ? -sign : sign;
    return sign;
  }
  if (row_scale.size() == 1) return dense_(0, 0) < 0.0 ? -1 : 1;
  sign = static_cast<int>(factors_.permutationP().determinant());
  for (const double pivot : factors_.matrixLU().diagonal()) sign = pivot < 0.0 ? -sign : sign;
  return sign;
}

}  // namespace bgsim
