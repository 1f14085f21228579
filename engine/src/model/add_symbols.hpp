/// Parameters and signals that a stage adds to a model.
#pragma once

#include <string>

#include "bgsim/model.hpp"

namespace bgsim {

/// The names of DiodeLaw::band and holding and of ContactLaw::rest begin with these: their conditions are not the
/// model's.
inline constexpr const char* kBandParameter = "(band of ";
inline constexpr const char* kHoldingParameter = "(holding flow of ";
inline constexpr const char* kRestParameter = "(rest of ";

/// A parameter of the value 0.
ParameterId add_parameter(Model& model, std::string name);

/// A signal of the value 0; of an integral that is its rate, and it begins at 0.
SignalId add_signal(Model& model, std::string name, Signal::Kind kind);

}  // namespace bgsim
