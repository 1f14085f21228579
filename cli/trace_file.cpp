#include "trace_file.hpp"

#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <system_error>

#include "bgsim/trace_csv.hpp"
#include "command.hpp"

namespace bgsim::cli {

namespace {

constexpr std::chrono::milliseconds kBetween{250}, kMoment{20};
constexpr std::size_t kEnough = std::size_t{1} << 18U;  // bytes that are handed over at once

/// Whether standard output is a pipe that nobody reads any more. Seen also while there is nothing to write.
bool reader_is_gone() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return ::poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
}

/// Keeps signals with the thread that runs the model, whose calls they interrupt.
class SignalsElsewhere {
 public:
  SignalsElsewhere() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsElsewhere() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsElsewhere(const SignalsElsewhere&) = delete;
  SignalsElsewhere& operator=(const SignalsElsewhere&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

TraceFile::TraceFile(const std::string& path) : path_(path), file_(path) {}

TraceFile::~TraceFile() {
  stop_thread();
  if (!kept_) file_.keep(false);
}

void TraceFile::begin(const std::vector<std::string>& columns) {
  append_csv_header(pending_, columns);
  start();
}

void TraceFile::begin_events() {
  append_event_header(pending_);
  start();
}

void TraceFile::start() {
  // A second interruption ends the process at once; what was computed is worth having then as well.
  file_.keep();
  begun_ = std::chrono::steady_clock::now();
}

void TraceFile::look() {
  if (!thread_.joinable() && !alone_ && std::chrono::steady_clock::now() - begun_ > kMoment) start_thread();
}

void TraceFile::start_thread() {
  const SignalsElsewhere for_the_thread;
  try {
    thread_ = std::thread([this] { hand_over_now_and_then(); });
  } catch (const std::system_error&) {
    alone_ = true;  // no more threads are to be had: each row is then handed over at once
  }
}

void TraceFile::take(double time, std::span<const double> values) {
  const std::lock_guard lock(mutex_);
  rethrow_failure();
  append_csv_record(pending_, time, values);
  take_pending();
}

void TraceFile::take(const RunEvent& event) {
  const std::lock_guard lock(mutex_);
  rethrow_failure();
  append_event_record(pending_, event);
  take_pending();
}

void TraceFile::take_pending() {
  if (!alone_ && pending_.size() < kEnough) return;
  hand_over();
  rethrow_failure();
}

void TraceFile::hand_over_now_and_then() {
  std::unique_lock lock(mutex_);
  while (!end_ && !failure_) {
    ending_.wait_for(lock, kBetween);
    hand_over();
  }
}

/// Whole rows, in one call of the system if it takes them. A failure is kept for the thread that runs the model.
void TraceFile::hand_over() {
  if (failure_) return;
  try {
    file_.stream().write(pending_.data(), static_cast<std::streamsize>(pending_.size()));
    pending_.clear();
    file_.flush();
    if (path_ == "-" && reader_is_gone()) throw UsageError("cannot write to standard output: Broken pipe");
  } catch (const UsageError& error) {
    kept_ = file_.written() > 0;
    const std::string partial = kept_ ? file_.partial() : "";
    failure_ = std::make_exception_ptr(
        partial.empty() ? error : UsageError(error.what() + ("; what was written before is in \"" + partial + '"')));
    failed_ = true;
  }
}

void TraceFile::rethrow_failure() {
  if (failure_) std::rethrow_exception(failure_);
}

void TraceFile::stop_thread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  ending_.notify_one();
  thread_.join();
}

void TraceFile::finish() {
  stop_thread();
  hand_over();
  rethrow_failure();
  try {
    file_.commit();
  } catch (const UsageError& error) {
    const std::string partial = keep_partial();
    if (partial.empty()) throw;
    throw UsageError(error.what() + ("; the trace is in \"" + partial + '"'));
  }
}

std::string TraceFile::keep_partial() {
  stop_thread();
  hand_over();
  kept_ = true;
  return file_.partial();
}

}  // namespace bgsim::cli
