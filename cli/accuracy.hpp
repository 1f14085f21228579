/// --accuracy of run: the setting that gives it is found first.
#pragma once

#include "bgsim/trade.hpp"

namespace bgsim::cli {

/// The inputs with the cheapest setting found for an error of at most @p accuracy in the outputs; says which.
/// @param program  compiled for these inputs.
/// @throws TradeFailure; Interrupted if the search is.
RunInputs with_accuracy(const Model& model, const EquationSystem& system, const Program& program,
                        const RunInputs& inputs, double accuracy, bool quiet);

}  // namespace bgsim::cli
