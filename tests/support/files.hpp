/// Whole files as text, folders for a test alone, and what other programs print.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace bgsim::test {

/// The file's bytes; empty if there is no such file.
std::string file_text(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const std::string& text);

/// Whether goldens are to be written instead of compared: BGSIM_UPDATE_GOLDEN is in the environment.
bool update_goldens();

/// A folder of its own, since tests run side by side; gone at the end of the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] bool has(const std::string& file) const { return std::filesystem::exists(path_ / file); }
  /// @throws std::runtime_error if there is no such file.
  [[nodiscard]] std::string read(const std::string& file) const;
  /// Makes the file, and the folders that it is in.
  void write(const std::string& file, const std::string& text) const;
  /// The names in the folder.
  [[nodiscard]] std::set<std::string> names() const;

 private:
  std::filesystem::path path_;
};

/// What a line of the shell prints to standard output.
std::string output_of(const std::string& line);

}  // namespace bgsim::test
