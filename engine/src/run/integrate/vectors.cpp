#include "run/integrate/vectors.hpp"

#include <nvector/nvector_serial.h>

#include <algorithm>
#include <cmath>

namespace bgsim {

namespace {

double* data(N_Vector vector) { return NV_DATA_S(vector); }
sunindextype length(N_Vector vector) { return NV_LENGTH_S(vector); }

template <class F>
void each(N_Vector z, const F& f) {
  double* const out = data(z);
  const sunindextype n = length(z);
  for (sunindextype i = 0; i < n; ++i) out[i] = f(i);
}

/// a x + b y. SUNDIALS multiplies the sum where a is b, and the difference where it is -b.
void linear_sum(double a, N_Vector x, double b, N_Vector y, N_Vector z) {
  const double *const u = data(x), *const v = data(y);
  const bool adds = (b == 1.0 && z == y) || (a == 1.0 && z == x) || a == 1.0 || b == 1.0 || a == -1.0 || b == -1.0;
  if (!adds && a == b)
    each(z, [=](sunindextype i) { return a * (u[i] + v[i]); });
  else if (!adds && a == -b)
    each(z, [=](sunindextype i) { return a * (u[i] - v[i]); });
  else if (a == 1.0)
    each(z, [=](sunindextype i) { return u[i] + b * v[i]; });
  else if (b == 1.0)
    each(z, [=](sunindextype i) { return a * u[i] + v[i]; });
  else
    each(z, [=](sunindextype i) { return a * u[i] + b * v[i]; });
}

void constant(double c, N_Vector z) {
  each(z, [=](sunindextype) { return c; });
}
void product(N_Vector x, N_Vector y, N_Vector z) {
  const double *const u = data(x), *const v = data(y);
  each(z, [=](sunindextype i) { return u[i] * v[i]; });
}
void quotient(N_Vector x, N_Vector y, N_Vector z) {
  const double *const u = data(x), *const v = data(y);
  each(z, [=](sunindextype i) { return u[i] / v[i]; });
}
void scale(double c, N_Vector x, N_Vector z) {
  const double* const u = data(x);
  if (c == 1.0 && x == z) return;
  each(z, [=](sunindextype i) { return c * u[i]; });
}
void magnitude(N_Vector x, N_Vector z) {
  const double* const u = data(x);
  each(z, [=](sunindextype i) { return std::fabs(u[i]); });
}
void inverse(N_Vector x, N_Vector z) {
  const double* const u = data(x);
  each(z, [=](sunindextype i) { return 1.0 / u[i]; });
}
void add_constant(N_Vector x, double b, N_Vector z) {
  const double* const u = data(x);
  each(z, [=](sunindextype i) { return u[i] + b; });
}

double dot(N_Vector x, N_Vector y) {
  const double *const u = data(x), *const v = data(y);
  const sunindextype n = length(x);
  double sum = 0.0;
  for (sunindextype i = 0; i < n; ++i) sum += u[i] * v[i];
  return sum;
}
double largest(N_Vector x) {
  const double* const u = data(x);
  const sunindextype n = length(x);
  double most = 0.0;
  for (sunindextype i = 0; i < n; ++i)
    if (std::fabs(u[i]) > most) most = std::fabs(u[i]);
  return most;
}
/// SUNDIALS takes this sum twice for one norm: its square root is a macro.
double weighted_norm(N_Vector x, N_Vector w) {
  const double *const u = data(x), *const v = data(w);
  const sunindextype n = length(x);
  // Sums that do not wait for each other, but where there are few terms.
  constexpr sunindextype kSums = 8, kFew = 64;
  double sums[kSums] = {};
  sunindextype from = 0;
  if (n > kFew)
    for (; from + kSums <= n; from += kSums)
      for (sunindextype k = 0; k < kSums; ++k) {
        const double part = u[from + k] * v[from + k];
        sums[k] += part * part;
      }
  double sum = ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  for (; from < n; ++from) {
    const double part = u[from] * v[from];
    sum += part * part;
  }
  const double mean = sum / static_cast<double>(n);
  return mean <= 0.0 ? 0.0 : std::sqrt(mean);
}

/// Sum of c[k] x[k], one after the other for each component; x[0] may be z.
int linear_combination(int count, double* c, N_Vector* x, N_Vector z) {
  constexpr int kInOnePass = 16;
  if (count < 1 || count > kInOnePass) {
    if (count < 1) return -1;
    scale(c[0], x[0], z);
    for (int k = 1; k < count; ++k) linear_sum(c[k], x[k], 1.0, z, z);
    return 0;
  }
  const double* from[kInOnePass];
  for (int k = 0; k < count; ++k) from[k] = data(x[k]);
  // Piece by piece: the sums of one stay in the processor's nearest memory, and each term is added to all at once.
  constexpr sunindextype kPiece = 256;
  double* const out = data(z);
  const sunindextype n = length(z);
  double sums[kPiece];
  for (sunindextype begin = 0; begin < n; begin += kPiece) {
    const sunindextype size = std::min(kPiece, n - begin);
    const double* const first = from[0] + begin;
    for (sunindextype i = 0; i < size; ++i) sums[i] = c[0] * first[i];
    for (int k = 1; k < count; ++k) {
      const double *const next = from[k] + begin, factor = c[k];
      for (sunindextype i = 0; i < size; ++i) sums[i] += factor * next[i];
    }
    std::copy_n(sums, size, out + begin);
  }
  return 0;
}

/// z[k] = a[k] x + y[k]
int scale_add_multi(int count, double* a, N_Vector x, N_Vector* y, N_Vector* z) {
  if (count < 1) return -1;
  for (int k = 0; k < count; ++k) linear_sum(a[k], x, 1.0, y[k], z[k]);
  return 0;
}

}  // namespace

void use_own_operations(N_Vector vector) {
  auto& operations = *vector->ops;
  operations.nvlinearsum = linear_sum;
  operations.nvconst = constant;
  operations.nvprod = product;
  operations.nvdiv = quotient;
  operations.nvscale = scale;
  operations.nvabs = magnitude;
  operations.nvinv = inverse;
  operations.nvaddconst = add_constant;
  operations.nvdotprod = operations.nvdotprodlocal = dot;
  operations.nvmaxnorm = operations.nvmaxnormlocal = largest;
  operations.nvwrmsnorm = weighted_norm;
  operations.nvlinearcombination = linear_combination;
  operations.nvscaleaddmulti = scale_add_multi;
}

}  // namespace bgsim
