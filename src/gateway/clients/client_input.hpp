// SPDX-License-Identifier: Apache-2.0
// Bytes of a client that have not become requests yet: an incomplete request, or requests beyond
// the number that a connection may have.
#pragma once

#include <algorithm>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::gateway {

class ClientInput {
 public:
  /// `arrival`: when they arrived in the socket, or earlier.
  void append(modbus::Bytes bytes, bus::Instant arrival, bus::Instant now) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(consumed_));
    consumed_ = 0;
    first_ = bytes_.empty() ? arrival : first_;
    last_ = arrival;
    read_at_ = now;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void consume(std::size_t bytes) {
    consumed_ += bytes;
    first_ = last_;
  }
  [[nodiscard]] bool empty() const { return bytes().empty(); }
  [[nodiscard]] modbus::Bytes bytes() const { return modbus::Bytes(bytes_).subspan(consumed_); }
  /// Of the first byte.
  [[nodiscard]] bus::Instant arrival() const { return first_; }
  /// When the last of them were read.
  [[nodiscard]] bus::Instant read_at() const { return read_at_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t consumed_ = 0;  // of these
  bus::Instant first_;
  bus::Instant last_;
  bus::Instant read_at_;
};

}  // namespace mbgate::gateway
