#include "output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <utility>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "interruption.hpp"
#include "standard_output.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

/// A link that leads to an open file and not to a name, such as /proc/self/fd/1: following it by its text would name
/// a file that the caller has open, and replacing that would take it from under the caller.
bool leads_to_open_file(const fs::path& link) {
  std::error_code ignored;
  return fs::canonical(link.parent_path(), ignored).string().starts_with("/proc/");
}

/// The file that @p path means, also if it is not there yet: links followed, but for those to open files.
/// @throws std::system_error
fs::path followed(fs::path path) {
  constexpr int kMostLinks = 40;  // as the system's
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code none;
    if (!fs::is_symlink(fs::symlink_status(path, none)) || leads_to_open_file(path)) return path;
    path = path.parent_path() / fs::read_symlink(path);
  }
  throw std::system_error(ELOOP, std::generic_category());
}

/// The number of the process's own descriptor that @p path is (/proc/self/fd/1), or -1.
int own_descriptor(const fs::path& path) {
  std::error_code ignored;
  if (fs::canonical(path.parent_path(), ignored) != "/proc/" + std::to_string(::getpid()) + "/fd") return -1;
  const std::string name = path.filename().string();
  if (name.empty() || name.find_first_not_of("0123456789") != std::string::npos) return -1;
  return std::atoi(name.c_str());
}

/// NAME.partial; a name that the file system could not hold so is cut, with a checksum that makes it unique.
std::string partial_name(const std::string& name, std::size_t most) {
  constexpr std::string_view kEnding = ".partial";
  if (name.size() + kEnding.size() <= most) return name + std::string(kEnding);
  std::uint64_t sum = 14695981039346656037U;  // FNV-1a
  for (const char c : name) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211U;
  std::array<char, 20> digits{};
  std::snprintf(digits.data(), digits.size(), ".%016llx", static_cast<unsigned long long>(sum));
  const std::string tail = digits.data() + std::string(kEnding);
  std::size_t kept = std::min(name.size(), most - std::min(most, tail.size()));
  while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xC0U) == 0x80U) --kept;  // whole characters
  return name.substr(0, kept) + tail;
}

std::size_t longest_name(int folder) {
  const long most = ::fpathconf(folder, _PC_NAME_MAX);
  return most > 0 ? static_cast<std::size_t>(most) : 255;
}

bool is_mount_point(int folder, const std::string& name) {
#ifdef STATX_ATTR_MOUNT_ROOT
  struct statx found {};
  return ::statx(folder, name.c_str(), AT_SYMLINK_NOFOLLOW, STATX_TYPE, &found) == 0 &&
         (found.stx_attributes & found.stx_attributes_mask & STATX_ATTR_MOUNT_ROOT) != 0;
#else
  return false;
#endif
}

/// In a folder such as /tmp only the owner may replace a file.
bool may_rename_onto(int folder, const struct stat& old) {
  struct stat in {};
  if (::geteuid() == 0 || ::fstat(folder, &in) != 0 || (in.st_mode & S_ISVTX) == 0) return true;
  return old.st_uid == ::geteuid() || in.st_uid == ::geteuid();
}

OutputFile* first_open = nullptr;  ///< all that have a partial file

int open_again(const char* path, int flags, mode_t mode = 0) {
  int opened = -1;
  do opened = ::open(path, flags | O_CLOEXEC, mode);
  while (opened < 0 && errno == EINTR);
  return opened;
}

int openat_again(int folder, const std::string& name, int flags, mode_t mode = 0) {
  int opened = -1;
  do opened = ::openat(folder, name.c_str(), flags | O_CLOEXEC, mode);
  while (opened < 0 && errno == EINTR);
  return opened;
}

int lock_again(int file) {
  int locked = -1;
  do locked = ::flock(file, LOCK_EX | LOCK_NB);
  while (locked != 0 && errno == EINTR);
  return locked;
}

int sync_again(int file) {
  int synced = -1;
  do synced = ::fsync(file);
  while (synced != 0 && errno == EINTR);
  return synced;
}

/// A file without a name, for what is copied into place later.
int open_scratch() {
  const char* base = std::getenv("TMPDIR");
  const std::string folder = base != nullptr && *base != '\0' ? base : "/tmp";
  const int unnamed = open_again(folder.c_str(), O_TMPFILE | O_RDWR, 0600);
  if (unnamed >= 0) return unnamed;
  std::string name = folder + "/bgsim-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

}  // namespace

OutputFile::Descriptor::~Descriptor() {
  if (value >= 0) ::close(value);
}
OutputFile::Descriptor& OutputFile::Descriptor::operator=(int opened) {
  if (value >= 0) ::close(value);
  value = opened;
  return *this;
}

void OutputFile::fail(const std::string& reason) const {
  throw UsageError("cannot write " +
                   (path_ == "-" ? std::string("to standard output") : '"' + short_path(path_) + '"') + ": " + reason);
}
void OutputFile::fail(int error) const { fail(error != 0 ? std::strerror(error) : "the reason is not known"); }

