#include "progress.hpp"

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "standard_output.hpp"

namespace bgsim::cli {

namespace {

using std::chrono::duration;

/// "40 s", "12 min", "3.5 h"
std::string duration_text(double seconds) {
  std::array<char, 32> text{};
  if (seconds < 100.0) {
    std::snprintf(text.data(), text.size(), "%.0f s", seconds);
  } else if (seconds < 6000.0) {
    std::snprintf(text.data(), text.size(), "%.0f min", seconds / 60.0);
  } else {
    std::snprintf(text.data(), text.size(), "%.1f h", seconds / 3600.0);
  }
  return text.data();
}

void erase_line() { StandardOutput::control("\r\x1b[K"); }

}  // namespace

RunWatch::RunWatch(double start, double stop, bool quiet, const char* what)
    : what_(what),
      start_(start),
      stop_(stop),
      visible_(!quiet && StandardOutput::error_is_terminal()),
      begin_(Clock::now()),
      last_(begin_) {}

RunWatch::~RunWatch() { clear(); }

void RunWatch::clear() {
  if (shown_) erase_line();
  shown_ = false;
}

Progress RunWatch::progress() {
  return [this](double time) {
    if (visible_) show(time);
    return !was_interrupted();
  };
}

void RunWatch::show(double time) {
  const auto now = Clock::now();
  const double elapsed = duration<double>(now - begin_).count();
  if (elapsed < 2.0 || duration<double>(now - last_).count() < 0.2) return;
  last_ = now;
  shown_ = true;
  const double done = stop_ > start_ ? (time - start_) / (stop_ - start_) : 1.0;
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), "%s%.6g of %.6g  %.1f %%  ", what_, time, stop_, 100.0 * done);
  erase_line();
  std::cerr << line.data();
  if (done > 0.0) std::cerr << "about " << duration_text(elapsed * (1.0 - done) / done) << " left";
  std::cerr << std::flush;
}

SettingWatch::SettingWatch(bool quiet) : visible_(!quiet && StandardOutput::error_is_terminal()) {}

SettingWatch::~SettingWatch() { clear(); }

void SettingWatch::show(const std::string& what) {
  if (!visible_) return;
  shown_ = true;
  erase_line();
  std::cerr << what << std::flush;
}

void SettingWatch::clear() {
  if (shown_) erase_line();
  shown_ = false;
}

}  // namespace bgsim::cli
