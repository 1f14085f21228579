/// Symbols of a model replaced by expressions, wherever it has them.
#pragma once

#include <unordered_map>

#include "bgsim/model.hpp"

namespace bgsim {

/// In elements, signals, outputs and events; not in what is over parameters alone (their own values, initial values,
/// scenes), nor in the times at which signals are sampled.
void replace_symbols(Model& model, const std::unordered_map<SymbolId, ExprId>& replacement);

}  // namespace bgsim