OutputFile::OutputFile(const std::string& path) : path_(path), stream_(nullptr) {
  if (path == "-") {
    stream_.rdbuf(StandardOutput::data());
    return;
  }
  try {
    open_target();
    if (!partial_.empty()) take_permissions();
  } catch (const std::system_error& error) {
    fail(error.code().value());
  } catch (...) {
    leave();
    throw;
  }
  buffer_.attach(file_.value);
  stream_.rdbuf(&buffer_);
}

OutputFile::~OutputFile() { leave(); }

void OutputFile::leave() {
  const InterruptionsHeld held;
  drop();
  if (previous_ != nullptr) *previous_ = next_;
  if (next_ != nullptr) next_->previous_ = previous_;
}

/// Nothing here that a signal handler may not do.
void OutputFile::drop() noexcept {
  if (!done_ && !kept_ && !partial_.empty() && is_ours()) ::unlinkat(folder_.value, partial_.c_str(), 0);
  done_ = true;
}

void remove_partial_files() {
  for (OutputFile* file = first_open; file != nullptr; file = file->next_) file->drop();
}

void OutputFile::open_target() {
  // The system follows links itself here, and refuses those that it does not trust.
  exists_ = ::stat(path_.c_str(), &old_) == 0;
  if (!exists_ && errno != ENOENT) fail(errno);
  if (exists_ && S_ISDIR(old_.st_mode)) fail("it is a folder");
  const fs::path file = followed(path_);
  if ((exists_ && !S_ISREG(old_.st_mode)) || leads_to_open_file(file)) return open_direct(file.string());
  name_ = file.filename().string();
  if (name_.empty() || name_ == "." || name_ == "..") fail("it names a folder");
  if (exists_ && ::access(file.c_str(), W_OK) != 0) fail(errno);
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  folder_ = open_again(folder.c_str(), O_PATH | O_DIRECTORY);
  if (folder_.value < 0) fail(errno);
  if (exists_) lock_existing(file.string());
  open_beside(file.string());
}

void OutputFile::open_direct(const std::string& file) {
  std::cout.flush();  // which may be the same file
  const int own = own_descriptor(file);
  file_ = own >= 0 ? ::fcntl(own, F_DUPFD_CLOEXEC, 0) : open_again(file.c_str(), O_WRONLY | O_NOCTTY);
  if (file_.value < 0) fail(errno);
}

/// A file that is itself being written, as another's partial file or in place, is no target.
void OutputFile::lock_existing(const std::string& file) {
  Descriptor existing;
  existing = open_again(file.c_str(), O_RDONLY | O_NONBLOCK);
  if (existing.value >= 0 && lock_again(existing.value) != 0 && errno == EWOULDBLOCK)
    fail("another output is being written to it; wait until it ends, or name another file");
}

void OutputFile::open_beside(const std::string& file) {
  const InterruptionsHeld held;  // until it is known what would be left behind
  if (exists_ && (is_mount_point(folder_.value, name_) || !may_rename_onto(folder_.value, old_)))
    return open_in_place(file);
  partial_ = partial_name(name_, longest_name(folder_.value));
  constexpr int kTries = 100;  // each of which another writer may spoil, once
  for (int i = 0; i < kTries; ++i) {
    if (create_partial()) {
      next_ = first_open;
      previous_ = &first_open;
      if (next_ != nullptr) next_->previous_ = &next_;
      first_open = this;
      return;
    }
    const int error = errno;
    if (exists_ && (error == EACCES || error == EPERM || error == EROFS)) {
      partial_.clear();
      return open_in_place(file);
    }
    if (error != EEXIST) {
      partial_.clear();
      fail(error);
    }
    if (!remove_stale()) break;
  }
  const std::string locked = std::exchange(partial_, "");
  fail("another bgsim is writing it, into " + locked + "; wait until it ends, or name another file");
}

/// Creates and locks the partial file.
/// @return false with errno; EEXIST also where another writer was faster with the lock.
bool OutputFile::create_partial() {
  file_ = openat_again(folder_.value, partial_, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW, exists_ ? 0600 : 0666);
  if (file_.value < 0) return false;
  // A file system without locks (ENOLCK, ENOTSUP) still creates for one only.
  const bool lost = lock_again(file_.value) != 0 && errno == EWOULDBLOCK;
  if (!lost && is_ours()) return true;
  errno = EEXIST;
  return false;
}

