// SPDX-License-Identifier: Apache-2.0
// A file descriptor that is closed by its last owner. Closing may block (a failing serial adapter):
// then the owner must be on a thread that may wait.
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace mbgate::sys {

/// True if a call that failed with this errno can be repeated later: the descriptor has not failed.
inline bool would_block(int error) { return error == EAGAIN || error == EINTR; }

/// Bytes that were sent without waiting; nothing if the connection is broken, and errno says why.
inline std::optional<std::size_t> send_now(int socket, std::span<const std::uint8_t> bytes) {
  const ssize_t count = ::send(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count >= 0) {
    return static_cast<std::size_t>(count);
  }
  return would_block(errno) ? std::optional<std::size_t>(0) : std::nullopt;
}

/// A time to wait, as the system's calls want it.
inline timespec timespec_of(std::chrono::nanoseconds time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  return {static_cast<std::time_t>(whole.count()),
          static_cast<decltype(timespec::tv_nsec)>((time - whole).count())};
}

/// 0, or the error number.
inline int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno != EINTR) {
      return errno;
    }
    text.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
  }
  return 0;
}

/// A standard stream that is closed becomes /dev/null. Otherwise its number goes to the next file
/// or port that is opened, and so does what is printed.
inline void open_standard_streams() {
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(standard, F_GETFD) < 0) {
      static_cast<void>(::open("/dev/null", O_RDWR));
    }
  }
}

class UniqueFd {
 public:
  UniqueFd() = default;
  explicit UniqueFd(int fd) : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(other.release()) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    if (this != &other) {
      reset(other.release());
    }
    return *this;
  }
  UniqueFd(const UniqueFd&) = delete;
  UniqueFd& operator=(const UniqueFd&) = delete;
  ~UniqueFd() { reset(); }

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  int release() { return std::exchange(fd_, -1); }
  void reset(int fd = -1) {
    if (fd_ >= 0) {
      ::close(fd_);
    }
    fd_ = fd;
  }

 private:
  int fd_ = -1;
};

}  // namespace mbgate::sys
