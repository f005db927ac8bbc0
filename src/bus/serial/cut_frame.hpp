// SPDX-License-Identifier: Apache-2.0
// Joins a frame that no request waits for and that an adapter delivers in two pieces with a pause
// between. The latency timer of an FTDI can split a late answer like any other frame.
#pragma once

#include <bitset>
#include <boost/container/static_vector.hpp>

#include "bus/instant.hpp"
#include "modbus/frames.hpp"

namespace mbgate::bus {

/// A frame that has begun pauses for no longer, and is not longer under way.
inline constexpr Duration kLongestPauses = std::chrono::seconds(1);

class CutFrame {
 public:
  /// The bytes (at least one) were given up as a frame. The first of them came at `began`, the last
  /// at `last`. They are appended to what is kept, unless they began more than kLongestPauses
  /// after it: then that is dropped first. Only what may be the beginning of a frame is kept; where
  /// there is no room for all of it, the oldest pieces are dropped.
  void keep(modbus::Bytes bytes, Instant began, Instant last);
  /// A valid frame that begins in what was kept and ends in the new bytes.
  struct Joined {
    modbus::RtuAdu frame;
    std::size_t taken;  ///< of the new bytes
    bool is_response;   ///< else it is another client's request
    bool after_noise;
    Duration pause;  ///< the longest between its pieces
  };
  /// Completes a kept frame with `bytes`, which began at `began`; what is kept is then dropped.
  /// Nothing if the bytes complete no frame, began more than kLongestPauses after what is kept, or
  /// begin with a valid frame themselves.
  std::optional<Joined> complete(modbus::Bytes bytes, Instant began);

  /// Could `bytes`, which began at `began`, go on with what is kept, and more follow? Not behind a
  /// pause longer than `slack`.
  [[nodiscard]] bool may_go_on(modbus::Bytes bytes, Instant began, Duration slack) const;
  /// Is nothing kept? Then nothing can be completed.
  [[nodiscard]] bool empty() const { return kept_.empty(); }

 private:
  using Together = boost::container::static_vector<std::uint8_t, 2 * modbus::kMaxRtuSize>;
  /// What is kept, and these bytes behind it.
  [[nodiscard]] Together joined_with(modbus::Bytes bytes) const;
  void clear();
  void make_room(std::size_t size);

  boost::container::static_vector<std::uint8_t, modbus::kMaxRtuSize> kept_;
  /// Where in `kept_` a piece begins that was given up: a frame may begin with any of them.
  std::bitset<modbus::kMaxRtuSize> begins_;
  Instant last_;
  Duration pause_{0};  // the longest between two pieces
};

}  // namespace mbgate::bus
