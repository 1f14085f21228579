// Own operations on SUNDIALS' vectors hold what those of SUNDIALS do, bit for bit.
#include "run/integrate/vectors.hpp"

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace bgsim;

namespace {

constexpr sunindextype kSize = 37;

/// Three vectors of random numbers of both signs and of magnitudes from 1e-3 to 1e3.
struct Three {
  explicit Three(bool own) {
    SUNContext_Create(nullptr, &context);
    v[0] = N_VNew_Serial(kSize, context);
    if (own) use_own_operations(v[0]);
    v[1] = N_VClone(v[0]);
    v[2] = N_VClone(v[0]);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> number(-3.0, 3.0);
    for (N_Vector vector : v)
      for (sunindextype i = 0; i < kSize; ++i)
        NV_Ith_S(vector, i) = (i % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, number(random));
  }
  ~Three() {
    for (N_Vector vector : v) N_VDestroy(vector);
    SUNContext_Free(&context);
  }
  Three(const Three&) = delete;
  Three& operator=(const Three&) = delete;
  [[nodiscard]] std::vector<double> all() const {
    std::vector<double> values;
    for (N_Vector vector : v) values.insert(values.end(), NV_DATA_S(vector), NV_DATA_S(vector) + kSize);
    return values;
  }
  SUNContext context = nullptr;
  std::array<N_Vector, 3> v{};
};

template <class F>
void check_same(const F& f) {
  Three theirs(false), ours(true);
  const double their_value = f(theirs), our_value = f(ours);
  CHECK(our_value == their_value);
  CHECK(ours.all() == theirs.all());
}

}  // namespace

TEST_CASE("own operations on vectors give the bits of SUNDIALS") {
  const std::array<double, 7> factors{1.0, -1.0, 0.0, 0.3, -0.3, 7.7, -1e-3};
  for (const double a : factors)
    for (const double b : factors)
      for (const std::array<std::size_t, 3> at : {std::array<std::size_t, 3>{0, 1, 2}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}})
        check_same([&](Three& x) {
          N_VLinearSum(a, x.v[at[0]], b, x.v[at[1]], x.v[at[2]]);
          return 0.0;
        });
  for (const double a : factors)
    for (const std::size_t to : {std::size_t{0}, std::size_t{1}})
      check_same([&](Three& x) {
        N_VScale(a, x.v[0], x.v[to]);
        N_VAddConst(x.v[0], a, x.v[2]);
        return 0.0;
      });
  check_same([](Three& x) {
    N_VProd(x.v[0], x.v[1], x.v[2]);
    N_VDiv(x.v[2], x.v[0], x.v[1]);
    N_VInv(x.v[1], x.v[0]);
    N_VAbs(x.v[0], x.v[0]);
    return N_VDotProd(x.v[0], x.v[1]) + N_VMaxNorm(x.v[2]) + N_VWrmsNorm(x.v[0], x.v[1]);
  });
  check_same([](Three& x) {
    N_VConst(0.0, x.v[0]);
    return N_VWrmsNorm(x.v[0], x.v[1]);
  });
  for (const double a : factors)
    check_same([&](Three& x) {
      std::array<double, 3> c{a, 0.7, -1.0};
      std::array<N_Vector, 3> from{x.v[2], x.v[0], x.v[1]};
      N_VLinearCombination(3, c.data(), from.data(), x.v[2]);
      N_VScaleAddMulti(2, c.data(), x.v[2], x.v.data(), x.v.data());
      return 0.0;
    });
  check_same([](Three& x) {  // more than are taken in one pass
    std::vector<double> c(20, 0.9);
    std::vector<N_Vector> from(20, x.v[0]);
    N_VLinearCombination(20, c.data(), from.data(), x.v[2]);
    return 0.0;
  });
}
