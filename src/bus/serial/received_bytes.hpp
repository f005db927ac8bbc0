// SPDX-License-Identifier: Apache-2.0
// Bytes received from a line and not yet assigned to frames, each with its time of arrival. A frame
// begins when its own first byte came.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::bus {

/// Room for a whole frame and for what may come before or after it in the same read.
inline constexpr std::size_t kMostBuffered = 1024;

class ReceivedBytes {
 public:
  /// False, and nothing is taken, if there is no room for all of them.
  [[nodiscard]] bool add(modbus::Bytes bytes, Instant now) {
    if (bytes_.size() + bytes.size() > bytes_.capacity()) {
      return false;
    }
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    came_.resize(bytes_.size(), now);
    return true;
  }
  /// Removes the first `count` bytes, which must be there.
  void drop(std::size_t count) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(count));
    came_.erase(came_.begin(), came_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  void clear() {
    bytes_.clear();
    came_.clear();
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] modbus::Bytes bytes() const { return {bytes_.data(), bytes_.size()}; }
  [[nodiscard]] Instant came_at(std::size_t at) const { return came_[at]; }

 private:
  boost::container::static_vector<std::uint8_t, kMostBuffered> bytes_;
  boost::container::static_vector<Instant, kMostBuffered> came_;
};

}  // namespace mbgate::bus
