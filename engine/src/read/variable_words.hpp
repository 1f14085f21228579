/// The variables of a bond by the names that they have in the domains.
#pragma once

#include <optional>
#include <string_view>

#include "bgsim/model.hpp"

namespace bgsim {

/// Which variable a letter or word of a domain means: "F" and "voltage" the effort, "v" the flow. Where a letter means
/// two, that which the law of a port relates that holds @p stored (none: it is no store's).
std::optional<Variable> variable_called(std::string_view name, std::optional<Variable> stored);
/// "effort (force, voltage, torque, pressure, ...)".
const char* variable_words(Variable variable);

}  // namespace bgsim
