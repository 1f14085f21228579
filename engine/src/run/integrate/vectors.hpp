/// Operations on SUNDIALS' serial vectors.
#pragma once

#include <sundials/sundials_nvector.h>

namespace bgsim {

/// Replaces the operations of a serial vector, and of all its clones, by loops that this project's compiler optimises:
/// Debian's SUNDIALS is compiled without optimisation, and half of a run of a large model was spent in them. Sums of
/// several vectors are taken in one pass. All values are those of SUNDIALS bit for bit: the same operations on each
/// component in the same order.
void use_own_operations(N_Vector vector);

}  // namespace bgsim
