#include "descriptor_buffer.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace bgsim::cli {

// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): see block_
DescriptorBuffer::DescriptorBuffer(int descriptor, bool by_line) : descriptor_(descriptor), by_line_(by_line) {
  setp(block_.data(), block_.data() + block_.size());
}

void DescriptorBuffer::abandon(int error) {
  if (error_ == 0) error_ = error;
  setp(block_.data(), block_.data());
}

bool DescriptorBuffer::hand_over(const char* text, std::size_t count) {
  while (count > 0 && error_ == 0) {
    const ssize_t done = ::write(descriptor_, text, count);
    if (done > 0) {
      text += done;
      count -= static_cast<std::size_t>(done);
      written_ += static_cast<std::size_t>(done);
    } else if (done < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      // A pipe that another process made non-blocking: wait until it takes more.
      pollfd ready{descriptor_, POLLOUT, 0};
      if (::poll(&ready, 1, -1) < 0 && errno != EINTR) abandon(errno);
    } else if (done == 0 || errno != EINTR) {
      abandon(done == 0 ? EIO : errno);
    }
  }
  return error_ == 0;
}

int DescriptorBuffer::sync() {
  const auto count = static_cast<std::size_t>(pptr() - pbase());
  if (!hand_over(pbase(), count)) return -1;
  setp(block_.data(), block_.data() + block_.size());
  return 0;
}

DescriptorBuffer::int_type DescriptorBuffer::overflow(int_type c) {
  if (sync() != 0) return traits_type::eof();
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char one = traits_type::to_char_type(c);
  return xsputn(&one, 1) == 1 ? c : traits_type::eof();
}

std::streamsize DescriptorBuffer::xsputn(const char* text, std::streamsize count) {
  const auto size = static_cast<std::size_t>(count);
  if (size > static_cast<std::size_t>(epptr() - pptr()) && sync() != 0) return 0;
  if (size >= kSize) return hand_over(text, size) ? count : 0;
  std::memcpy(pptr(), text, size);
  pbump(static_cast<int>(size));
  if (by_line_ && std::memchr(text, '\n', size) != nullptr && sync() != 0) return 0;
  return count;
}

}  // namespace bgsim::cli
