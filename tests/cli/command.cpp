#include "command.hpp"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <regex>

namespace fs = std::filesystem;

std::vector<std::string> command_names(const std::string& help) {
  const std::regex line(R"(\n  ([a-z]+) +[a-z])");
  const std::string commands = help.substr(help.find("Commands"), help.find("\nExamples") - help.find("Commands"));
  std::vector<std::string> names;
  for (std::sregex_iterator each(commands.begin(), commands.end(), line), end; each != end; ++each)
    names.push_back((*each)[1]);
  return names;
}

std::string bgsim_path() {
  const char* other = std::getenv("BGSIM_COMMAND");
  return other == nullptr ? BGSIM_COMMAND : other;
}

Workplace::Workplace() { fs::copy(BGSIM_SOURCE_DIR "/tests/cli/models", files_.path(), fs::copy_options::recursive); }

Outcome Workplace::run(const std::string& line) const {
  const int status = std::system(("cd '" + folder() + "' && { " + line).c_str());
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = read(".out");
  outcome.err = read(".err");
  return outcome;
}

Outcome Workplace::bgsim(const std::string& arguments, const std::string& after) const {
  return run("'" + bgsim_path() + "' " + arguments + " 2>.err </dev/null " + after + "; } >.out");
}

Outcome Workplace::shell(const std::string& line) const { return run(line + "; } >.out 2>.err </dev/null"); }

std::set<std::string> Workplace::names() const {
  std::set<std::string> names = files_.names();
  for (const char* own : {".out", ".err", ".calls"}) names.erase(own);
  return names;
}
