/// Files that other parts of the command leave for a moment.
#pragma once

#include <string>

namespace bgsim::cli {

/// A folder of our own in TMPDIR, removed again with what is in it.
class Scratch {
 public:
  /// @throws UsageError if there is no place for it.
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  /// The path of a file in it.
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// A file's bytes; empty if it cannot be read.
std::string read_whole(const std::string& path);

}  // namespace bgsim::cli
