/// The Runge-Kutta methods by their Butcher tables: ARKODE's own, and those that ARKODE 5.4 does not hold: of order
/// one, the classical one, and Prince and Dormand's of order eight.
#pragma once

#include <arkode/arkode_arkstep.h>

#include <memory>
#include <string>

#include "bgsim/method.hpp"

namespace bgsim {

struct ButcherTableDeleter {
  void operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
};
using ButcherTableHandle = std::unique_ptr<std::remove_pointer_t<ARKodeButcherTable>, ButcherTableDeleter>;

/// The table of a Runge-Kutta method; see method.cpp for their names.
/// @throws std::bad_alloc when memory runs out.
ButcherTableHandle butcher_table(Method method);

}  // namespace bgsim
