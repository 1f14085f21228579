// Loaded before the C library (LD_PRELOAD): one call of the system fails, chosen by the environment.
//
//   BGSIM_FAULT      KIND:NUMBER:ERROR  the NUMBER-th call (from 1) of KIND fails with the error's name; 0: none
//                    KIND   open, write, fsync, close, rename, chmod, any
//                    ERROR  ENOSPC, EIO, EDQUOT, EROFS: this call and, of writes, all that follow; EINTR: this call;
//                           SHORT: this write takes a third
//   BGSIM_FAULT_LOG  a file that gets a line for every call that counts, "failed" before those that fail
//
// Standard error does not count, nor does any program but bgsim and bgsim-studies.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

struct Plan {
  char kind[16] = "";
  long number = 0;
  int error = 0;
  bool brief = false, cut = false, active = false;
  long count = 0;
  bool failed = false;
  int log = -1;
};

int error_named(const char* name) {
  if (std::strcmp(name, "ENOSPC") == 0) return ENOSPC;
  if (std::strcmp(name, "EIO") == 0) return EIO;
  if (std::strcmp(name, "EDQUOT") == 0) return EDQUOT;
  if (std::strcmp(name, "EROFS") == 0) return EROFS;
  return EINTR;
}

Plan& plan() {
  static Plan made = [] {
    Plan p;
    const char* text = std::getenv("BGSIM_FAULT");
    char error[16] = "";
    const bool bgsim = std::strcmp(program_invocation_short_name, "bgsim") == 0 ||
                       std::strcmp(program_invocation_short_name, "bgsim-studies") == 0;
    p.active = text != nullptr && bgsim && std::sscanf(text, "%15[a-z]:%ld:%15[A-Z]", p.kind, &p.number, error) == 3;
    p.error = error_named(error);
    p.brief = p.error == EINTR;
    p.cut = std::strcmp(error, "SHORT") == 0;
    const char* log = std::getenv("BGSIM_FAULT_LOG");
    if (p.active && log != nullptr)
      p.log = static_cast<int>(syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    return p;
  }();
  return made;
}

void note(const char* kind, bool failed) {
  char line[64];
  const int length = std::snprintf(line, sizeof line, "%s%s\n", failed ? "failed " : "", kind);
  if (plan().log >= 0) (void)!syscall(SYS_write, plan().log, line, static_cast<size_t>(length));
}

/// Whether this call fails; then errno is set.
bool fails(const char* kind) {
  Plan& p = plan();
  if (!p.active) return false;
  const bool meant = std::strcmp(p.kind, "any") == 0 || std::strcmp(p.kind, kind) == 0;
  const bool now = meant && ++p.count == p.number;
  // A full disk stays full: the writes after the first one that failed fail as well.
  const bool still = p.failed && !p.brief && !p.cut && std::strcmp(kind, "write") == 0;
  const bool applies = (!p.cut || std::strcmp(kind, "write") == 0) && (!p.brief || std::strcmp(kind, "chmod") != 0);
  const bool failed = (now || still) && applies;
  note(kind, failed);
  if (!failed) return false;
  p.failed = true;
  errno = p.error;
  return true;
}

int opened(int folder, const char* path, int flags, mode_t mode) {
  const bool writes = (flags & (O_WRONLY | O_RDWR)) != 0;
  if (writes && fails("open")) return -1;
  return static_cast<int>(syscall(SYS_openat, folder, path, flags, mode));
}

mode_t mode_after(int flags, va_list rest) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(rest, int)) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = mode_after(flags, rest);
  va_end(rest);
  return opened(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = mode_after(flags, rest);
  va_end(rest);
  return opened(folder, path, flags, mode);
}

ssize_t write(int file, const void* bytes, size_t count) {
  if (file != STDERR_FILENO && fails("write")) {
    if (!plan().cut || count < 3) return plan().cut ? syscall(SYS_write, file, bytes, count) : -1;
    return syscall(SYS_write, file, bytes, count / 3);
  }
  return syscall(SYS_write, file, bytes, count);
}

int fsync(int file) { return fails("fsync") ? -1 : static_cast<int>(syscall(SYS_fsync, file)); }

int close(int file) {
  const int closed = static_cast<int>(syscall(SYS_close, file));  // Linux closes even where it reports an error
  return fails("close") ? -1 : closed;
}

int renameat(int from, const char* old_name, int to, const char* new_name) noexcept {
  return fails("rename") ? -1 : static_cast<int>(syscall(SYS_renameat2, from, old_name, to, new_name, 0));
}

int fchmod(int file, mode_t mode) noexcept {
  return fails("chmod") ? -1 : static_cast<int>(syscall(SYS_fchmod, file, mode));
}

}  // extern "C"
