/// Standard output, with every failure to write known by its reason.
#pragma once

#include <streambuf>

#include "descriptor_buffer.hpp"

namespace bgsim::cli {

/// While it lives, std::cout writes through a DescriptorBuffer, and no file that is opened can take the place of a
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

 private:
  DescriptorBuffer buffer_;
  std::streambuf* before_;
};

}  // namespace bgsim::cli
