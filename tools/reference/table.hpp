/// Writing and comparing reference tables.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace reference {

/// Rows of numbers under names; the first column is t.
struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<long double>> rows;
};

/// RFC 4180 with 17 significant digits, which a double survives.
inline void write_csv(const std::string& path, const Table& table) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) throw std::runtime_error("cannot write " + path);
  for (std::size_t i = 0; i < table.names.size(); ++i)
    std::fprintf(file, "%s%s", i == 0 ? "" : ",", table.names[i].c_str());
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i)
      std::fprintf(file, "%s%.17g", i == 0 ? "\r\n" : ",", static_cast<double>(row[i]));
  std::fprintf(file, "\r\n");
  std::fclose(file);
}

/// Largest difference of a column in two tables, divided by the column's largest magnitude or `least`, if that is more.
inline long double scaled_difference(const Table& a, const Table& b, std::size_t column, long double least = 0) {
  long double difference = 0, magnitude = least;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    difference = std::max(difference, std::fabs(a.rows[i][column] - b.rows[i][column]));
    magnitude = std::max(magnitude, std::fabs(a.rows[i][column]));
  }
  return magnitude > 0 ? difference / magnitude : difference;
}

/// Which times a table holds: `count` of them, equidistant, both ends included.
struct Grid {
  long double first, stop;
  std::size_t count;
};

/// The times of a grid, rounded to the doubles that are written, so that a solution belongs to the time beside it.
inline std::vector<long double> times_of(const Grid& grid) {
  const auto last = static_cast<long double>(grid.count - 1);
  std::vector<long double> times;
  for (std::size_t i = 0; i < grid.count; ++i) {
    const auto part = static_cast<long double>(i);
    times.push_back(static_cast<double>((grid.first * (last - part) + grid.stop * part) / last));
  }
  return times;
}

}  // namespace reference
