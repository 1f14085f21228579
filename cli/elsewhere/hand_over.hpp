/// Commands that are in another program beside bgsim, so that bgsim itself is built and starts without what they need
/// (docs/design/build.md).
#pragma once

#include "command.hpp"

namespace bgsim::cli {

/// Goes on as @p program, which lies beside this one, with the words "bgsim COMMAND ARGUMENTS". In a build folder of
/// scripts/bgsim that script builds it first, if it is not there yet.
/// @param without  what this bgsim was built without, and how to get it, if there is neither.
/// @throws UsageError if there is no such program, or it cannot be started.
[[noreturn]] void hand_over(const char* program, const char* command, const Arguments& arguments, const char* without);

}  // namespace bgsim::cli
