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

StandardOutput::StandardOutput() : buffer_(STDOUT_FILENO, fill_gaps()), before_(std::cout.rdbuf(&buffer_)) {}

StandardOutput::~StandardOutput() { std::cout.rdbuf(before_); }

void StandardOutput::flush() {
  std::cout.flush();
  const auto* own = dynamic_cast<const DescriptorBuffer*>(std::cout.rdbuf());
  const int error = own != nullptr ? own->error() : 0;
  if (error != 0) throw UsageError(std::string("cannot write to standard output: ") + std::strerror(error));
}

}  // namespace bgsim::cli
