/// Wall time added up over the lives of stopwatches.
#pragma once

#include <chrono>

namespace bgsim {

class Stopwatch {
 public:
  /// @param total  gets the seconds that the stopwatch lived.
  explicit Stopwatch(double& total) : total_(total) {}
  ~Stopwatch() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace bgsim
