/// The collocation polynomial of a step by Radau IIA.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "run/integrate/radau_formula.hpp"

namespace bgsim {

/// In divided differences, in units of the step, from its end.
template <std::size_t Stages>
class RadauPolynomial {
 public:
  explicit RadauPolynomial(std::size_t size) {
    for (std::vector<double>& difference : divided_) difference.assign(size, 0.0);
  }

  /// @param z  the stages' increments
  void fit(const std::array<std::vector<double>, Stages>& z) {
    constexpr auto& at = radau::kTable<Stages>.at;
    for (std::size_t i = 0; i < divided_[0].size(); ++i) {
      // Of ever more points, from the last stage backward; the last point is the beginning.
      std::array<double, Stages> d{};
      for (std::size_t k = 0; k + 1 < Stages; ++k) {
        const std::size_t stage = Stages - 1 - k;
        d[k] = (z[stage - 1][i] - z[stage][i]) / (at[stage - 1] - at[stage]);
      }
      d[Stages - 1] = z[0][i] / at[0];
      divided_[0][i] = d[0];
      for (std::size_t level = 1; level < Stages; ++level) {
        for (std::size_t k = 0; k + level < Stages; ++k) {
          const double from = at[Stages - 1 - k];
          const double to = k + level + 1 < Stages ? at[Stages - 2 - k - level] : 0.0;
          d[k] = (d[k + 1] - d[k]) / (to - from);
        }
        divided_[level][i] = d[0];
      }
    }
  }

  /// The change of state i from the step's end, @p s steps beyond it.
  [[nodiscard]] double from_end(std::size_t i, double s) const {
    constexpr auto& at = radau::kTable<Stages>.at;
    double sum = divided_[Stages - 1][i];
    for (std::size_t k = Stages - 1; k-- > 0;) sum = divided_[k][i] + (s + 1.0 - at[Stages - 2 - k]) * sum;
    return s * sum;
  }

 private:
  std::array<std::vector<double>, Stages> divided_;
};

}  // namespace bgsim
