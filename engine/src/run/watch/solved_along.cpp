#include "run/watch/solved_along.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

namespace bgsim {

namespace {

/// Of a dense inverse on each stretch.
constexpr std::size_t kMost = 32;
constexpr int kTries = 4;

Range times(double factor, const Range& range) { return factor == 0.0 ? Range(0.0, 0.0) : factor * range; }
double magnitude(const Range& range) { return std::max(std::fabs(range.lower()), std::fabs(range.upper())); }

}  // namespace

bool SolvedAlong::look_at(std::vector<std::uint32_t> tears, std::vector<std::uint32_t> relations) {
  std::sort(tears.begin(), tears.end());
  if (looked_ && asked_ == tears && relations_ == relations) return known_;
  looked_ = true;
  asked_ = std::move(tears);
  relations_ = std::move(relations);
  // Loops depend on those before them.
  known_ = take(asked_);
  while (known_ &&
         !std::includes(tears_.begin(), tears_.end(), equations_->tears().begin(), equations_->tears().end())) {
    std::vector<std::uint32_t> more;
    std::set_union(tears_.begin(), tears_.end(), equations_->tears().begin(), equations_->tears().end(),
                   std::back_inserter(more));
    known_ = take(more);
  }
  if (!known_) tears_ = asked_;
  return known_;
}

/// With all variables of the loops that these are of.
bool SolvedAlong::take(const std::vector<std::uint32_t>& tears) {
  tears_.clear();
  states_.clear();
  for (const ProgramBlock& block : program_.blocks)
    if (std::any_of(tears.begin(), tears.end(), [&](std::uint32_t tear) {
          return tear >= block.first_tear && tear < block.first_tear + block.size;
        }))
      for (std::uint32_t k = 0; k < block.size; ++k) tears_.push_back(block.first_tear + k);
  const std::size_t size = tears_.size() + relations_.size();
  if (size > kMost) return false;
  std::vector<const ImplicitEquation*> equations;
  for (const std::uint32_t tear : tears_) {
    if (tear >= program_.loop_equations.size()) return false;
    equations.push_back(&program_.loop_equations[tear]);
  }
  for (const std::uint32_t relation : relations_) {
    if (relation >= program_.border_rates.size()) return false;
    equations.push_back(&program_.border_rates[relation]);
  }
  std::vector<ExprId> roots;
  for (const ImplicitEquation* const equation : equations) {
    if (!equation->value.valid()) return false;
    roots.push_back(equation->value);
  }
  partials_.clear();
  for (std::size_t row = 0; row < size; ++row) {
    const auto add = [&](const auto& by, const std::vector<std::uint32_t>& unknowns, std::size_t first) {
      for (const auto& [which, partial] : by) {
        const auto at = std::find(unknowns.begin(), unknowns.end(), which);
        if (at == unknowns.end()) continue;
        partials_.push_back({row, first + static_cast<std::size_t>(at - unknowns.begin()), roots.size()});
        roots.push_back(partial);
      }
    };
    add(equations[row]->by_tears, tears_, 0);
    add(equations[row]->by_modes, relations_, tears_.size());
  }
  equations_.emplace(program_, parameters_, roots);
  states_ = equations_->states();
  return true;
}

void SolvedAlong::put(std::span<const double> middle, const std::vector<Range>& ranges) {
  const auto jet = [&](std::size_t k) { return Jet{middle[k], ranges[k], Range(0.0, 0.0), 0.0, Range(0.0, 0.0)}; };
  tear_jets_.clear();
  for (const std::uint32_t tear : equations_->tears()) {
    const auto at = std::lower_bound(tears_.begin(), tears_.end(), tear);
    tear_jets_.push_back(jet(static_cast<std::size_t>(at - tears_.begin())));
  }
  modes_.clear();
  for (std::size_t k = 0; k < relations_.size(); ++k) modes_.push_back({relations_[k], jet(tears_.size() + k)});
}

/// What holds the solutions z of S z + v = 0, v in @p values and S from least_ to most_.
bool SolvedAlong::solve(const std::vector<Range>& values, const Eigen::MatrixXd& inverse,
                        std::vector<Range>& out) const {
  constexpr int kIterations = 10;
  constexpr double kRoom = 1.1;
  const Eigen::Index n = least_.rows();
  const auto index = [](Eigen::Index i) { return static_cast<std::size_t>(i); };
  Eigen::VectorXd first(n);
  Eigen::MatrixXd spread(n, n);  // |A|
  for (Eigen::Index i = 0; i < n; ++i) {
    Range sum(0.0, 0.0);
    for (Eigen::Index k = 0; k < n; ++k) {
      sum += times(inverse(i, k), values[index(k)]);
      Range entry(i == k ? 1.0 : 0.0, i == k ? 1.0 : 0.0);
      for (Eigen::Index j = 0; j < n; ++j) entry -= times(inverse(i, j), Range(least_(j, k), most_(j, k)));
      spread(i, k) = magnitude(entry);
    }
    out[index(i)] = -sum;
    first[i] = magnitude(sum);
  }
  if (!first.allFinite() || !spread.allFinite()) return false;
  Eigen::VectorXd bound = first;
  for (int k = 0; k < kIterations; ++k) {
    bound = kRoom * (first + spread * bound);
    const Eigen::VectorXd more = spread * bound;
    if (!((first + more).array() <= bound.array()).all()) continue;
    for (Eigen::Index i = 0; i < n; ++i) out[index(i)] = out[index(i)] + Range(-more[i], more[i]);
    return true;
  }
  return false;
}

bool SolvedAlong::enclose(double from, double to, std::span<const Jet> states, std::span<const double> modes,
                          std::span<const double> middle, std::vector<Range> about) {
  const std::size_t size = tears_.size() + relations_.size();
  const auto n = static_cast<Eigen::Index>(size);
  std::vector<Range> values(size), slopes(size), off(size), thin;
  for (const double at : middle) thin.emplace_back(at, at);
  equations_->set_modes(modes);
  put(middle, thin);
  equations_->evaluate(from, to, states, tear_jets_, modes_);
  for (std::size_t k = 0; k < size; ++k) values[k] = (*equations_)[k].value;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    put(middle, about);
    equations_->evaluate_apart(from, to, states, tear_jets_, modes_);
    for (std::size_t k = 0; k < size; ++k) slopes[k] = (*equations_)[k].slope;
    least_.setZero(n, n);
    most_.setZero(n, n);
    for (const Partial& partial : partials_) {
      const Range& value = (*equations_)[partial.root].value;
      const auto row = static_cast<Eigen::Index>(partial.row), column = static_cast<Eigen::Index>(partial.column);
      least_(row, column) = value.lower();
      most_(row, column) = value.upper();
    }
    if (!least_.allFinite() || !most_.allFinite()) return false;
    const Eigen::MatrixXd centre = 0.5 * (least_ + most_);
    const Eigen::MatrixXd inverse = centre.partialPivLu().inverse();
    if (!solve(values, inverse, off)) return false;
    bool within = true;
    for (std::size_t k = 0; k < size; ++k) {
      const Range found = Range(middle[k], middle[k]) + off[k];
      within = within && found.lower() >= about[k].lower() && found.upper() <= about[k].upper();
      off[k] = found;
    }
    if (within) {
      found_.resize(size);
      for (std::size_t k = 0; k < size; ++k) found_[k] = {middle[k], off[k], kAllNumbers, 0.0, kAllNumbers};
      if (solve(slopes, inverse, off))
        for (std::size_t k = 0; k < size; ++k) found_[k].slope = off[k];
      return true;
    }
    for (std::size_t k = 0; k < size; ++k) {
      const double more = 0.5 * (off[k].upper() - off[k].lower());
      about[k] = hull(about[k], Range(off[k].lower() - more, off[k].upper() + more));
    }
  }
  return false;
}

}  // namespace bgsim
