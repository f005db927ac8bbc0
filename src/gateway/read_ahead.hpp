// SPDX-License-Identifier: Apache-2.0
// Bytes of a client that wait to be taken as requests, and since when: a request is as old as its
// first byte.
#pragma once

#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::gateway {

class ReadAhead {
 public:
  void append(modbus::Bytes bytes, bus::Instant arrival);
  void consume(std::size_t bytes);
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] modbus::Bytes bytes() const { return bytes_; }
  /// When the byte at `offset` arrived, or earlier; there must be one.
  [[nodiscard]] bus::Instant arrival_at(std::size_t offset) const;

 private:
  struct Mark {
    std::size_t bytes;
    bus::Instant arrival;
  };
  std::vector<std::uint8_t> bytes_;
  std::vector<Mark> marks_;  // oldest first; their sizes add up to bytes_.size()
};

}  // namespace mbgate::gateway
