/// Linear systems as files.
#pragma once

#include <string>

#include "bgsim/linear.hpp"

namespace bgsim::cli {

/// Keys: docs/linear.md.
std::string linear_json(const LinearSystem& system, const std::string& where, bool descriptor);
/// "matrix,row,column,value", one record for each entry that is not zero, by names.
std::string linear_csv(const LinearSystem& system, bool descriptor);
/// A script for Octave and MATLAB.
std::string linear_m(const LinearSystem& system, const std::string& where, bool descriptor);
/// For people.
std::string linear_text(const LinearSystem& system, const std::string& where, bool descriptor);

}  // namespace bgsim::cli
