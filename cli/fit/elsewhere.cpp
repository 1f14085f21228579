// bgsim fit within bgsim: the command is in bgsim-fit, beside it, so that bgsim itself needs neither Ceres nor NLopt,
// and loads neither at each start.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "bgsim/text.hpp"
#include "command.hpp"

namespace bgsim::cli {

Exit fit_command(const Arguments& arguments) {
  std::error_code fault;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", fault);
  if (fault)
    throw UsageError("bgsim cannot tell where it lies, and bgsim-fit is looked for beside it: " + fault.message());
  const std::string program = (own.parent_path() / "bgsim-fit").string();
  if (::access(program.c_str(), X_OK) != 0)
    throw UsageError(
        "this bgsim was built without Ceres and NLopt, which bgsim fit needs\nscripts/bgsim fit installs them and "
        "builds it; "
        "by hand: apt-get install libceres-dev libnlopt-dev, then configure and build again");
  std::vector<std::string> words{program, "fit"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  throw UsageError(short_path(program) + " cannot be started: " + std::strerror(errno));
}

}  // namespace bgsim::cli
