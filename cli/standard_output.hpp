/// Standard output and standard error: text made visible, data byte for byte, every failure to write known by its
/// reason.
#pragma once

#include <sstream>
#include <streambuf>
#include <string>
#include <string_view>

#include "descriptor_buffer.hpp"
#include "text_buffer.hpp"

namespace bgsim::cli {

/// While it lives, std::cout and std::cerr are text for people: what they are given is made visible (TextBuffer). What
/// they write to standard output goes through a DescriptorBuffer, and no file that is opened can take the place of a
/// standard stream that the caller closed: what is written to such a one fails.
class StandardOutput {
 public:
  StandardOutput();
  ~StandardOutput();
  StandardOutput(const StandardOutput&) = delete;
  StandardOutput& operator=(const StandardOutput&) = delete;

  /// Hands over what was written.
  /// @throws UsageError with the system's reason.
  static void flush();
  /// Where data go (a trace, a picture), byte for byte; on a terminal they are text as well.
  [[nodiscard]] static std::streambuf* data();
  /// What a terminal is to obey, on standard error: for the lines that show how far a run is, and for nothing else.
  static void control(std::string_view sequence);
  /// Whether somebody sees such lines: no, while what is written is kept (KeptText).
  [[nodiscard]] static bool error_is_terminal();

 private:
  DescriptorBuffer buffer_;
  TextBuffer out_, error_;
  std::streambuf* before_;
};

/// While it lives, what is written to std::cout and std::cerr is kept, in its order, with everything made visible.
class KeptText {
 public:
  KeptText();
  ~KeptText();
  KeptText(const KeptText&) = delete;
  KeptText& operator=(const KeptText&) = delete;
  [[nodiscard]] std::string text() const { return kept_.str(); }

 private:
  std::stringbuf kept_;
  TextBuffer visible_;
  std::streambuf *out_, *error_;
};

}  // namespace bgsim::cli
