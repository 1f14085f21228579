/// The same task for many things, side by side.
#pragma once

#include <cstddef>
#include <functional>

namespace bgsim {

/// Calls task(0) to task(count - 1), on up to @p threads threads, the caller's among them: each takes the next one when
/// it has done one. Ends when all are done.
/// @throws what the first of the tasks (by number) threw that threw anything.
void in_threads(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task);

}  // namespace bgsim
