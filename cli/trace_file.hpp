/// A trace on its way to its file: every row is in the hands of the system within a second.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "bgsim/simulate.hpp"
#include "output_file.hpp"

namespace bgsim::cli {

/// Rows are collected and handed over by a thread of its own four times a second, whatever the run is busy with: what
/// ends the process without a word (SIGKILL, a crash) leaves all rows but those of the last moment in FILE.partial.
/// A run that is over at once needs no thread, whose start takes as long as a thousand rows: it begins when the run
/// asks, after its first moment, whether to go on. There is no fsync meanwhile: what the system has outlives the
/// process, and a failing system is no matter of a run.
class TraceFile {
 public:
  /// @param path  "-": standard output.
  /// @throws UsageError as OutputFile does.
  explicit TraceFile(const std::string& path);
  /// Removes the partial file, unless finish() or keep_partial() was called.
  ~TraceFile();
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  /// Writes the header, and begins to hand over. Call once, before the first row.
  void begin(const std::vector<std::string>& columns);
  /// @throws UsageError with the system's reason if an earlier row could not be written; what was stays.
  void take(double time, std::span<const double> values);
  /// The same of a table of events: its header, and each event.
  void begin_events();
  void take(const RunEvent& event);
  /// To be called now and then while the run goes on.
  void look();
  /// Whether something could not be written, or nobody reads any more. finish() tells what.
  [[nodiscard]] bool failed() const { return failed_; }
  /// All rows to the disk, under the file's own name.
  /// @throws UsageError with the system's reason; the partial file then stays.
  void finish();
  /// Leaves the partial file where it is, with all rows so far.
  /// @return its name; "" if there is none.
  std::string keep_partial();

 private:
  void start();
  void start_thread();
  void take_pending();
  void hand_over_now_and_then();
  void hand_over();
  void stop_thread();
  void rethrow_failure();

  std::string path_;
  OutputFile file_;
  std::mutex mutex_;  ///< over what follows, and file_ while the thread runs
  std::condition_variable ending_;
  std::string pending_;
  std::exception_ptr failure_;
  bool end_ = false;
  std::chrono::steady_clock::time_point begun_;
  bool alone_ = false;  ///< there is no thread to be had
  bool kept_ = false;   ///< the partial file outlives this
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

}  // namespace bgsim::cli
