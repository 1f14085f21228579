/// Whether a matrix has a power of one sign, exactly.
#pragma once

#include <vector>

namespace bgsim {

/// Whether u^T G u >= 0 for all u: whether the symmetric part of @p matrix (n by n, by rows) is positive semidefinite.
/// In whole numbers, exactly, so that matrices with an eigenvalue of 0 are recognized: G is what its doubles say.
/// Cost: n^3 operations on numbers that grow; for some ten ports.
bool is_positive_semidefinite(const std::vector<std::vector<double>>& matrix);

/// A u of length 1 with u^T G u < 0, found in doubles; empty if none is found.
std::vector<double> direction_of_negative_power(const std::vector<std::vector<double>>& matrix);

}  // namespace bgsim
