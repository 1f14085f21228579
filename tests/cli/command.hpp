/// Runs the command as a user would, in a folder of its own.
#pragma once

#include <string>

struct Outcome {
  int code = 0;  ///< exit code, or 128 + signal
  std::string out, err;
};

/// A temporary folder with copies of tests/cli/models; removed at the end.
class Workplace {
 public:
  Workplace();
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  /// Runs `bgsim ARGUMENTS` through the shell in the folder, without standard input. @p after may hold a pipe or a
  /// redirection.
  [[nodiscard]] Outcome bgsim(const std::string& arguments, const std::string& after = "") const;
  [[nodiscard]] std::string read(const std::string& file) const;
  void write(const std::string& file, const std::string& text) const;
  [[nodiscard]] bool has(const std::string& file) const;
  [[nodiscard]] const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};
