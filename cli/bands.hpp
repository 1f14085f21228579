/// Bands of the traces of a sweep: between which values an output lies in most of its runs.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bgsim::cli {

inline constexpr std::array kBandShares{0.05, 0.5, 0.95};

/// Quantiles of each output over the runs at each time, straight lines between runs in order.
struct Bands {
  std::string time;  ///< name of the traces' first column
  std::vector<double> times;
  std::vector<std::string> names;                                       ///< of the outputs
  std::vector<std::array<std::vector<double>, kBandShares.size()>> of;  ///< by output, share, time
  std::vector<std::uint64_t> runs;                                      ///< by time: how many have come so far
  std::uint64_t traces = 0;
};

/// Bands of all trace.N.csv in the folders; without traces there are none.
/// @throws UsageError  the traces have different columns or times, or are no traces.
Bands bands_of(const std::vector<std::string>& folders);

/// t, then "x 5 %", "x 50 %", "x 95 %" of each output, then the number of runs.
std::string bands_csv(const Bands& bands);

}  // namespace bgsim::cli
