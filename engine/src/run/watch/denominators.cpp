#include "run/watch/denominators.hpp"

#include <cmath>

namespace bgsim {

bool grows_without_bound(const Approach& approach, std::size_t states, const RatesAt& rates_at) {
  constexpr double kFactor = 2.0, kMoreThanRounding = 1e-2;
  constexpr int kDecades = 8, kInARow = 3;
  std::vector<double> x(approach.at.size()), rates(states), last(states), change(states, 0.0), first(states);
  std::vector<int> grew(states, 0);
  for (int decade = kDecades; decade >= 0; --decade) {
    const double distance = approach.nearest * std::pow(10.0, decade);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = approach.at[k] - distance * approach.slope[k];
    if (!rates_at(approach.t - distance, x.data(), rates.data())) return true;
    if (decade == kDecades) first = last = rates;
    for (std::size_t k = 0; k < states; ++k) {
      const double now = std::abs(rates[k] - last[k]);
      grew[k] = now > kFactor * change[k] && change[k] > 0.0 ? grew[k] + 1 : 0;
      change[k] = now;
    }
    last = rates;
  }
  for (std::size_t k = 0; k < states; ++k)
    if (grew[k] >= kInARow && change[k] > kMoreThanRounding * std::abs(first[k])) return true;
  return false;
}

Denominators::Denominators(const Program& program, std::span<const std::size_t> relation) {
  for (std::size_t guard = 0; guard < relation.size(); ++guard) {
    is_.push_back(program.relations[relation[guard]].kind == Relation::Kind::denominator);
    if (is_.back()) guards_.push_back(guard);
  }
}

std::optional<std::size_t> Denominators::next_to_zero(std::span<const double> values,
                                                      std::span<const double> largest) const {
  constexpr double kNothing = 1e-3;
  for (const std::size_t guard : guards_)
    if (std::abs(values[guard]) < kNothing * largest[guard]) return guard;
  return std::nullopt;
}

}  // namespace bgsim
