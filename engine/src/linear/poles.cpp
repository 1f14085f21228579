#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "linear/analysis.hpp"
#include "linear/dense.hpp"

namespace bgsim {
namespace {

/// Shares of less are not listed.
constexpr double kLeast = 1e-4;

void keep_largest(std::vector<PoleShare>& shares) {
  std::stable_sort(shares.begin(), shares.end(),
                   [](const PoleShare& a, const PoleShare& b) { return a.share > b.share; });
  std::erase_if(shares, [](const PoleShare& s) { return !(s.share >= kLeast); });
}

/// Mean energies of the stores in a mode, as parts of their sum.
std::vector<PoleShare> energy_shares(const LinearSystem& system, const BlockEigenvalue& pole) {
  std::vector<PoleShare> shares;
  double sum = 0.0;
  for (const StoreRows& store : system.stores) {
    double energy = 0.0;
    for (std::size_t port = 0; port < store.held.size(); ++port) {
      std::complex<double> held, conjugate;
      for (std::size_t i = 0; i < pole.rows.size(); ++i) {
        held += store.held[port][pole.rows[i]] * pole.mode[i];
        conjugate += store.conjugate[port][pole.rows[i]] * pole.mode[i];
      }
      energy += (std::conj(held) * conjugate).real();
    }
    if (!std::isfinite(energy)) return {};
    shares.push_back({store.name, std::abs(energy)});
    sum += shares.back().share;
  }
  if (!(sum > 0.0)) return {};
  for (PoleShare& share : shares) share.share /= sum;
  keep_largest(shares);
  return shares;
}

bool before(const Pole& a, const Pole& b) {
  const double fa = a.frequency(), fb = b.frequency();
  if (fa != fb) return fa < fb;
  return a.s.real() < b.s.real();
}

}  // namespace

double Pole::damping() const {
  const double size = std::abs(s);
  return size > 0.0 ? -s.real() / size : 1.0;
}

std::vector<Pole> poles_of(const LinearMatrix& matrix, const LinearSystem* system,
                           const std::optional<PolesNear>& some) {
  std::vector<BlockEigenvalue> values;
  try {
    values = eigenvalues_by_blocks(matrix, some);
  } catch (const std::length_error& error) {
    throw ModelError({diagnostic_of("BG409", std::string(error.what()) + ": too many for poles and zeros", {},
                                    "blocks of up to " + std::to_string(kLargestDense) + " states are solved densely",
                                    "bgsim poles --count 10 lists the ten nearest to 0, --near S those nearest to S; "
                                    "bgsim bode computes frequency responses of systems of any size")},
                     nullptr);
  } catch (const std::runtime_error& error) {
    throw ModelError({diagnostic_of("BG409", "the poles nearest to " + number_text(some->near, 6) + ": " + error.what(),
                                    {}, "each pole is confirmed with both of its vectors", "try another --near")},
                     nullptr);
  }
  std::vector<Pole> result;
  for (const BlockEigenvalue& value : values) {
    if (value.value.imag() < 0.0) continue;
    Pole pole;
    pole.s = value.value;
    pole.pair = value.value.imag() > 0.0;
    pole.error = value.error;
    for (const BlockEigenvalue& other : values)
      if (&other != &value && std::abs(other.value - value.value) <= 2.0 * (other.error + value.error)) ++pole.multiple;
    if (system != nullptr) {
      for (std::size_t i = 0; i < value.rows.size(); ++i)
        pole.participation.push_back({system->states[value.rows[i]].name, value.participation[i]});
      keep_largest(pole.participation);
      pole.energy = energy_shares(*system, value);
    }
    result.push_back(std::move(pole));
  }
  std::stable_sort(result.begin(), result.end(), before);
  if (some) {
    std::stable_sort(result.begin(), result.end(), [&](const Pole& a, const Pole& b) {
      return std::abs(a.s - some->near) < std::abs(b.s - some->near);
    });
    if (result.size() > some->count) result.resize(some->count);
  }
  return result;
}

std::vector<Pole> poles(const LinearSystem& system, const std::optional<PolesNear>& some) {
  return poles_of(system.a, &system, some);
}

std::vector<std::string> free_states(std::span<const Pole> poles) {
  std::vector<std::string> names;
  for (const Pole& pole : poles) {
    if (pole.s != 0.0) continue;
    for (const PoleShare& share : pole.participation)
      if (std::find(names.begin(), names.end(), share.name) == names.end()) names.push_back(share.name);
  }
  return names;
}

}  // namespace bgsim
