#include "run/watch/branch_watch.hpp"

#include <algorithm>
#include <cmath>

#include "run/failures.hpp"

namespace bgsim {

BranchWatch::BranchWatch(const Program& program, Evaluator& evaluator, const Tolerances& tolerances, double start,
                         double stop)
    : program_(program), evaluator_(evaluator), tolerances_(tolerances), span_(stop - start) {
  constexpr double kFirst = 1e-9;  // of the scene: loops at rest begin with roundings
  ripe_ = start + kFirst * (stop - start);
  watched_.assign(program.tear_names.size(), false);
  for (const ProgramBlock& block : program.blocks) {
    if (block.linear) continue;
    any_ = true;
    std::fill_n(watched_.begin() + block.first_tear, block.size, true);
  }
  largest_.assign(watched_.size(), 0.0);
  if (any_) orientation_.assign(program.blocks.size(), 0);
}

void BranchWatch::begin(const Branch& branch) {
  if (!any_) return;
  last_ = branch.tears;
  for (std::size_t b = 0; b < orientation_.size(); ++b) orientation_[b] = evaluator_.orientation(b);
  for (std::size_t i = 0; i < last_.size(); ++i) largest_[i] = std::max(largest_[i], std::abs(last_[i]));
}

BranchWatch::Change BranchWatch::change(const std::vector<double>& from, const std::vector<double>& to) const {
  Change most;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (!watched_[i]) continue;
    const double scale = std::max({largest_[i], std::abs(from[i]), std::abs(to[i])});
    const double size = scale > 0.0 ? std::abs(to[i] - from[i]) / scale : 0.0;
    if (size > most.size) most = {size, i};
  }
  return most;
}

bool BranchWatch::solve(Integrator& integrator, double t, const std::vector<double>& start,
                        std::vector<double>& solution) {
  y_.resize(integrator.size());
  integrator.interpolate(t, y_.data());
  probe_ = integrator.branch();
  probe_.tears = start;
  rates_.resize(program_.state_names.size());
  if (!evaluator_.rates(t, y_.data(), probe_, rates_.data())) return false;
  solution = probe_.tears;
  return true;
}

/// Whether the rates with the solutions low_, at @p from, and high_, right after it at @p to, differ by what a state's
/// tolerance shows.
bool BranchWatch::matters(Integrator& integrator, double from, double to) {
  if (!solve(integrator, from, low_, middle_)) return true;
  const std::vector<double> before = rates_;
  if (!solve(integrator, to, high_, middle_)) return true;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (!(std::abs(rates_[i] - before[i]) * span_ <= tolerances_.absolute(i))) return true;
  return false;
}

const ProgramBlock& BranchWatch::block_of(std::size_t tear) const {
  return *std::find_if(program_.blocks.begin(), program_.blocks.end(), [tear](const ProgramBlock& block) {
    return tear >= block.first_tear && tear < block.first_tear + block.size;
  });
}

std::optional<Diagnostic> BranchWatch::check(Integrator& integrator) {
  constexpr double kLarge = 0.1;    // part of its magnitude by which a loop variable may change unasked
  constexpr double kShrinks = 0.7;  // what is smooth, even a square root at zero, changes less in half the time
  constexpr int kHalvings = 40;
  if (!any_) return std::nullopt;
  now_ = integrator.branch().tears;
  std::optional<Diagnostic> jump;
  for (std::size_t b = 0; b < orientation_.size() && !jump; ++b) {
    const ProgramBlock& block = program_.blocks[b];
    if (block.linear || orientation_[b] * evaluator_.orientation(b) >= 0) continue;
    const std::size_t tear = block.first_tear;
    jump = branch_failure(block, program_.tear_names[tear], integrator.time(), last_[tear], now_[tear]);
  }
  if (jump) return jump;
  if (integrator.time() > ripe_ && change(last_, now_).size > kLarge &&
      solve(integrator, integrator.time(), last_, now_)) {
    double from = integrator.previous(), to = integrator.time();
    low_ = last_;
    high_ = now_;
    const double whole = change(low_, high_).size;
    int halvings = 0;
    for (; halvings < kHalvings && change(low_, high_).size > std::max(kLarge, kShrinks * whole); ++halvings) {
      const double middle = from + (to - from) / 2;
      if (!(middle > from && middle < to) || !solve(integrator, middle, low_, middle_)) break;
      if (change(low_, middle_).size > change(middle_, high_).size) {
        to = middle;
        high_ = middle_;
      } else {
        from = middle;
        low_ = middle_;
      }
    }
    const Change left = change(low_, high_);
    if (left.size > std::max(kLarge, kShrinks * whole) && matters(integrator, from, to))
      jump = branch_failure(block_of(left.tear), program_.tear_names[left.tear], to, low_[left.tear], high_[left.tear]);
  }
  if (!jump) begin(integrator.branch());
  return jump;
}

}  // namespace bgsim
