// TransferZeros from one input to one output, by taking the output's derivatives until the input shows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "linear/analysis.hpp"
#include "linear/dense.hpp"

namespace bgsim {
namespace {

using Index = Eigen::Index;
/// A sum that is smaller than its terms by this is rounding.
constexpr double kRounding = 256.0 * std::numeric_limits<double>::epsilon();

[[noreturn]] void fail_unreached(const LinearSystem& system, std::size_t input, std::size_t output) {
  throw ModelError(
      {diagnostic_of("BG410",
                     "the output " + short_name(system.outputs[output].name) + " does not depend on the input " +
                         short_name(system.inputs[input].name) + " at this point",
                     {}, "a transfer function needs a path from the input to the output",
                     "bgsim linearize prints which states an input acts on, and an output reads")},
      nullptr);
}

/// Which rows can be reached from those marked, along the entries.
void spread(const LinearMatrix& a, bool forward, std::vector<char>& marked) {
  std::vector<std::vector<std::uint32_t>> next(a.rows);
  for (const auto& e : a.entries) (forward ? next[e.column] : next[e.row]).push_back(forward ? e.row : e.column);
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < a.rows; ++i)
    if (marked[i] != 0) open.push_back(i);
  while (!open.empty()) {
    const std::uint32_t from = open.back();
    open.pop_back();
    for (const std::uint32_t to : next[from])
      if (marked[to] == 0) {
        marked[to] = 1;
        open.push_back(to);
      }
  }
}

}  // namespace

SinglePath single_path(const LinearSystem& system, std::size_t input, std::size_t output) {
  const std::size_t n = system.states.size();
  std::vector<Eigen::VectorXd> b;
  for (const LinearMatrix& matrix : system.b) {
    b.emplace_back(Eigen::VectorXd::Zero(static_cast<Index>(n)));
    for (const auto& e : matrix.entries)
      if (e.column == input) b.back()(e.row) = e.value;
  }
  Eigen::VectorXd c = Eigen::VectorXd::Zero(static_cast<Index>(n));
  for (const auto& e : system.c.entries)
    if (e.row == output) c(e.column) = e.value;
  SinglePath path;
  path.d.assign(std::max(system.b.size(), system.d.size()), 0.0);
  for (std::size_t k = 0; k < system.d.size(); ++k)
    for (const auto& e : system.d[k].entries)
      if (e.row == output && e.column == input) path.d[k] = e.value;
  // (s - A)^-1 s^k B_k = s^(k-1) B_k + (s - A)^-1 s^(k-1) A B_k
  for (std::size_t k = b.size(); k-- > 1;) {
    Eigen::VectorXd next = Eigen::VectorXd::Zero(static_cast<Index>(n));
    for (const auto& e : system.a.entries) next(e.row) += e.value * b[k](e.column);
    const double moved = c.dot(b[k]), gross = c.cwiseAbs().dot(b[k].cwiseAbs()) + std::abs(path.d[k - 1]);
    path.d[k - 1] += moved;
    if (std::abs(path.d[k - 1]) <= kRounding * gross) path.d[k - 1] = 0.0;
    b[k - 1] += next;
  }
  std::vector<char> from(n, 0), to(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    from[i] = b[0](static_cast<Index>(i)) != 0.0 ? 1 : 0;
    to[i] = c(static_cast<Index>(i)) != 0.0 ? 1 : 0;
  }
  spread(system.a, true, from);
  spread(system.a, false, to);
  std::vector<int> place(n, -1);
  for (std::uint32_t i = 0; i < n; ++i)
    if (from[i] != 0 && to[i] != 0) {
      place[i] = static_cast<int>(path.states.size());
      path.states.push_back(i);
    }
  path.a = {path.states.size(), path.states.size(), {}};
  for (const auto& e : system.a.entries)
    if (place[e.row] >= 0 && place[e.column] >= 0)
      path.a.entries.push_back(
          {static_cast<std::uint32_t>(place[e.row]), static_cast<std::uint32_t>(place[e.column]), e.value});
  path.b.resize(static_cast<Index>(path.states.size()));
  path.c.resize(path.b.size());
  for (std::size_t i = 0; i < path.states.size(); ++i) {
    path.b(static_cast<Index>(i)) = b[0](path.states[i]);
    path.c(static_cast<Index>(i)) = c(path.states[i]);
  }
  while (path.d.size() > 1 && path.d.back() == 0.0) path.d.pop_back();
  if (path.states.empty() && path.d.size() == 1 && path.d[0] == 0.0) fail_unreached(system, input, output);
  return path;
}

