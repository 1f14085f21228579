/// Text on its way to a terminal.
#pragma once

#include <streambuf>
#include <string>

namespace bgsim::cli {

/// Hands on what is written to it with everything made visible (visible_text). What a terminal would obey never gets
/// through, whoever wrote it: names are made visible and short where lines are composed, and this is the last door.
class TextBuffer : public std::streambuf {
 public:
  /// @param to  where the text goes; outlives this.
  explicit TextBuffer(std::streambuf* to) : to_(to) {}
  [[nodiscard]] std::streambuf* to() const { return to_; }

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;

 private:
  bool write(std::string_view text);

  std::streambuf* to_;
  std::string held_;  ///< the beginning of a character whose other bytes are to come, or a carriage return
};

}  // namespace bgsim::cli
