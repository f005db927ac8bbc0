// SPDX-License-Identifier: Apache-2.0
// A file descriptor that is closed by its last owner. Closing may block (a failing serial adapter):
// then the owner must be on a thread that may wait.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace mbgate::sys {

/// True if a call that failed with this errno can be repeated later: the descriptor has not failed.
inline bool would_block(int error) { return error == EAGAIN || error == EINTR; }

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
