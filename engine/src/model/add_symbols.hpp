/// Parameters and signals that a stage adds to a model.
#pragma once

#include <string>

#include "bgsim/model.hpp"

namespace bgsim {

/// A parameter of the value 0.
ParameterId add_parameter(Model& model, std::string name);

/// A signal of the value 0; of an integral that is its rate, and it begins at 0.
SignalId add_signal(Model& model, std::string name, Signal::Kind kind);

}  // namespace bgsim
