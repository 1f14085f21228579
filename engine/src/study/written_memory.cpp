#include "study/written_memory.hpp"

namespace bgsim {

bool is_of_memory(const ModelEvent& event) { return event.at_start; }

std::vector<WrittenMemory> written_memory(const Model& model) {
  std::vector<WrittenMemory> result(model.signals.size());
  for (const ModelEvent& event : model.events) {
    if (!is_of_memory(event)) continue;
    const SignalId signal = event.sets.front().signal;
    WrittenMemory& memory = result[signal.index()];
    if (event.sampled.valid()) {
      memory.kind = event.sampled == signal ? WrittenMemory::Kind::sampled : WrittenMemory::Kind::previous;
      memory.of = event.sampled;
      memory.takes = &event;
    } else {
      // The one that sets comes first.
      (memory.kind == WrittenMemory::Kind::latch ? memory.resets : memory.takes) = &event;
      memory.kind = WrittenMemory::Kind::latch;
    }
  }
  return result;
}

}  // namespace bgsim
