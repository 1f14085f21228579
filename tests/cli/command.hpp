/// Runs the command as a user would, in a folder of its own.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "support/files.hpp"

struct Outcome {
  int code = 0;  ///< exit code, or 128 + signal
  std::string out, err;
};

/// The names of all commands, as the help lists them.
std::vector<std::string> command_names(const std::string& help);

/// The command: of this build, or what the environment names as BGSIM_COMMAND.
std::string bgsim_path();

/// A temporary folder with copies of tests/cli/models; removed at the end.
class Workplace {
 public:
  Workplace();

  /// Runs `bgsim ARGUMENTS` through the shell in the folder, without standard input. @p after may hold a pipe or a
  /// redirection.
  [[nodiscard]] Outcome bgsim(const std::string& arguments, const std::string& after = "") const;
  /// Runs any line of the shell in the folder, without standard input.
  [[nodiscard]] Outcome shell(const std::string& line) const;

  [[nodiscard]] std::string read(const std::string& file) const { return files_.read(file); }
  void write(const std::string& file, const std::string& text) const { files_.write(file, text); }
  [[nodiscard]] bool has(const std::string& file) const { return files_.has(file); }
  /// What is in the folder, but for what the tests' own programs leave there.
  [[nodiscard]] std::set<std::string> names() const;
  [[nodiscard]] std::string folder() const { return files_.path().string(); }

 private:
  [[nodiscard]] Outcome run(const std::string& line) const;

  bgsim::test::TemporaryFolder files_;
};

/// For ring.json, minutes long: waits until the partial file holds something, then does @p then, and waits for the end.
inline std::string when_rows_are_there(const std::string& then) {
  return "& pid=$!; n=0; until [ -s out.csv.partial ] || [ $n -gt 600 ]; do sleep 0.05; n=$((n+1)); done; " + then +
         "; wait $pid";
}
