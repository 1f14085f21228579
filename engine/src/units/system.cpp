#include "units/system.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_set>

namespace bgsim {

namespace {

constexpr double kZero = 1e-9;

/// a * b^exponent; terms that cancel are dropped.
UnitForm product(const UnitForm& a, const UnitForm& b, double exponent) {
  UnitForm result;
  result.constant = a.constant * power(b.constant, exponent);
  result.terms.reserve(a.terms.size() + b.terms.size());
  auto i = a.terms.begin();
  auto j = b.terms.begin();
  while (i != a.terms.end() || j != b.terms.end()) {
    if (j == b.terms.end() || (i != a.terms.end() && i->first < j->first)) {
      result.terms.push_back(*i++);
    } else if (i == a.terms.end() || j->first < i->first) {
      result.terms.emplace_back(j->first, exponent * j->second);
      ++j;
    } else {
      const double sum = i->second + exponent * j->second;
      if (std::abs(sum) > kZero) result.terms.emplace_back(i->first, sum);
      ++i, ++j;
    }
  }
  return result;
}

double power_of(const UnitForm& form, std::uint32_t variable) {
  const auto at = std::lower_bound(form.terms.begin(), form.terms.end(), variable,
                                   [](const auto& term, std::uint32_t v) { return term.first < v; });
  return at != form.terms.end() && at->first == variable ? at->second : 0.0;
}

}  // namespace

UnitForm operator*(const UnitForm& a, const UnitForm& b) { return product(a, b, 1.0); }
UnitForm operator/(const UnitForm& a, const UnitForm& b) { return product(a, b, -1.0); }
UnitForm power(const UnitForm& form, double exponent) { return product({}, form, exponent); }

std::uint32_t UnitSystem::add_variable() {
  variables_.emplace_back();
  return static_cast<std::uint32_t>(variables_.size() - 1);
}

std::uint32_t UnitSystem::add_equation(UnitForm form, std::uint32_t depth) {
  budget_ += form.terms.size();
  Row row;
  row.form = std::move(form);
  row.depth = depth;
  equations_ = add_row(std::move(row)) + 1;
  return equations_ - 1;
}

std::uint32_t UnitSystem::add_row(Row row) {
  const auto number = static_cast<std::uint32_t>(rows_.size());
  row.made = clock_;
  for (const auto& [variable, exponent] : row.form.terms) {
    const Variable& v = variables_[variable];
    if (!v.value) ++row.unknown;
    variables_[variable].rows.push_back(number);
  }
  rows_.push_back(std::move(row));
  if (rows_[number].unknown < 2) ready(number);
  return number;
}

void UnitSystem::ready(std::uint32_t row) {
  heap_.push_back((std::uint64_t{rows_[row].depth} << 32U) | row);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

void UnitSystem::propagate() {
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const auto row = static_cast<std::uint32_t>(heap_.back());
    heap_.pop_back();
    if (!rows_[row].settled && !rows_[row].replaced) settle(row);
  }
}

/// A row with one unknown gives its value; one without holds, or is a contradiction.
void UnitSystem::settle(std::uint32_t number) {
  Row& row = rows_[number];
  row.settled = true;
  Unit rest = row.form.constant;
  std::uint32_t unknown = kNone;
  double exponent = 0.0;
  for (const auto& [variable, p] : row.form.terms) {
    if (variables_[variable].value)
      rest = rest * power(*variables_[variable].value, p);
    else
      unknown = variable, exponent = p;
  }
  if (unknown == kNone) {
    if (!is_pure_number(rest) && contradictions_.size() < kMostContradictions)
      contradictions_.push_back({number, behind(number)});
    return;
  }
  Variable& variable = variables_[unknown];
  variable.value = power(rest, -1.0 / exponent);
  variable.reason = number;
  variable.since = ++clock_;
  row.unknown = 0;
  for (const std::uint32_t other : variable.rows) {
    if (other == number) continue;
    Row& touched = rows_[other];
    --touched.unknown;
    touched.depth = std::max(touched.depth, row.depth + 1);
    if (touched.unknown < 2) ready(other);
  }
}

void UnitSystem::solve() {
  budget_ = 100'000 + 100 * budget_;
  propagate();
  eliminate();
}

std::uint32_t UnitSystem::rarest_unknown(const Row& row) const {
  std::uint32_t rarest = kNone;
  for (const auto& [variable, exponent] : row.form.terms) {
    if (variables_[variable].value) continue;
    if (rarest == kNone || variables_[variable].rows.size() < variables_[rarest].rows.size()) rarest = variable;
  }
  return rarest;
}

void UnitSystem::eliminate() {
  using Entry = std::pair<std::uint32_t, std::uint32_t>;  // unknowns, row
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::size_t queued = 0;
  const auto queue_new = [&] {
    for (; queued < rows_.size(); ++queued)
      if (rows_[queued].unknown > 1) open.emplace(rows_[queued].unknown, static_cast<std::uint32_t>(queued));
  };
  queue_new();
  while (!open.empty()) {
    const auto [unknowns, number] = open.top();
    open.pop();
    const Row& row = rows_[number];
    if (row.replaced || row.settled || row.pivot != kNone || row.unknown < 2) continue;
    if (row.unknown < unknowns) {
      open.emplace(row.unknown, number);
      continue;
    }
    pivot_on(number);
    propagate();
    queue_new();
    if (!complete_) return;
  }
}

/// Solves a row for its rarest unknown and puts that into every other row, those that are solved included.
void UnitSystem::pivot_on(std::uint32_t number) {
  const std::uint32_t pivot = rarest_unknown(rows_[number]);
  rows_[number].pivot = pivot;
  variables_[pivot].pivot = number;
  const std::vector<std::uint32_t> others = std::move(variables_[pivot].rows);
  variables_[pivot].rows = {number};
  for (const std::uint32_t other : others) {
    if (other == number || rows_[other].replaced) continue;
    Row combined;
    combined.form = product(rows_[other].form, rows_[number].form,
                            -power_of(rows_[other].form, pivot) / power_of(rows_[number].form, pivot));
    combined.depth = std::max(rows_[other].depth, rows_[number].depth) + 1;
    combined.parent_a = other;
    combined.parent_b = number;
    combined.pivot = rows_[other].pivot;
    rows_[other].replaced = true;
    if (combined.form.terms.size() > budget_) {
      complete_ = false;
      return;
    }
    budget_ -= combined.form.terms.size();
    const std::uint32_t solved = combined.pivot;
    const std::uint32_t added = add_row(std::move(combined));
    if (solved != kNone) variables_[solved].pivot = added;
  }
}

/// With everything put in that is known or solved for: only unknowns remain that nothing determines.
UnitForm UnitSystem::reduced(const UnitForm& form) const {
  UnitForm result;
  result.constant = form.constant;
  for (const auto& [variable, exponent] : form.terms) {
    const Variable& v = variables_[variable];
    UnitForm factor;
    if (v.value) {
      factor.constant = *v.value;
    } else if (v.pivot != kNone) {
      const UnitForm& row = rows_[v.pivot].form;
      factor = power(row, -1.0 / power_of(row, variable));
      std::erase_if(factor.terms, [solved = variable](const auto& term) { return term.first == solved; });
      factor = reduced_known(factor);
    } else {
      factor.terms = {{variable, 1.0}};
    }
    result = product(result, factor, exponent);
  }
  return result;
}

UnitForm UnitSystem::reduced_known(const UnitForm& form) const {
  UnitForm result;
  result.constant = form.constant;
  for (const auto& term : form.terms) {
    if (const auto& value = variables_[term.first].value)
      result.constant = result.constant * power(*value, term.second);
    else
      result.terms.push_back(term);
  }
  return result;
}

bool UnitSystem::add_wish(const UnitForm& form) {
  if (!complete_) return true;
  Row row;
  row.form = reduced(form);
  if (row.form.terms.empty()) return is_pure_number(row.form.constant);
  if (!same_unit({{}, row.form.constant.log_scale}, {})) return true;
  const bool alone = row.form.terms.size() == 1;
  const std::uint32_t number = add_row(std::move(row));
  if (!alone) pivot_on(number);
  propagate();
  return true;
}

std::optional<Unit> UnitSystem::value(const UnitForm& form) const {
  Unit unit = form.constant;
  for (const auto& [variable, exponent] : form.terms) {
    if (!variables_[variable].value) return std::nullopt;
    unit = unit * power(*variables_[variable].value, exponent);
  }
  return unit;
}

std::vector<std::uint32_t> UnitSystem::reasons(std::uint32_t variable) const {
  const std::uint32_t row = variables_[variable].reason;
  return row == kNone ? std::vector<std::uint32_t>() : behind(row);
}

/// The equations that a row rests on, in the order of their distance. Only what was known when it was used counts.
std::vector<std::uint32_t> UnitSystem::behind(std::uint32_t row) const {
  struct Step {
    std::uint32_t row, before;
  };
  std::vector<std::uint32_t> equations;
  std::unordered_set<std::uint32_t> seen{row};
  std::vector<Step> open{{row, clock_ + 1}};
  for (std::size_t next = 0; next < open.size(); ++next) {
    const Step step = open[next];
    const Row& r = rows_[step.row];
    if (step.row < equations_) equations.push_back(step.row);
    const auto follow = [&](std::uint32_t to, std::uint32_t before) {
      if (to != kNone && seen.insert(to).second) open.push_back({to, before});
    };
    follow(r.parent_a, r.made + 1);
    follow(r.parent_b, r.made + 1);
    for (const auto& [variable, exponent] : r.form.terms)
      if (variables_[variable].since < step.before) follow(variables_[variable].reason, variables_[variable].since);
  }
  return equations;
}

}  // namespace bgsim
