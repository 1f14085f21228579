#include "files.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "bgsim/visible_text.hpp"
#include "command.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void cannot_write(const std::string& path, const std::string& reason) {
  throw UsageError("cannot write " + (path == "-" ? std::string("to standard output") : '"' + short_path(path) + '"') +
                   ": " + reason);
}

/// The system's reason for the last failed call, or that there is none to be had.
std::string reason() { return errno != 0 ? std::strerror(errno) : "the reason is not known"; }

/// "_0123456789abcdef", by which two long names that begin alike are told apart (FNV-1a).
std::string checksum(const std::string& name) {
  std::uint64_t sum = 14695981039346656037U;
  for (const char c : name) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211U;
  std::array<char, 20> digits{};
  std::snprintf(digits.data(), digits.size(), "_%016llx", static_cast<unsigned long long>(sum));
  return digits.data();
}

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
  std::string text;
  for_each_character(name, [&text](std::string_view bytes, long) {
    const bool plain = bytes != "/" && visible_line(bytes) == bytes;
    text += plain ? bytes : std::string_view("_");
  });
  // A dot would hide the file, a hyphen make it an option of what it is given to.
  if (text.starts_with('.') || text.starts_with('-')) text.front() = '_';
  constexpr std::size_t kLongest = 200;  // of the 255 bytes that a file system takes; endings are to come
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest - checksum(name).size();
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + checksum(name);
}

}  // namespace bgsim::cli
