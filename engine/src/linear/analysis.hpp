/// What poles, zeros and responses share.
#pragma once

#include "bgsim/linear.hpp"

namespace bgsim {

/// Eigenvalues of a matrix as poles(). @param system  whose shares they get; none: no shares.
std::vector<Pole> poles_of(const LinearMatrix& matrix, const LinearSystem* system,
                           const std::optional<PolesNear>& some = {});

}  // namespace bgsim
