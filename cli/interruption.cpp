#include "interruption.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string_view>

#include "command.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

// A signal handler can reach nothing else.
volatile std::sig_atomic_t noted = 0, noting = 0;

extern "C" void interrupt(int) {
  const int before = errno;
  if (noting > 0 && noted == 0) {
    noted = 1;
    errno = before;
    return;
  }
  constexpr std::string_view kText = "bgsim: interrupted\n";
  (void)!::write(STDERR_FILENO, kText.data(), kText.size());
  remove_partial_files();
  ::_exit(static_cast<int>(Exit::numerics_failed));
}

sigset_t signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : kSignals) sigaddset(&set, signal);
  return set;
}

int holds = 0;

}  // namespace

void catch_interruptions() {
  for (const int signal : kSignals) {
    struct sigaction now {
    }, old{};
    now.sa_handler = interrupt;
    now.sa_mask = signals();
    now.sa_flags = SA_RESTART;
    if (sigaction(signal, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) sigaction(signal, &now, nullptr);
  }
}

InterruptionsNoted::InterruptionsNoted() { noting = noting + 1; }
InterruptionsNoted::~InterruptionsNoted() { noting = noting - 1; }

bool was_interrupted() { return noted != 0; }

InterruptionsHeld::InterruptionsHeld() {
  const sigset_t set = signals();
  if (holds++ == 0) sigprocmask(SIG_BLOCK, &set, nullptr);
}
InterruptionsHeld::~InterruptionsHeld() {
  const sigset_t set = signals();
  if (--holds == 0) sigprocmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace bgsim::cli
