/// Ctrl-C, kill and a closed terminal: every command ends in good order, with exit code 3.
#pragma once

#include <stdexcept>

namespace bgsim::cli {

/// The command was interrupted, and what it has so far is not worth keeping. Exit::numerics_failed.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From here on SIGINT, SIGTERM and SIGHUP end the process with exit code 3, its partial files removed. A signal that
/// is ignored stays so: a run in the background is not meant by a Ctrl-C.
void catch_interruptions();

/// While one lives, the first interruption is only noted, and the work asks for it. The second ends the process.
class InterruptionsNoted {
 public:
  InterruptionsNoted();
  ~InterruptionsNoted();
  InterruptionsNoted(const InterruptionsNoted&) = delete;
  InterruptionsNoted& operator=(const InterruptionsNoted&) = delete;
};

/// Whether an interruption was noted; stays so until the process ends.
[[nodiscard]] bool was_interrupted();

/// While one lives, interruptions wait: for what is short and must not stop halfway.
class InterruptionsHeld {
 public:
  InterruptionsHeld();
  ~InterruptionsHeld();
  InterruptionsHeld(const InterruptionsHeld&) = delete;
  InterruptionsHeld& operator=(const InterruptionsHeld&) = delete;
};

}  // namespace bgsim::cli
