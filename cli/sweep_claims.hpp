/// Which process makes which runs of a sweep that several processes share.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace bgsim::cli {

/// A file in the sweep's folder with a byte for each chunk of runs: 1 when its runs are in a log. A process that makes
/// a chunk holds a lock on its byte, which the system drops when the process ends in any way; then another may take it.
class SweepClaims {
 public:
  /// @param done  by run: in a log already
  /// @throws UsageError with the system's reason
  SweepClaims(const std::string& folder, std::vector<bool> done);
  ~SweepClaims();
  SweepClaims(const SweepClaims&) = delete;
  SweepClaims& operator=(const SweepClaims&) = delete;

  /// A run that no process makes or has made; none if all such are taken for now.
  std::optional<std::uint64_t> next();
  /// The run is in a log.
  void made(std::uint64_t run);
  /// Whether all runs of all processes are in logs.
  [[nodiscard]] bool complete() const;
  /// True for the first process that asks: it writes the results.
  /// @param again  even if another has written them
  bool writes_results(bool again);
  void results_written();

 private:
  struct Chunk {
    std::uint64_t left = 0;  ///< runs that are not in a log
  };
  bool lock(std::uint64_t byte);
  void unlock(std::uint64_t byte) const;
  [[nodiscard]] bool is_done(std::uint64_t chunk) const;
  void finish(std::uint64_t chunk);
  bool take_chunk();

  std::string path_;
  int file_ = -1;
  std::vector<bool> done_;
  std::uint64_t size_ = 1, chunks_ = 0, at_ = 0;
  std::vector<std::uint64_t> ready_;  ///< runs of the chunk that was taken last, the first one last
  std::map<std::uint64_t, Chunk> mine_;
};

}  // namespace bgsim::cli
