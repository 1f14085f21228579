/// --accuracy of run: the setting that gives it is found first.
#pragma once

#include "bgsim/study.hpp"
#include "bgsim/trade.hpp"

namespace bgsim::cli {

/// The inputs of @p scene with the cheapest setting found for an error of at most @p accuracy in the outputs; says
/// which.
/// @throws TradeFailure; Interrupted if the search is.
RunInputs with_accuracy(const Simulation& scene, double accuracy, bool quiet);

}  // namespace bgsim::cli
