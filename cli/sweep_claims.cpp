#include "sweep_claims.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "bgsim/text.hpp"
#include "command.hpp"

namespace bgsim::cli {

namespace {

/// Locks of an open file, not of a process, so that closing another descriptor of it drops none.
bool set_lock(int file, short kind, std::uint64_t byte) {
  struct flock range {};
  range.l_type = kind;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(byte);
  range.l_len = 1;
  return ::fcntl(file, F_OFD_SETLK, &range) == 0;
}

}  // namespace

SweepClaims::SweepClaims(const std::string& folder, std::vector<bool> done)
    : path_(folder + "/claims"),
      file_(::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)),
      done_(std::move(done)) {
  if (file_ < 0) throw UsageError("cannot write \"" + short_path(path_) + "\": " + std::strerror(errno));
  // Few runs are claimed one by one, as they may be long; of many, some thousand chunks.
  constexpr std::uint64_t kChunks = 4000, kMostRuns = 1000;
  size_ = std::clamp<std::uint64_t>(done_.size() / kChunks, 1, kMostRuns);
  chunks_ = (done_.size() + size_ - 1) / size_;
  // Processes begin at different places, so that they seldom ask for the same chunk.
  at_ = chunks_ == 0 ? 0 : static_cast<std::uint64_t>(::getpid()) * 2654435761U % chunks_;
}

SweepClaims::~SweepClaims() {
  if (file_ >= 0) ::close(file_);
}

bool SweepClaims::lock(std::uint64_t byte) {
  if (set_lock(file_, F_WRLCK, byte)) return true;
  if (errno == EAGAIN || errno == EACCES) return false;
  throw UsageError("cannot share the sweep in \"" + short_path(path_) + "\": " + std::strerror(errno) +
                   "\n  --share needs a file system with locks; --shard I/N needs none");
}

void SweepClaims::unlock(std::uint64_t byte) const { set_lock(file_, F_UNLCK, byte); }

bool SweepClaims::is_done(std::uint64_t chunk) const {
  char byte = 0;
  return ::pread(file_, &byte, 1, static_cast<off_t>(chunk)) == 1 && byte == 1;
}

void SweepClaims::finish(std::uint64_t chunk) {
  const char byte = 1;
  if (::pwrite(file_, &byte, 1, static_cast<off_t>(chunk)) != 1)
    throw UsageError("cannot write \"" + short_path(path_) + "\": " + std::strerror(errno));
  mine_.erase(chunk);
  unlock(chunk);
}

bool SweepClaims::take_chunk() {
  for (std::uint64_t tried = 0; tried < chunks_; ++tried, at_ = (at_ + 1) % chunks_) {
    if (is_done(at_) || mine_.contains(at_) || !lock(at_)) continue;
    // Another process may have finished it between the look and the lock.
    if (is_done(at_)) {
      unlock(at_);
      continue;
    }
    const std::uint64_t chunk = at_;
    ready_.clear();
    for (std::uint64_t run = std::min<std::uint64_t>((chunk + 1) * size_, done_.size()); run-- > chunk * size_;)
      if (!done_[run]) ready_.push_back(run);
    mine_[chunk].left = ready_.size();
    if (!ready_.empty()) return true;
    finish(chunk);
  }
  return false;
}

std::optional<std::uint64_t> SweepClaims::next() {
  if (ready_.empty() && !take_chunk()) return std::nullopt;
  const std::uint64_t run = ready_.back();
  ready_.pop_back();
  return run;
}

void SweepClaims::made(std::uint64_t run) {
  done_[run] = true;
  const std::uint64_t chunk = run / size_;
  if (--mine_.at(chunk).left == 0) finish(chunk);
}

bool SweepClaims::complete() const {
  std::vector<char> bytes(chunks_, 0);
  std::size_t read = 0;
  while (read < bytes.size()) {
    const ssize_t some = ::pread(file_, bytes.data() + read, bytes.size() - read, static_cast<off_t>(read));
    if (some <= 0) return false;
    read += static_cast<std::size_t>(some);
  }
  return std::all_of(bytes.begin(), bytes.end(), [](char byte) { return byte == 1; });
}

bool SweepClaims::writes_results(bool again) { return lock(chunks_) && (again || !is_done(chunks_)); }

void SweepClaims::results_written() { finish(chunks_); }

}  // namespace bgsim::cli
