#include "graph/junction_rank.hpp"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <set>

#include "graph/residue.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

std::vector<JunctionPart> ring_parts(const BondGraph& graph) {
  boost::disjoint_sets_with_storage<> sets(graph.kinds.size());
  const auto inner_bond = [&](const Bond& bond) {
    return passes_power(graph.kinds[graph[bond.tail].element.index()]) &&
           passes_power(graph.kinds[graph[bond.head].element.index()]);
  };
  std::set<std::size_t> with_ring;
  for (const Bond& bond : graph.bonds) {
    if (!inner_bond(bond)) continue;
    const std::size_t a = sets.find_set(graph[bond.tail].element.index());
    const std::size_t b = sets.find_set(graph[bond.head].element.index());
    if (a == b)
      with_ring.insert(a);
    else
      sets.link(a, b);
  }
  if (with_ring.empty()) return {};
  std::map<std::size_t, JunctionPart> parts;
  for (const std::size_t element : with_ring) parts[sets.find_set(element)];
  const auto part_of = [&](ElementId element) {
    return passes_power(graph.kinds[element.index()]) ? parts.find(sets.find_set(element.index())) : parts.end();
  };
  for (std::size_t i = 0; i < graph.kinds.size(); ++i)
    if (const auto part = part_of(ElementId(i)); part != parts.end()) part->second.elements.push_back(ElementId(i));
  for (std::size_t i = 0; i < graph.bonds.size(); ++i) {
    const Bond& bond = graph.bonds[i];
    const auto tail = part_of(graph[bond.tail].element), head = part_of(graph[bond.head].element);
    if (tail == parts.end() && head == parts.end()) continue;
    if (tail != parts.end() && head != parts.end())
      tail->second.inner.push_back(BondId(i));
    else if (tail != parts.end())
      tail->second.outer.push_back(bond.head);
    else
      head->second.outer.push_back(bond.tail);
  }
  std::vector<JunctionPart> result;
  for (auto& [root, part] : parts) {
    std::sort(part.outer.begin(), part.outer.end());
    result.push_back(std::move(part));
  }
  std::sort(result.begin(), result.end(),
            [](const JunctionPart& a, const JunctionPart& b) { return a.elements.front() < b.elements.front(); });
  return result;
}

JunctionRank::JunctionRank(const BondGraph& graph, const JunctionPart& part,
                           const std::function<Coefficient(ElementId)>& modulus, ExprPool* pool)
    : graph_(graph), pool_(pool), inner_bonds_(part.inner.size()) {
  for (const BondId bond : part.inner) place_.emplace(bond, static_cast<std::uint32_t>(place_.size()));
  for (const PortId port : part.outer) place_.emplace(graph[port].bond, static_cast<std::uint32_t>(place_.size()));
  taken_.resize(2 * place_.size());
  write(graph, part, modulus);
  eliminate_inner();
  reduce_outer();
}

std::uint32_t JunctionRank::variable(BondId bond, Variable variable) const {
  return 2 * place_.at(bond) + (variable == Variable::flow ? 1U : 0U);
}

std::uint32_t JunctionRank::variable(PortId outer, Gives gives) const {
  return variable(graph_[outer].bond, gives == Gives::effort ? Variable::effort : Variable::flow);
}

// --- coefficients

/// A coefficient that is a small whole number, whatever it was computed from, is written as that number.
Coefficient JunctionRank::plain(Coefficient c) const {
  constexpr std::uint64_t kSmall = 1000;
  if (pool_ == nullptr) return c;
  if (c.residue <= kSmall) c.expression = pool_->constant(static_cast<double>(c.residue));
  if (kPrime - c.residue <= kSmall) c.expression = pool_->constant(-static_cast<double>(kPrime - c.residue));
  return c;
}

Coefficient JunctionRank::number(int value) const {
  const auto size = static_cast<std::uint64_t>(std::abs(value));
  return plain({value < 0 ? minus(size) : size, {}});
}

Coefficient JunctionRank::product(const Coefficient& a, const Coefficient& b) const {
  return plain({product_of(a.residue, b.residue), pool_ ? pool_->mul(a.expression, b.expression) : ExprId()});
}

