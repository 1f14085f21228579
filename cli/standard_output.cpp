#include "standard_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <iostream>

#include "command.hpp"

namespace bgsim::cli {

namespace {

/// Descriptors 0 to 2 that are closed become ones on which every use fails.
bool fill_gaps() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0) (void)!::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  return ::isatty(STDOUT_FILENO) != 0;
}

}  // namespace

StandardOutput::StandardOutput()
    : buffer_(STDOUT_FILENO, fill_gaps()), out_(&buffer_), error_(std::cerr.rdbuf()), before_(std::cout.rdbuf(&out_)) {
  std::cerr.rdbuf(&error_);
}

StandardOutput::~StandardOutput() {
  std::cout.rdbuf(before_);
  std::cerr.rdbuf(error_.to());
}

std::streambuf* StandardOutput::data() {
  const auto* text = dynamic_cast<const TextBuffer*>(std::cout.rdbuf());
  return text == nullptr || ::isatty(STDOUT_FILENO) != 0 ? std::cout.rdbuf() : text->to();
}

void StandardOutput::control(std::string_view sequence) {
  const auto* text = dynamic_cast<const TextBuffer*>(std::cerr.rdbuf());
  std::streambuf* to = text == nullptr ? std::cerr.rdbuf() : text->to();
  to->sputn(sequence.data(), static_cast<std::streamsize>(sequence.size()));
  to->pubsync();
}

bool StandardOutput::error_is_terminal() {
  const auto* text = dynamic_cast<const TextBuffer*>(std::cerr.rdbuf());
  const bool kept = text != nullptr && dynamic_cast<const std::stringbuf*>(text->to()) != nullptr;
  return !kept && ::isatty(STDERR_FILENO) != 0;
}

KeptText::KeptText() : visible_(&kept_), out_(std::cout.rdbuf(&visible_)), error_(std::cerr.rdbuf(&visible_)) {}

KeptText::~KeptText() {
  std::cout.rdbuf(out_);
  std::cerr.rdbuf(error_);
}

void StandardOutput::flush() {
  std::cout.flush();
  const auto* text = dynamic_cast<const TextBuffer*>(std::cout.rdbuf());
  const auto* own = text == nullptr ? nullptr : dynamic_cast<const DescriptorBuffer*>(text->to());
  const int error = own != nullptr ? own->error() : 0;
  if (error != 0) throw UsageError(std::string("cannot write to standard output: ") + std::strerror(error));
}

}  // namespace bgsim::cli
