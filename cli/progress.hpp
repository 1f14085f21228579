/// How far a run is, on a terminal; and Ctrl-C, or a terminal that is closed, which end it in good order.
#pragma once

#include <chrono>
#include <string>

#include "bgsim/simulate.hpp"
#include "interruption.hpp"

namespace bgsim::cli {

/// While it lives, an interruption ends the run instead of the process, the second one the process after all; and
/// runs longer than two seconds show on standard error, if that is a terminal, how far they are.
class RunWatch {
 public:
  /// @param what  is shown before the number: the time of a run, or how many runs are done.
  RunWatch(double start, double stop, bool quiet, const char* what = "t = ");
  ~RunWatch();
  RunWatch(const RunWatch&) = delete;
  RunWatch& operator=(const RunWatch&) = delete;

  /// To be given to simulate().
  Progress progress();
  /// Takes the line off the screen, for something else to be printed.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  void show(double time);

  const char* what_;
  double start_, stop_;
  bool visible_;        ///< standard error is a terminal
  bool shown_ = false;  ///< a line is on the screen
  Clock::time_point begin_, last_;
  InterruptionsNoted noted_;
};

/// The same for a search over many runs: what is being run is shown on a terminal, Ctrl-C ends the search.
class SettingWatch {
 public:
  explicit SettingWatch(bool quiet);
  ~SettingWatch();
  SettingWatch(const SettingWatch&) = delete;
  SettingWatch& operator=(const SettingWatch&) = delete;

  void show(const std::string& what);
  /// Takes the line off the screen.
  void clear();

 private:
  bool visible_, shown_ = false;
  InterruptionsNoted noted_;
};

}  // namespace bgsim::cli
