#include "programs.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "command.hpp"

extern char** environ;

namespace bgsim::cli {

namespace {

/// A folder of our own, removed again with what is in it.
class Scratch {
 public:
  Scratch() {
    const char* base = std::getenv("TMPDIR");
    path_ = std::string(base != nullptr && *base != '\0' ? base : "/tmp") + "/bgsim-XXXXXX";
    if (::mkdtemp(path_.data()) == nullptr) throw UsageError("cannot make a temporary folder " + path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

std::string read_whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string missing(const ExternalProgram& program) {
  return std::string(program.name) + ", which " + program.purpose + ", is not installed (Debian: apt-get install " +
         program.package + ")";
}

/// Files in place of the three standard streams of a program to be started.
class Streams {
 public:
  explicit Streams(const Scratch& scratch) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 0, scratch.file("in").c_str(), O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, 1, scratch.file("out").c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addopen(&actions_, 2, scratch.file("messages").c_str(), O_WRONLY | O_CREAT, 0600);
  }
  ~Streams() { posix_spawn_file_actions_destroy(&actions_); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

}  // namespace

std::string run_program(const ExternalProgram& program, const std::vector<std::string>& arguments,
                        const std::string& input) {
  const Scratch scratch;
  {
    std::ofstream file(scratch.file("in"), std::ios::binary);
    file << input;
    if (!file.flush()) throw UsageError("cannot write " + scratch.file("in") + ": " + std::strerror(errno));
  }
  std::vector<std::string> words{program.name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const Streams streams(scratch);
  pid_t child = 0;
  const int fault = ::posix_spawnp(&child, program.name, streams.get(), nullptr, argv.data(), environ);
  if (fault == ENOENT) throw UsageError(missing(program));
  if (fault != 0) throw UsageError(std::string(program.name) + " cannot be started: " + std::strerror(fault));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return read_whole(scratch.file("out"));
  const std::string how = WIFEXITED(status) ? "exit code " + std::to_string(WEXITSTATUS(status))
                                            : "signal " + std::to_string(WTERMSIG(status));
  throw UsageError(std::string(program.name) + ", which " + program.purpose + ", failed (" + how + "):\n" +
                   read_whole(scratch.file("messages")));
}

void require_program(const ExternalProgram& program, const std::string& advice) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access(((folder.empty() ? "." : folder) + "/" + program.name).c_str(), X_OK) == 0) return;
  throw UsageError(missing(program) + (advice.empty() ? "" : ";\n" + advice));
}

}  // namespace bgsim::cli
