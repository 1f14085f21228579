/// --accuracy of run: the setting that gives it is found first.
#pragma once

#include <optional>

#include "bgsim/study.hpp"
#include "command.hpp"
#include "options.hpp"

namespace bgsim::cli {

/// The inputs of a scene with the cheapest setting found for an error of at most @p accuracy in the outputs; says
/// which. None if there is none, which it has said, too.
/// @param limits  of the search as a whole, and of the steps of each of its runs.
/// @throws Interrupted if the search is.
using AccuracySearch = std::optional<RunInputs> (*)(const Simulation& scene, double accuracy, const RunLimits& limits,
                                                    bool quiet);

/// The search; in a program without it, goes on as bgsim-studies with the words of this call of run.
/// @throws UsageError as hand_over().
AccuracySearch accuracy_search(const Arguments& arguments);

}  // namespace bgsim::cli
