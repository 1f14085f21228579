#include "run/sink/pade_exponential.hpp"

#include <algorithm>
#include <array>
#include <complex>

namespace bgsim {

namespace {

/// One of each pair of the approximant's poles, and the residue there.
struct PadePole {
  std::complex<double> at, residue;
};
constexpr std::array<PadePole, 2> kPadePoles{
    {{{3.21280689687153398, 4.77308743327664250}, {-11.301539995971487, 12.471675850250231}},
     {{4.78719310312846602, 1.56747641689520812}, {13.301539995971487, -60.071732737047443}}}};

}  // namespace

bool PadeExponential::apply(const std::vector<double>& jacobian, double h, const std::vector<double>& x,
                            std::vector<double>& out) {
  const std::size_t n = x.size();
  std::fill(out.begin(), out.end(), 0.0);
  for (const PadePole& pole : kPadePoles) {
    double *const re = lu_.real(), *const im = lu_.imaginary();
    std::fill_n(im, n * n, 0.0);
    for (std::size_t k = 0; k < n * n; ++k) re[k] = h * jacobian[k];
    for (std::size_t i = 0; i < n; ++i) {
      re[i * n + i] -= pole.at.real();
      im[i * n + i] = -pole.at.imag();
    }
    if (!lu_.factor()) return false;
    part_ = x;
    std::fill(imaginary_part_.begin(), imaginary_part_.end(), 0.0);
    lu_.solve(part_.data(), imaginary_part_.data());
    for (std::size_t i = 0; i < n; ++i)
      out[i] += 2.0 * (pole.residue.real() * part_[i] - pole.residue.imag() * imaginary_part_[i]);
  }
  return true;
}

}  // namespace bgsim
