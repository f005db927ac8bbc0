// SPDX-License-Identifier: Apache-2.0
// Bytes received from a line and not yet assigned to frames, each with its time of arrival; and
// what a framer finds in them. A frame begins when its own first byte came.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/line_end.hpp"
#include "modbus/bytes.hpp"
#include "modbus/pdu.hpp"

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

// The verdict of a framer on the bytes that it was given.

/// Unsolicited frames of one piece of bytes that a framer keeps until they are taken.
inline constexpr std::size_t kMostUnsolicited = 16;

enum class Verdict : std::uint8_t {
  none,      ///< nothing yet
  response,  ///< found() has it
  damaged    ///< a frame of the right unit, function and length, with a wrong CRC or LRC
};

/// The response that a framer has found. It lasts until the next call of expect() or again().
struct FoundResponse {
  std::optional<modbus::Pdu> pdu;
  /// When its first byte came. On a line that keeps its pace: when that began at the latest,
  /// because each of its bytes has taken its time on the wire, however they were read.
  Instant began;
  bool came_first = false;  ///< nothing at all came before it since expect()
};

}  // namespace mbgate::bus