Coefficient JunctionRank::quotient(const Coefficient& a, const Coefficient& b) const {
  return plain(
      {product_of(a.residue, inverse_of(b.residue)), pool_ ? pool_->div(a.expression, b.expression) : ExprId()});
}

Coefficient JunctionRank::difference(const Coefficient& a, const Coefficient& b) const {
  return plain({sum_of(a.residue, minus(b.residue)), pool_ ? pool_->sub(a.expression, b.expression) : ExprId()});
}

/// from -= times * what
void JunctionRank::subtract(Row& from, const Row& what, const Coefficient& times) const {
  for (const auto& [variable, factor] : what) {
    const Coefficient change = product(times, factor);
    const auto there = from.find(variable);
    const Coefficient now = difference(there == from.end() ? number(0) : there->second, change);
    if (now.residue != 0)
      from[variable] = now;
    else if (there != from.end())
      from.erase(there);
  }
}

// --- equations

/// Flows count along half-arrows, as everywhere.
void JunctionRank::write(const BondGraph& graph, const JunctionPart& part,
                         const std::function<Coefficient(ElementId)>& modulus) {
  const auto of = [&](PortId port, Variable v) { return variable(graph[port].bond, v); };
  // a = sign * factor * b
  const auto relate = [&](std::uint32_t a, const Coefficient& factor, bool positive, std::uint32_t b) {
    rows_.push_back({{a, number(-1)}, {b, product(number(positive ? 1 : -1), factor)}});
  };
  for (const ElementId id : part.elements) {
    const ElementKind kind = graph.kinds[id.index()];
    const PortId first = graph.port(id, 0);
    if (is_junction(kind)) {
      const Variable shared = *shared_variable(kind), balanced = other_of(shared);
      Row balance;
      for (std::size_t k = 0; k < graph.port_count(id); ++k) {
        const PortId port = graph.port(id, k);
        balance[of(port, balanced)] = number(graph[port].head ? 1 : -1);
        if (k > 0) relate(of(port, shared), number(1), true, of(first, shared));
      }
      rows_.push_back(std::move(balance));
      continue;
    }
    const PortId second = graph.port(id, 1);
    const Coefficient factor = plain(modulus(id));
    if (!kind_row(kind).crosses) {
      relate(of(first, Variable::effort), factor, true, of(second, Variable::effort));
      relate(of(second, Variable::flow), factor, graph[first].head == !graph[second].head, of(first, Variable::flow));
    } else {
      relate(of(first, Variable::effort), factor, !graph[second].head, of(second, Variable::flow));
      relate(of(second, Variable::effort), factor, graph[first].head, of(first, Variable::flow));
    }
  }
  // A modulus that is 0 by itself leaves no term.
  for (Row& row : rows_) std::erase_if(row, [](const auto& term) { return term.second.residue == 0; });
  used_.assign(rows_.size(), false);
}

/// The variable in the fewest equations first (Markowitz): few terms come up.
void JunctionRank::eliminate_inner() {
  const auto variables = static_cast<std::uint32_t>(2 * inner_bonds_);
  std::vector<std::set<std::uint32_t>> rows_with(variables);
  const auto enter = [&](std::uint32_t row) {
    for (const auto& [variable, factor] : rows_[row])
      if (inner(variable)) rows_with[variable].insert(row);
  };
  const auto leave = [&](std::uint32_t row) {
    for (const auto& [variable, factor] : rows_[row])
      if (inner(variable)) rows_with[variable].erase(row);
  };
  for (std::uint32_t row = 0; row < rows_.size(); ++row) enter(row);
  std::set<std::pair<std::size_t, std::uint32_t>> queue;  // may be out of date: looked at again when taken
  for (std::uint32_t variable = 0; variable < variables; ++variable)
    queue.emplace(rows_with[variable].size(), variable);
  while (!queue.empty()) {
    const std::size_t count = queue.begin()->first;
    const std::uint32_t variable = queue.begin()->second;
    queue.erase(queue.begin());
    if (rows_with[variable].size() > count) {
      queue.emplace(rows_with[variable].size(), variable);
      continue;
    }
    if (rows_with[variable].empty()) continue;
    // a factor of 1 or -1 divides nothing
    const auto cost = [&](std::uint32_t row) {
      const std::uint64_t residue = rows_[row].at(variable).residue;
      return std::pair(residue == 1 || residue == kPrime - 1 ? 0 : 1, rows_[row].size());
    };
    const std::uint32_t row = *std::min_element(rows_with[variable].begin(), rows_with[variable].end(),
                                                [&](std::uint32_t a, std::uint32_t b) { return cost(a) < cost(b); });
    const std::set<std::uint32_t> others = rows_with[variable];
    leave(row);
    for (const std::uint32_t other : others) {
      if (other == row) continue;
      leave(other);
      subtract(rows_[other], rows_[row], quotient(rows_[other].at(variable), rows_[row].at(variable)));
      enter(other);
    }
    used_[row] = true;
    inner_pivots_.push_back({variable, row});
  }
}

