#include "bgsim/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace bgsim {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargest = std::size_t{1} << 32U;
constexpr std::size_t kMostOfUnknown = std::size_t{1} << 30U;

std::string reason(int error) { return error == ENOENT ? "there is no such file" : std::strerror(error); }

/// Terminals and /dev/null, by the numbers that Linux gives them: opening a device may already do something.
bool is_harmless_device(const struct stat& file) {
  const auto kind = major(file.st_rdev);
  constexpr unsigned kMemory = 1, kNull = 3, kTerminal = 4, kOwnTerminal = 5, kFirstPseudo = 136, kLastPseudo = 143;
  return (kind == kMemory && minor(file.st_rdev) == kNull) || kind == kTerminal || kind == kOwnTerminal ||
         (kind >= kFirstPseudo && kind <= kLastPseudo);
}

/// Why a file of this kind is not read; "" if it is.
std::string refusal(const struct stat& file, NamedBy by) {
  if (S_ISREG(file.st_mode))
    return file.st_size >= static_cast<off_t>(kLargest) ? "it has 4 GiB or more" : std::string();
  if (S_ISDIR(file.st_mode)) return "it is a folder";
  const bool users = by == NamedBy::user;
  if (S_ISFIFO(file.st_mode)) return users ? "" : "it is a pipe, not a regular file";
  if (S_ISCHR(file.st_mode) && users && is_harmless_device(file)) return {};
  return S_ISSOCK(file.st_mode) ? "it is a socket, not a regular file" : "it is a device, not a regular file";
}

/// The first character of @p text that is not blank, after a byte order mark; '\0' if there is none yet.
char first_character(const std::string& text) {
  const std::size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  const std::size_t at = text.find_first_not_of(" \t\r\n", begin);
  return at == std::string::npos ? '\0' : text[at];
}

InputText read_all(int file, std::size_t most, char first) {
  InputText input;
  std::array<char, 1 << 16> block{};
  while (input.text.size() <= most) {
    const ssize_t got = ::read(file, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return {{}, reason(errno)};
    if (got == 0) return input;
    input.text.append(block.data(), static_cast<std::size_t>(got));
    if (first == '\0') continue;
    const char found = first_character(input.text);
    if (found != '\0' && found != first) return input;
  }
  return {{}, most == kLargest ? "it has 4 GiB or more" : "more than 1 GiB comes out of it"};
}

}  // namespace

InputText read_input(const std::string& path, NamedBy by, char first) {
  if (path.find('\0') != std::string::npos) return {{}, "its name holds a NUL character"};
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) return {{}, reason(errno)};
  if (std::string why = refusal(file, by); !why.empty()) return {{}, std::move(why)};
  // A file that becomes a pipe at this moment must not make the opening wait.
  const int waits = S_ISREG(file.st_mode) ? O_NONBLOCK : 0;
  int opened = -1;
  do opened = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | waits);
  while (opened < 0 && errno == EINTR);
  if (opened < 0) return {{}, reason(errno)};
  InputText input;
  if (::fstat(opened, &file) != 0) {
    input.fault = reason(errno);
  } else if (input.fault = refusal(file, by); input.fault.empty()) {
    const bool stated = S_ISREG(file.st_mode) && file.st_size > 0;
    input = read_all(opened, stated ? kLargest : kMostOfUnknown, S_ISREG(file.st_mode) ? '\0' : first);
  }
  ::close(opened);
  return input;
}

std::string folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code ignored;
  const std::string real = fs::weakly_canonical(folder, ignored).string() + "/";
  return real.starts_with("/dev/") || real.starts_with("/proc/") ? std::string() : folder.string();
}

bool is_below(const std::string& path, const std::vector<std::string>& roots) {
  std::error_code fault;
  const fs::path real = fs::weakly_canonical(fs::absolute(path, fault), fault);
  if (fault) return true;
  return std::any_of(roots.begin(), roots.end(), [&](const std::string& root) {
    std::error_code ignored;
    fs::path folder = fs::weakly_canonical(fs::absolute(root.empty() ? "." : root, ignored), ignored);
    if (!folder.has_filename()) folder = folder.parent_path();  // "a/." and "a/": no empty last part
    return std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end();
  });
}

ReadOptions with_folder_of(const std::string& path, const ReadOptions& options) {
  ReadOptions result = options;
  result.roots.insert(result.roots.begin(), folder_of(path));
  result.roots.insert(result.roots.end(), options.path.begin(), options.path.end());
  return result;
}

}  // namespace bgsim
