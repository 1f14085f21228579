#include "elsewhere/hand_over.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "bgsim/text.hpp"

namespace bgsim::cli {

namespace {

[[noreturn]] void go_on_as(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(pointers.front(), pointers.data());
  throw UsageError(short_path(words.front()) + " cannot be started: " + std::strerror(errno));
}

/// The script that has made the build in @p folder (scripts/bgsim leaves its place there); empty if none has.
std::string script_of(const std::filesystem::path& folder) {
  std::ifstream note(folder / "built");
  std::string script;
  return std::getline(note, script) && !script.empty() ? (folder / script).lexically_normal().string() : "";
}

}  // namespace

void hand_over(const char* program, const char* command, const Arguments& arguments, const char* without) {
  std::error_code fault;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", fault);
  if (fault)
    throw UsageError("bgsim cannot tell where it lies, and " + std::string(program) +
                     " is looked for beside it: " + fault.message());
  std::vector<std::string> words{(own.parent_path() / program).string()};
  if (::access(words.front().c_str(), X_OK) != 0) {
    const std::string script = script_of(own.parent_path());
    if (script.empty() || ::access(script.c_str(), X_OK) != 0) throw UsageError(without);
    words = {script, "--with", program};
  }
  words.emplace_back(command);
  words.insert(words.end(), arguments.begin(), arguments.end());
  go_on_as(std::move(words));
}

}  // namespace bgsim::cli