/// What is left relates outer variables; a first choice of those that are determined.
void JunctionRank::reduce_outer() {
  for (std::uint32_t row = 0; row < rows_.size(); ++row) {
    if (used_[row] || rows_[row].empty()) continue;
    const auto simple = [](const auto& term) { return term.second.residue == 1 || term.second.residue == kPrime - 1; };
    auto term = std::find_if(rows_[row].begin(), rows_[row].end(), simple);
    if (term == rows_[row].end()) term = rows_[row].begin();
    pivot_on(row, term->first);
  }
}

void JunctionRank::pivot_on(std::uint32_t row, std::uint32_t variable) {
  for (std::uint32_t other = 0; other < rows_.size(); ++other) {
    if (other == row || used_[other]) continue;
    const auto term = rows_[other].find(variable);
    if (term == rows_[other].end()) continue;
    const Coefficient times = quotient(term->second, rows_[row].at(variable));
    subtract(rows_[other], rows_[row], times);
  }
  of_[variable] = row;
}

bool JunctionRank::take(std::uint32_t variable) {
  if (const auto pivot = of_.find(variable); pivot != of_.end()) {
    const std::uint32_t row = pivot->second;
    const Row& terms = rows_[row];
    const auto cost = [&](const auto& term) {
      const std::uint64_t residue = term.second.residue;
      return term.first == variable || taken_[term.first] ? 2 : residue == 1 || residue == kPrime - 1 ? 0 : 1;
    };
    const auto best =
        std::min_element(terms.begin(), terms.end(), [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    if (cost(*best) == 2) return false;
    of_.erase(pivot);
    pivot_on(row, best->first);
  }
  taken_[variable] = true;
  return true;
}

JunctionRank::Row JunctionRank::determined(std::uint32_t variable) const {
  const Row& terms = rows_[of_.at(variable)];
  const Coefficient own = product(number(-1), terms.at(variable));
  Row result;
  for (const auto& [other, factor] : terms)
    if (other != variable) result[other] = quotient(factor, own);
  return result;
}

std::vector<std::optional<JunctionRank::Row>> JunctionRank::solutions() {
  const std::size_t count = taken_.size();
  std::vector<Row> rows(count);
  for (std::uint32_t v = 0; v < count; ++v)
    rows[v] = of_.contains(v) ? determined(v) : Row{{v, number(1)}};  // inputs, and inner ones that nothing determines
  for (auto pivot = inner_pivots_.rbegin(); pivot != inner_pivots_.rend(); ++pivot) {
    const Row& terms = rows_[pivot->row];
    const Coefficient& own = terms.at(pivot->variable);
    Row sum;
    for (const auto& [other, factor] : terms)
      if (other != pivot->variable) subtract(sum, rows[other], quotient(factor, own));
    rows[pivot->variable] = std::move(sum);
  }
  std::vector<std::optional<Row>> result(count);
  for (std::uint32_t v = 0; v < count; ++v)
    if (std::none_of(rows[v].begin(), rows[v].end(), [&](const auto& term) { return inner(term.first); }))
      result[v] = std::move(rows[v]);
  return result;
}

}  // namespace bgsim
