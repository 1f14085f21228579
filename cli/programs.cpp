#include "programs.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "interruption.hpp"
#include "scratch.hpp"

extern char** environ;

namespace bgsim::cli {

namespace {

/// No layout of a graph that can be looked at takes nearly as long.
constexpr std::chrono::seconds kLongestProgram{900};

std::string missing(const ExternalProgram& program) {
  return std::string(program.name) + ", which " + program.purpose + ", is not installed (Debian: apt-get install " +
         program.package + ")";
}

/// Where a program is; empty if nowhere. Folders of PATH that are named from the working folder ("", ".") do not count:
/// what lies beside somebody's model is not to be run.
std::string path_of(const ExternalProgram& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string file = folder + "/" + program.name;
    std::error_code ignored;
    if (folder.starts_with('/') && ::access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file, ignored))
      return file;
  }
  return {};
}

/// The signals that end a process, but for those that are ignored (nohup), and the one that tells of a child's end.
sigset_t awaited_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGCHLD);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaddset(&set, signal);
  }
  return set;
}

/// Holds these signals back, so that they can be waited for.
class HeldSignals {
 public:
  HeldSignals() : set_(awaited_signals()) { ::pthread_sigmask(SIG_BLOCK, &set_, &before_); }
  ~HeldSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;
  [[nodiscard]] const sigset_t& set() const { return set_; }
  [[nodiscard]] const sigset_t& before() const { return before_; }

 private:
  sigset_t set_, before_{};
};

/// How a program is started: in a folder of its own, so that nothing beside a model is read as its settings, with files
/// in place of the standard streams, and with the signals as they were before this process changed them.
class Start {
 public:
  Start(const Scratch& scratch, const sigset_t& mask) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 0, scratch.file("in").c_str(), O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, 1, scratch.file("out").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addopen(&actions_, 2, scratch.file("messages").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addchdir_np(&actions_, scratch.file("").c_str());
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setsigmask(&attributes_, &mask);
    sigset_t ignored;
    sigemptyset(&ignored);
    for (const int signal : {SIGPIPE, SIGXFSZ}) sigaddset(&ignored, signal);
    posix_spawnattr_setsigdefault(&attributes_, &ignored);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~Start() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  Start(const Start&) = delete;
  Start& operator=(const Start&) = delete;
  [[nodiscard]] const posix_spawn_file_actions_t* actions() const { return &actions_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// What became of a child: its status, or the signal that ended the wait (SIGALRM: it took too long).
struct Ending {
  int status = 0;
  int signal = 0;
};

/// Waits for a child. A signal that is to end this process ends the child first; so does the time limit.
Ending wait_for(pid_t child, const HeldSignals& held) {
  Ending ending;
  timespec left{kLongestProgram.count(), 0};
  const auto begin = std::chrono::steady_clock::now();
  while (::waitpid(child, &ending.status, WNOHANG) == 0) {
    const int signal = ::sigtimedwait(&held.set(), nullptr, &left);
    const auto passed = std::chrono::steady_clock::now() - begin;
    left.tv_sec = std::max<std::time_t>(0, std::chrono::ceil<std::chrono::seconds>(kLongestProgram - passed).count());
    if (signal == SIGCHLD || (signal < 0 && left.tv_sec > 0)) continue;
    ending.signal = signal < 0 ? SIGALRM : signal;
    ::kill(child, SIGKILL);
    while (::waitpid(child, &ending.status, 0) < 0 && errno == EINTR) {
    }
    return ending;
  }
  return ending;
}

Ending run_in(const Scratch& scratch, const ExternalProgram& program, const std::string& path,
              const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program.name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const HeldSignals held;
  const Start start(scratch, held.before());
  pid_t child = 0;
  const int fault = ::posix_spawn(&child, path.c_str(), start.actions(), start.attributes(), argv.data(), environ);
  if (fault != 0) throw UsageError(std::string(program.name) + " cannot be started: " + std::strerror(fault));
  return wait_for(child, held);
}

}  // namespace

std::string run_program(const ExternalProgram& program, const std::vector<std::string>& arguments,
                        const std::string& input) {
  const std::string path = path_of(program);
  if (path.empty()) throw UsageError(missing(program));
  Ending ending;
  std::string said;
  {
    const Scratch scratch;
    {
      std::ofstream file(scratch.file("in"), std::ios::binary);
      file << input;
      if (!file.flush())
        throw UsageError("cannot write " + short_path(scratch.file("in")) + ": " + std::strerror(errno));
    }
    ending = run_in(scratch, program, path, arguments);
    if (ending.signal == 0 && WIFEXITED(ending.status) && WEXITSTATUS(ending.status) == 0)
      return read_whole(scratch.file("out"));
    said = read_whole(scratch.file("messages"));
  }
  const std::string who = std::string(program.name) + ", which " + program.purpose + ", ";
  if (ending.signal == SIGALRM)
    throw UsageError(who + "was ended after " + std::to_string(kLongestProgram.count()) + " s without a result");
  if (ending.signal != 0) {
    ::raise(ending.signal);  // as if it had come now, with nothing left behind
    throw Interrupted("interrupted");
  }
  const std::string how = WIFEXITED(ending.status) ? "exit code " + std::to_string(WEXITSTATUS(ending.status))
                                                   : "signal " + std::to_string(WTERMSIG(ending.status));
  constexpr std::size_t kMostSaid = 2000;
  throw UsageError(who + "failed (" + how + "):\n" + visible_text(said.substr(0, kMostSaid)));
}

void require_program(const ExternalProgram& program, const std::string& advice) {
  if (path_of(program).empty()) throw UsageError(missing(program) + (advice.empty() ? "" : ";\n" + advice));
}

}  // namespace bgsim::cli