namespace {

/// Where the output is held at zero: x' = a x + b u, 0 = c x + d u.
struct Held {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  Eigen::RowVectorXd c;
  double d = 0.0;
};

/// Takes the state out that the output fixes, and the output's derivative in its place. False if nothing is left that
/// the output depends on.
bool differentiate(Held& held) {
  const Index n = held.a.rows();
  // The state that the output takes most of, by what the others are in the same rows: no unit is larger than another.
  Index pivot = -1;
  double best = 0.0;
  for (Index j = 0; j < n; ++j) {
    if (held.c(j) == 0.0) continue;
    const double column = held.a.col(j).cwiseAbs().sum(), row = held.a.row(j).cwiseAbs().sum() + std::abs(held.b(j));
    const double size = std::abs(held.c(j)) * std::sqrt((row > 0.0 ? row : 1.0) / (column > 0.0 ? column : 1.0));
    if (size > best) best = size, pivot = j;
  }
  if (pivot < 0) return false;
  const Eigen::RowVectorXd ratio = held.c / held.c(pivot);
  const Eigen::RowVectorXd ca = held.c * held.a, ca_gross = held.c.cwiseAbs() * held.a.cwiseAbs();
  const double cb = held.c.dot(held.b), cb_gross = held.c.cwiseAbs().dot(held.b.cwiseAbs());
  Held next;
  next.a.resize(n - 1, n - 1);
  next.b.resize(n - 1);
  next.c.resize(n - 1);
  next.d = std::abs(cb) <= kRounding * cb_gross ? 0.0 : cb;
  const auto clean = [](double value, double gross) { return std::abs(value) <= kRounding * gross ? 0.0 : value; };
  for (Index j = 0, to = 0; j < n; ++j) {
    if (j == pivot) continue;
    next.c(to) = clean(ca(j) - ca(pivot) * ratio(j), ca_gross(j) + ca_gross(pivot) * std::abs(ratio(j)));
    next.b(to) = held.b(j);
    for (Index i = 0, row = 0; i < n; ++i) {
      if (i == pivot) continue;
      const double term = held.a(i, pivot) * ratio(j);
      next.a(row++, to) = clean(held.a(i, j) - term, std::abs(held.a(i, j)) + std::abs(term));
    }
    ++to;
  }
  held = std::move(next);
  return true;
}

bool at_zero(const Pole& one) { return one.s == 0.0; }

/// G(0) of a system that has poles at 0, which zeros may cancel: A is singular, so from G(j w) far below what else
/// there is. Re G(j w) is even in w: a ten thousandth of the slowest pole or zero leaves 1e-8 of it. NaN where that
/// does not settle, or rounding has made zeros that are 0 other ones.
double limit_at_rest(const LinearSystem& system, std::size_t input, std::size_t output, const TransferZeros& found) {
  constexpr double kBelow = 1e-4, kFurther = 0.1, kEqual = 1e-6, kRises = 3.0;
  if (std::count_if(found.zeros.begin(), found.zeros.end(), at_zero) >
      std::count_if(found.poles.begin(), found.poles.end(), at_zero))
    return 0.0;
  double slowest = std::numeric_limits<double>::infinity(), fastest = 0.0;
  for (const std::vector<Pole>* list : {&found.zeros, &found.poles})
    for (const Pole& one : *list) {
      if (!at_zero(one)) slowest = std::min(slowest, one.frequency());
      fastest = std::max(fastest, one.frequency());
    }
  if (slowest < kRounding * fastest) return std::numeric_limits<double>::quiet_NaN();
  const double near = kBelow * (std::isfinite(slowest) ? slowest : 1.0);
  const std::vector<double> omega{kFurther * near, near};
  const FrequencyResponse response = frequency_response(system, input, output, omega);
  if (!(response.error <= kEqual)) return std::numeric_limits<double>::quiet_NaN();
  const double lower = std::abs(response.value[0]), upper = std::abs(response.value[1]);
  if (lower > kRises * upper) return std::numeric_limits<double>::infinity();
  if (kRises * lower < upper) return 0.0;
  const double value = response.value[0].real(), other = response.value[1].real();
  return std::abs(value - other) <= kEqual * lower ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

TransferZeros transfer_zeros(const LinearSystem& system, std::size_t input, std::size_t output) {
  const SinglePath path = single_path(system, input, output);
  if (path.states.size() > kLargestDense) static_cast<void>(poles_of(path.a, nullptr));  // refuses
  TransferZeros result;
  for (std::size_t i = 0, k = 0; i < system.states.size(); ++i) {
    if (k < path.states.size() && path.states[k] == i)
      ++k;
    else
      result.hidden.push_back(system.states[i].name);
  }
  result.poles = poles_of(path.a, nullptr);
  Eigen::MatrixXd zero_dynamics;
  const std::size_t order = path.d.size() - 1;
  if (path.d.back() != 0.0) {
    // u^(order) = -(c x + sum of lower derivatives)/d
    const Index n = path.b.size(), k = static_cast<Index>(order);
    const double d = path.d.back();
    zero_dynamics = Eigen::MatrixXd::Zero(n + k, n + k);
    zero_dynamics.topLeftCorner(n, n) = dense(path.a);
    if (k == 0) {
      zero_dynamics -= path.b * (path.c.transpose() / d);
    } else {
      zero_dynamics.col(n).head(n) = path.b;
      for (Index i = 0; i + 1 < k; ++i) zero_dynamics(n + i, n + i + 1) = 1.0;
      zero_dynamics.row(n + k - 1).head(n) = -path.c.transpose() / d;
      for (Index i = 0; i < k; ++i) zero_dynamics(n + k - 1, n + i) = -path.d[static_cast<std::size_t>(i)] / d;
    }
    result.gain = d;
  } else {
    Held held{dense(path.a), path.b, path.c.transpose(), 0.0};
    while (held.d == 0.0)
      if (!differentiate(held)) fail_unreached(system, input, output);
    zero_dynamics = held.a - held.b * (held.c / held.d);
    result.gain = held.d;
  }
  result.zeros = poles_of(sparse(zero_dynamics), nullptr);
  const bool integrates = std::any_of(result.poles.begin(), result.poles.end(), at_zero);
  const bool blocks = std::any_of(result.zeros.begin(), result.zeros.end(), at_zero);
  const double none[] = {0.0};
  result.static_gain = integrates ? limit_at_rest(system, input, output, result)
                       : blocks   ? 0.0
                                  : frequency_response(system, input, output, none).value[0].real();
  // What input and output do not move and see together: a free body's common speed, where both are differences.
  while (true) {
    const auto zero = std::find_if(result.zeros.begin(), result.zeros.end(), at_zero);
    const auto pole = std::find_if(result.poles.begin(), result.poles.end(), at_zero);
    if (zero == result.zeros.end() || pole == result.poles.end()) return result;
    result.zeros.erase(zero);
    result.poles.erase(pole);
    for (std::vector<Pole>* list : {&result.zeros, &result.poles})
      for (Pole& one : *list)
        if (at_zero(one) && one.multiple > 1) --one.multiple;
    ++result.cancelled;
  }
}

}  // namespace bgsim
