/// The collocation polynomial of a step by Radau IIA of order 5.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "run/integrate/radau_formula.hpp"

namespace bgsim {

/// In divided differences, in units of the step, from its end.
class RadauPolynomial {
 public:
  explicit RadauPolynomial(std::size_t size) {
    for (std::vector<double>& difference : divided_) difference.assign(size, 0.0);
  }

  /// @param z  the stages' increments
  void fit(const std::array<std::vector<double>, 3>& z) {
    for (std::size_t i = 0; i < divided_[0].size(); ++i) {
      const double a = (z[1][i] - z[2][i]) / (radau::kAt[1] - 1.0);
      const double b = (z[0][i] - z[1][i]) / (radau::kAt[0] - radau::kAt[1]);
      const double c = (b - z[0][i] / radau::kAt[0]) / radau::kAt[1];
      divided_[0][i] = a;
      divided_[1][i] = (b - a) / (radau::kAt[0] - 1.0);
      divided_[2][i] = divided_[1][i] - c;
    }
  }

  /// The change of state i from the step's end, @p s steps beyond it.
  [[nodiscard]] double from_end(std::size_t i, double s) const {
    return s *
           (divided_[0][i] + (s + 1.0 - radau::kAt[1]) * (divided_[1][i] + (s + 1.0 - radau::kAt[0]) * divided_[2][i]));
  }

 private:
  std::array<std::vector<double>, 3> divided_;
};

}  // namespace bgsim
