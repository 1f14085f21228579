#include "run/sink/gauss_rule.hpp"

#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cstddef>

namespace bgsim {

namespace {

template <unsigned kPoints>
GaussRule rule_with() {
  using Gauss = boost::math::quadrature::gauss<double, kPoints>;
  GaussRule rule;
  const auto& abscissa = Gauss::abscissa();  // of the right half
  const auto& weights = Gauss::weights();
  for (std::size_t i = abscissa.size(); i-- > 0;)
    if (abscissa[i] != 0.0) {
      rule.position.push_back(0.5 - abscissa[i] / 2);
      rule.weight.push_back(weights[i] / 2);
    }
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    rule.position.push_back(0.5 + abscissa[i] / 2);
    rule.weight.push_back(weights[i] / 2);
  }
  std::vector<double> points;
  for (const double half : {0.0, 0.5})
    for (const double position : rule.position) points.push_back(half + position / 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    double weight = 1.0;  // Lagrange's
    for (std::size_t k = 0; k < points.size(); ++k)
      if (k != i) weight *= points[k] / (points[k] - points[i]);
    rule.at_begin.push_back(weight);
  }
  return rule;
}

}  // namespace

const GaussRule& gauss_rule(int points) {
  static const std::array<GaussRule, kMostGaussPoints> rules{
      rule_with<1>(), rule_with<2>(), rule_with<3>(), rule_with<4>(), rule_with<5>(), rule_with<6>(), rule_with<7>()};
  return rules.at(static_cast<std::size_t>(points - 1));
}

}  // namespace bgsim
