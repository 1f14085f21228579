// Expressions of power series: shortly after an instant they are what the expressions are there.
#include "expression/series.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

using namespace bgsim;

namespace {

PowerSeries moving(double value) { return PowerSeries::of<3>({value, 0.7, -0.4}, {0.0, 0.0, 0.0}, true); }

double sum(const PowerSeries& series, double h) {
  double result = 0.0;
  for (int k = 0; k < PowerSeries::kTerms; ++k)
    result += series.coefficient[static_cast<std::size_t>(k)] * std::pow(h, series.order + k);
  return result;
}

double moved(double value, double h) { return value + 0.7 * h - 0.4 * h * h; }

}  // namespace

TEST_CASE("operators on power series give the values shortly after") {
  struct Case {
    Op op;
    std::vector<double> at;
  };
  const std::vector<Case> of_one{{Op::neg, {0.0, 2.0}},        {Op::abs, {0.0, -2.0, 3.0}}, {Op::sqrt, {0.5, 4.0}},
                                 {Op::cbrt, {-3.0, 0.5}},      {Op::exp, {0.0, -1.0, 2.0}}, {Op::expm1, {0.0, 1.0}},
                                 {Op::log, {0.5, 3.0}},        {Op::log10, {0.5, 3.0}},     {Op::log1p, {0.0, 2.0}},
                                 {Op::sin, {0.0, 1.0, -4.0}},  {Op::cos, {0.0, 1.0, -4.0}}, {Op::tan, {0.0, 1.0}},
                                 {Op::sinh, {0.0, 1.0}},       {Op::cosh, {0.0, -1.0}},     {Op::tanh, {0.0, -0.5}},
                                 {Op::asin, {0.0, 0.4, -0.3}}, {Op::acos, {0.0, 0.4}},      {Op::atan, {0.0, 2.0}},
                                 {Op::asinh, {0.0, 2.0}},      {Op::acosh, {2.0, 5.0}},     {Op::atanh, {0.0, 0.3}}};
  constexpr double h = 5e-3;
  constexpr double within = 1e-12;  // h^7 = 8e-17, times coefficients that grow up to some thousand
  for (const Case& c : of_one)
    for (const double at : c.at) {
      INFO("operator " << static_cast<int>(c.op) << " at " << at);
      const PowerSeries result = apply(c.op, moving(at), PowerSeries(), PowerSeries());
      REQUIRE(result.known >= 6);
      CHECK(std::abs(sum(result, h) - apply(c.op, moved(at, h))) <= within);
    }
  const std::vector<Case> of_two{{Op::add, {0.0, 1.0}},      {Op::sub, {0.0, 1.0}},   {Op::mul, {0.0, 1.0}},
                                 {Op::div, {0.0, 1.0}},      {Op::pow, {0.5, 2.0}},   {Op::min, {0.0, 1.0, 5.0}},
                                 {Op::max, {0.0, 1.0, 5.0}}, {Op::atan2, {0.0, 1.0}}, {Op::hypot, {0.0, 1.0}},
                                 {Op::ssqrt, {0.0, 1.0}}};
  for (const Case& c : of_two)
    for (const double at : c.at) {
      INFO("operator " << static_cast<int>(c.op) << " at " << at);
      const PowerSeries b = PowerSeries::of<2>({1.5, -0.3}, {0.0, 0.0}, true);
      const PowerSeries result = apply(c.op, moving(at), b, PowerSeries());
      REQUIRE(result.known >= 6);
      CHECK(std::abs(sum(result, h) - apply(c.op, moved(at, h), 1.5 - 0.3 * h)) <= within);
    }
}

TEST_CASE("a power of a series begins with the power of its leading term, or is not known") {
  const PowerSeries a = PowerSeries::of<4>({0.0, 0.0, 4.0, 1.0}, {0.0, 0.0, 0.0, 0.0}, true);  // 4 h^2 + h^3
  const PowerSeries root = apply(Op::sqrt, a, PowerSeries(), PowerSeries());                   // 2 h sqrt(1 + h/4)
  CHECK(root.order == 1);
  CHECK(root.coefficient[0] == Approx(2.0).epsilon(1e-15));  // a rounding or two
  CHECK(root.coefficient[1] == Approx(0.25).epsilon(1e-15));
  CHECK(apply(Op::pow, a, PowerSeries::number(3.0), PowerSeries()).order == 6);
  const PowerSeries odd = PowerSeries::of<2>({0.0, 1.0}, {0.0, 0.0}, true);
  CHECK(apply(Op::sqrt, odd, PowerSeries(), PowerSeries()).known < 0);  // h^0.5
  CHECK(apply(Op::floor, moving(1.0), PowerSeries(), PowerSeries()).known < 0);
  CHECK(apply(Op::floor, PowerSeries::number(1.5), PowerSeries(), PowerSeries()).coefficient[0] == 1.0);
}
