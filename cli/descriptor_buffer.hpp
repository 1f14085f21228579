/// A stream's way to an open file of the system, which remembers why a write failed.
#pragma once

#include <array>
#include <cstddef>
#include <streambuf>

namespace bgsim::cli {

/// Collects what a stream writes and hands it to a descriptor whole: a write that a signal cuts short, or that takes
/// only a part, goes on where it stopped. After a failure nothing more is written.
class DescriptorBuffer : public std::streambuf {
 public:
  /// @param descriptor  stays the caller's to close.
  /// @param by_line  hands over each line at its end, as on a terminal.
  explicit DescriptorBuffer(int descriptor = -1, bool by_line = false);
  DescriptorBuffer(const DescriptorBuffer&) = delete;
  DescriptorBuffer& operator=(const DescriptorBuffer&) = delete;
  ~DescriptorBuffer() override = default;  ///< what was not flushed is dropped

  /// Writes to another descriptor from here on.
  void attach(int descriptor) { descriptor_ = descriptor; }
  /// errno of the first write that failed, 0 if none has.
  [[nodiscard]] int error() const { return error_; }
  /// Bytes handed to the system so far.
  [[nodiscard]] std::size_t written() const { return written_; }
  /// Drops what has not been handed over, and everything that comes.
  void abandon(int error);

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;

 private:
  bool hand_over(const char* text, std::size_t count);

  static constexpr std::size_t kSize = std::size_t{1} << 16U;
  std::array<char, kSize> block_;  // not set to zero: that would touch all of its pages at each start
  int descriptor_, error_ = 0;
  std::size_t written_ = 0;
  bool by_line_;
};

}  // namespace bgsim::cli