/// Removes a partial file that nobody is writing.
/// @return false if somebody is.
bool OutputFile::remove_stale() {
  const auto in_the_way = [&](const std::string& why) {
    const std::string name = std::exchange(partial_, "");
    fail(name + " beside it is in the way: " + why);
  };
  struct stat found {};
  if (::fstatat(folder_.value, partial_.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0) return errno == ENOENT;
  if (!S_ISREG(found.st_mode)) in_the_way("it is not a regular file");
  file_ = openat_again(folder_.value, partial_, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (file_.value < 0) {
    if (errno == ENOENT) return true;
    in_the_way(std::strerror(errno));
  }
  if (lock_again(file_.value) != 0) {
    if (errno == EWOULDBLOCK) return false;
    in_the_way(std::string("whether it is being written cannot be seen (") + std::strerror(errno) +
               "); remove it if it is not");
  }
  if (!is_ours()) return true;  // replaced meanwhile: look again
  if (::unlinkat(folder_.value, partial_.c_str(), 0) != 0 && errno != ENOENT) in_the_way(std::strerror(errno));
  return true;
}

bool OutputFile::is_ours() const {
  struct stat open {
  }, named{};
  return ::fstat(file_.value, &open) == 0 &&
         ::fstatat(folder_.value, partial_.c_str(), &named, AT_SYMLINK_NOFOLLOW) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

/// Owner, group and mode of the file that is replaced. Where the group cannot be kept, its rights go to nobody else.
void OutputFile::take_permissions() {
  if (!exists_) return;
  struct stat made {};
  if (::fstat(file_.value, &made) != 0) fail(errno);
  if (made.st_uid != old_.st_uid) (void)!::fchown(file_.value, old_.st_uid, static_cast<gid_t>(-1));
  mode_t mode = old_.st_mode & 07777U;
  if (made.st_gid != old_.st_gid && ::fchown(file_.value, static_cast<uid_t>(-1), old_.st_gid) != 0)
    mode &= ~static_cast<mode_t>(S_IRWXG | S_ISGID);
  if (::fchmod(file_.value, mode) != 0) fail(errno);
}

void OutputFile::open_in_place(const std::string& file) {
  target_ = open_again(file.c_str(), O_RDWR | O_NONBLOCK);
  if (target_.value < 0) target_ = open_again(file.c_str(), O_WRONLY | O_NONBLOCK);
  if (target_.value < 0) fail(errno);
  if (lock_again(target_.value) != 0 && errno == EWOULDBLOCK)
    fail("another bgsim is writing it; wait until it ends, or name another file");
  file_ = open_scratch();
  if (file_.value < 0) fail(std::string("no temporary file can be made: ") + std::strerror(errno));
}

void OutputFile::flush() {
  if (path_ == "-") return StandardOutput::flush();
  stream_.flush();
  if (buffer_.error() != 0) fail(buffer_.error());
}

void OutputFile::finish() {
  flush();
  if (partial_.empty()) return;
  if (sync_again(file_.value) != 0 && errno != EINVAL && errno != ENOSYS) fail(errno);
  // Some file systems tell only on closing that the disk is full. The file itself stays open, for its lock.
  const int twin = ::fcntl(file_.value, F_DUPFD_CLOEXEC, 0);
  if (twin < 0 || (::close(twin) != 0 && errno != EINTR)) fail(errno);
}

void OutputFile::commit() { commit_all({this}); }

void OutputFile::rename_onto_target() {
  if (target_.value >= 0) copy_in_place();
  if (!partial_.empty()) {
    if (!is_ours()) fail(partial_ + ", into which it was written, has been removed or replaced meanwhile");
    while (::renameat(folder_.value, partial_.c_str(), folder_.value, name_.c_str()) != 0)
      if (errno != EINTR) fail(errno);
  }
  done_ = true;
}

/// From the scratch file into the target, after its space has been reserved: a full disk is found before the old
/// content is touched.
void OutputFile::copy_in_place() {
  const auto size = static_cast<off_t>(buffer_.written());
  int error = 0;
  do error = size > 0 ? ::posix_fallocate(target_.value, 0, size) : 0;
  while (error == EINTR);
  if (error != 0) {
    (void)!::ftruncate(target_.value, old_.st_size);
    fail(error);
  }
  DescriptorBuffer target(target_.value);
  std::array<char, 1 << 16> block{};
  for (off_t at = 0; at < size;) {
    const ssize_t got = ::pread(file_.value, block.data(), block.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) target.abandon(got < 0 ? errno : EIO);
    if (target.sputn(block.data(), got) != got) break;
    at += got;
  }
  if (target.pubsync() == 0 && ::ftruncate(target_.value, size) == 0 && sync_again(target_.value) == 0) return;
  fail(std::string(std::strerror(target.error() != 0 ? target.error() : errno)) +
       "; it was being overwritten in place, because its folder does not allow renaming: its old content is lost");
}

std::string OutputFile::partial() const { return partial_.empty() ? std::string() : partial_path(path_); }

void commit_all(std::initializer_list<OutputFile*> files) {
  for (OutputFile* file : files)
    if (file != nullptr) file->finish();
  const InterruptionsHeld held;
  for (OutputFile* file : files)
    if (file != nullptr) file->rename_onto_target();
}

std::string partial_path(const std::string& path) {
  if (path == "-") return {};
  try {
    const fs::path file = followed(path);
    const long most = ::pathconf(file.has_parent_path() ? file.parent_path().c_str() : ".", _PC_NAME_MAX);
    return (file.parent_path() /
            partial_name(file.filename().string(), most > 0 ? static_cast<std::size_t>(most) : 255))
        .string();
  } catch (const std::system_error&) {
    return {};  // what cannot be followed cannot be written either
  }
}

}  // namespace bgsim::cli
