#include "files.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "command.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void cannot_write(const std::string& path, const std::string& reason) {
  throw UsageError("cannot write " + (path == "-" ? std::string("to standard output") : '"' + path + '"') + ": " +
                   reason);
}

/// The system's reason for the last failed call, or that there is none to be had.
std::string reason() { return errno != 0 ? std::strerror(errno) : "the reason is not known"; }

}  // namespace

void check_writable(const std::string& path, const std::string& input) {
  if (path == "-") return;
  std::error_code ignored;
  if (fs::equivalent(path, input, ignored)) cannot_write(path, "it is the model itself");
  if (fs::is_directory(path, ignored)) cannot_write(path, "it is a folder");
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  const fs::path asked = fs::exists(path, ignored) ? fs::path(path) : folder;
  if (access(asked.c_str(), W_OK) != 0) cannot_write(path, reason());
}

void write_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  OutputFile file(path);
  write(file.stream());
  file.commit();
}

std::string file_name(const std::string& name) {
  std::string text = name;
  for (char& c : text) {
    if (c == '/' || static_cast<unsigned char>(c) < ' ') c = '_';
  }
  return text;
}

}  // namespace bgsim::cli
