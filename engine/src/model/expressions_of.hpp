/// The expressions by which a model's elements, signals and events depend on others. Initial values, sampling times and
/// delays are none: they name parameters only.
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// Some may be none.
std::vector<ExprId> expressions_of(const Element& element);
std::vector<ExprId> expressions_of(const Signal& signal);
std::vector<ExprId> expressions_of(const ModelEvent& event);

}  // namespace bgsim
