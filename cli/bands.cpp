#include "bands.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"

namespace bgsim::cli {

namespace {

/// Numbers that are held at a time: the traces are read again for each part of their rows.
constexpr std::size_t kBandNumbers = 50'000'000;

std::vector<std::string> trace_files(const std::vector<std::string>& folders) {
  std::vector<std::string> files;
  for (const std::string& folder : folders) {
    std::error_code fault;
    for (const auto& entry : std::filesystem::directory_iterator(folder, fault)) {
      const std::string name = entry.path().filename().string();
      constexpr std::string_view kHead = "trace.", kTail = ".csv";
      if (name.size() <= kHead.size() + kTail.size() || !name.starts_with(kHead) || !name.ends_with(kTail)) continue;
      const std::string_view number =
          std::string_view(name).substr(kHead.size(), name.size() - kHead.size() - kTail.size());
      if (number.find_first_not_of("0123456789") == std::string_view::npos) files.push_back(entry.path().string());
    }
    if (fault) throw UsageError("cannot read \"" + short_path(folder) + "\": " + fault.message());
  }
  std::sort(files.begin(), files.end());
  return files;
}

CsvTable trace_in(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw UsageError("cannot read \"" + short_path(path) + "\": " + std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  try {
    return parse_csv_cells(text.str()).table;
  } catch (const CsvError& error) {
    throw UsageError(short_path(path) + ":" + std::to_string(error.line) + ": " + error.without_text);
  }
}

/// @pre values are sorted, and there is one
double quantile_of(const std::vector<double>& values, double share) {
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 == values.size()) return values[below];
  return values[below] + (place - static_cast<double>(below)) * (values[below + 1] - values[below]);
}

/// The longest trace gives the times; a run that ended before gives the first of them.
void take_times(Bands& bands, const std::string& path, const CsvTable& trace) {
  const std::vector<double>& times = trace.columns.front();
  if (bands.traces++ == 0) {
    bands.time = trace.names.front();
    bands.names.assign(trace.names.begin() + 1, trace.names.end());
  } else if (trace.names.front() != bands.time ||
             !std::equal(bands.names.begin(), bands.names.end(), trace.names.begin() + 1, trace.names.end())) {
    throw UsageError("there are no bands: " + short_path(path) + " has other columns than the traces before it");
  }
  const std::size_t common = std::min(times.size(), bands.times.size());
  for (std::size_t i = 0; i < common; ++i)
    if (times[i] != bands.times[i])
      throw UsageError("there are no bands: " + short_path(path) + " has t = " + number_text(times[i]) +
                       " where others have " + number_text(bands.times[i]) +
                       "\n  give all runs the same start, stop and output times");
  if (times.size() > common) bands.times = times;
}

}  // namespace

Bands bands_of(const std::vector<std::string>& folders) {
  const std::vector<std::string> files = trace_files(folders);
  Bands bands;
  for (const std::string& path : files) take_times(bands, path, trace_in(path));
  const std::size_t rows = bands.times.size(), outputs = bands.names.size();
  bands.runs.assign(rows, 0);
  bands.of.resize(outputs);
  for (auto& shares : bands.of)
    for (auto& share : shares) share.assign(rows, std::numeric_limits<double>::quiet_NaN());
  const std::size_t part = std::max<std::size_t>(1, kBandNumbers / std::max<std::size_t>(1, files.size() * outputs));
  for (std::size_t first = 0; first < rows; first += part) {
    const std::size_t end = std::min(rows, first + part);
    std::vector<std::vector<double>> values((end - first) * outputs);
    for (const std::string& path : files) {
      const CsvTable trace = trace_in(path);
      for (std::size_t row = first; row < std::min(end, trace.columns.front().size()); ++row) {
        ++bands.runs[row];
        for (std::size_t o = 0; o < outputs; ++o)
          if (const double value = trace.columns[o + 1][row]; std::isfinite(value))
            values[(row - first) * outputs + o].push_back(value);
      }
    }
    for (std::size_t row = first; row < end; ++row)
      for (std::size_t o = 0; o < outputs; ++o) {
        std::vector<double>& own = values[(row - first) * outputs + o];
        if (own.empty()) continue;
        std::sort(own.begin(), own.end());
        for (std::size_t s = 0; s < kBandShares.size(); ++s)
          bands.of[o].at(s)[row] = quantile_of(own, kBandShares.at(s));
      }
  }
  return bands;
}

std::string bands_csv(const Bands& bands) {
  std::string text = csv_field(bands.time);
  for (const std::string& name : bands.names)
    for (const double share : kBandShares) text += "," + csv_field(name + " " + number_text(100.0 * share, 3) + " %");
  text += ",runs\r\n";
  const auto cell = [](double value) { return std::isnan(value) ? std::string() : number_text(value, 17); };
  for (std::size_t row = 0; row < bands.times.size(); ++row) {
    text += number_text(bands.times[row], 17);
    for (const auto& shares : bands.of)
      for (const auto& share : shares) text += "," + cell(share[row]);
    text += "," + std::to_string(bands.runs[row]) + "\r\n";
  }
  return text;
}

}  // namespace bgsim::cli
