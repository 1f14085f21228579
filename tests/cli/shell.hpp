/// Any line of the shell in a test's folder.
#pragma once

#include <sys/wait.h>

#include <cstdlib>

#include "command.hpp"

/// Runs @p line in the folder, without standard input.
inline Outcome shell(const Workplace& here, const std::string& text) {
  const std::string line = "cd '" + here.folder() + "' && { " + text + "; } >.out 2>.err </dev/null";
  const int status = std::system(line.c_str());
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = here.read(".out");
  outcome.err = here.read(".err");
  return outcome;
}
