/// How signals with memory were written: read, each is an integral of 0 and events that set it (read/memory.cpp).
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

struct WrittenMemory {
  enum class Kind : std::uint8_t { none, sampled, previous, latch };
  Kind kind = Kind::none;
  SignalId of;                         ///< previous: of which sampled signal
  const ModelEvent* takes = nullptr;   ///< sampled: the event of a sample; latch: that of "set"
  const ModelEvent* resets = nullptr;  ///< latch
};

/// By SignalId. The events are the model's own.
std::vector<WrittenMemory> written_memory(const Model& model);

/// Whether an event belongs to a signal with memory, and is none of the file's "events".
[[nodiscard]] bool is_of_memory(const ModelEvent& event);

}  // namespace bgsim
