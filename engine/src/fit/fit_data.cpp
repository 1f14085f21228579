// What a fit is asked for, as texts: ranges and tables of measurements.
#include <charconv>
#include <cmath>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/fit.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

/// The bound @p text, or @p open if there is none.
std::optional<double> bound_of(std::string_view text, double open) {
  const std::string_view word = trimmed(text);
  if (word.empty()) return open;
  double value = 0.0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

[[noreturn]] void refuse_range(const std::string& text, const std::string& what, std::string help) {
  throw ModelError({diagnostic_of("BG416", "--vary " + in_quotes(text) + what, {},
                                  "a range is NAME=LOWER:UPPER with LOWER below UPPER; one of the two may be missing",
                                  std::move(help))},
                   {});
}

}  // namespace

FitVariation parse_fit_variation(const std::string& text) {
  FitVariation variation;
  const auto equals = text.find('=');
  variation.name = trimmed(std::string_view(text).substr(0, equals));
  if (variation.name.empty()) refuse_range(text, " has no name", "write --vary k=300:400, or --vary k");
  if (equals == std::string::npos) return variation;
  const std::string_view range = std::string_view(text).substr(equals + 1);
  const auto colon = range.find(':');
  const bool bounds = colon != std::string_view::npos && range.find(':', colon + 1) == std::string_view::npos;
  const auto lower = bounds ? bound_of(range.substr(0, colon), variation.lower) : std::nullopt;
  const auto upper = bounds ? bound_of(range.substr(colon + 1), variation.upper) : std::nullopt;
  if (!lower || !upper)
    refuse_range(text, " is no range of numbers",
                 "write --vary " + variation.name + "=300:400, say; --set gives the value to start from");
  if (*lower == *upper)
    refuse_range(text, " is an empty range",
                 "leave " + in_quotes(variation.name) + " out of --vary, and set it with --set");
  if (*lower > *upper)
    refuse_range(text, " is a range that ends before it begins",
                 "write --vary " + variation.name + "=" + number_text(*upper) + ":" + number_text(*lower));
  variation.lower = *lower;
  variation.upper = *upper;
  return variation;
}

FitData fit_data(const std::string& scene, const std::string& name, std::string_view text) {
  try {
    return {scene, name, parse_csv_cells(text)};
  } catch (const CsvError& error) {
    throw ModelError({diagnostic_of("BG417", short_path(name) + ":" + std::to_string(error.line) + ": " + error.what(),
                                    {}, "data are a CSV file: names of the columns, then a row for each time",
                                    "write them with commas between the cells; a cell may be empty")},
                     {});
  }
}

}  // namespace bgsim
