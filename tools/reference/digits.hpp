/// Numbers of 50 digits, and tables of them.
#pragma once

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <functional>
#include <string>
#include <vector>

#include "table.hpp"

namespace reference {

using Number = boost::multiprecision::cpp_bin_float_50;
inline const Number kPi = boost::math::constants::pi<Number>();

/// A decimal constant as a model file gives it: rounded to double first.
inline Number given(double value) { return Number(value); }

inline void write(const std::string& folder, const std::string& name, const std::vector<std::string>& columns,
                  double stop, std::size_t samples, const std::function<std::vector<Number>(const Number& t)>& row) {
  Table table{columns, {}};
  for (const long double t : times_of({0, stop, samples})) {
    std::vector<long double> numbers{t};
    for (const Number& value : row(Number(t))) numbers.push_back(static_cast<long double>(value));
    table.rows.push_back(numbers);
  }
  write_csv(folder + "/" + name + ".csv", table);
}

}  // namespace reference
