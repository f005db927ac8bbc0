// SPDX-License-Identifier: Apache-2.0
// Bytes of a client that were not yet taken as requests, with their arrival times. A request is as
// old as its first byte.
#pragma once

#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::gateway {

class ReadAhead {
 public:
  void append(modbus::Bytes bytes, bus::Instant arrival);
  /// What arrives from now on does not count as older than this.
  void note_reload(bus::Instant now) { reloaded_ = now; }
  [[nodiscard]] bus::Instant reloaded() const { return reloaded_; }
  void consume(std::size_t bytes);
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] std::size_t size() const { return bytes_.size() - consumed_; }
  [[nodiscard]] modbus::Bytes bytes() const { return modbus::Bytes(bytes_).subspan(consumed_); }
  /// When the byte at `offset` arrived, or earlier; there must be one.
  [[nodiscard]] bus::Instant arrival_at(std::size_t offset) const;

 private:
  void forget_one();
  struct Mark {
    std::size_t bytes;
    bus::Instant arrival;
    bool is_behind_reload;  ///< and the one before it is not
  };
  std::vector<std::uint8_t> bytes_;
  std::size_t consumed_ = 0;  // of these, not taken out yet
  std::vector<Mark> marks_;   // oldest first; their sizes add up to size()
  bus::Instant reloaded_ = bus::Instant::min();
};

}  // namespace mbgate::gateway
