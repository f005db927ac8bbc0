// SPDX-License-Identifier: Apache-2.0
// Bytes of a client that were not yet taken as requests: a part of one, or what came beyond the
// requests that a connection may have.
#pragma once

#include <algorithm>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::gateway {

class ClientInput {
 public:
  /// When bytes arrived in the socket, or earlier, and when they were read.
  struct Times {
    bus::Instant arrival;
    bus::Instant read;
  };
  void append(modbus::Bytes bytes, const Times& times) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(consumed_));
    consumed_ = 0;
    first_ = bytes_.empty() ? times : first_;
    last_ = times;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void consume(std::size_t bytes) {
    consumed_ += bytes;
    first_ = last_;
  }
  [[nodiscard]] bool empty() const { return bytes().empty(); }
  [[nodiscard]] modbus::Bytes bytes() const { return modbus::Bytes(bytes_).subspan(consumed_); }
  /// Of the first byte.
  [[nodiscard]] const Times& times() const { return first_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t consumed_ = 0;  // of these
  Times first_{};
  Times last_{};
};

}  // namespace mbgate::gateway
