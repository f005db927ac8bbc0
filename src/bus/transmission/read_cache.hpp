// SPDX-License-Identifier: Apache-2.0
// What was recently read from one device (functions 01 to 04), for clients that send the same read
// again. It is emptied whenever a write to the device is accepted, and not filled until that write
// has ended: no client gets data from before a write.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "bus/instant.hpp"
#include "drive/transaction.hpp"

namespace mbgate::bus {

/// The most different reads of one device that are cached: more than a screen needs.
inline constexpr std::size_t kMostCachedReads = 64;

class ReadCache {
 public:
  /// True for functions 01 to 04: what they return depends on nothing but the device.
  [[nodiscard]] static bool can_hold(const modbus::Request& request) {
    return request.function() >= 0x01 && request.function() <= 0x04;
  }
  /// The response to the same request to the same unit, if it was asked for at `oldest` or later.
  [[nodiscard]] const modbus::Pdu* find(const Transaction& asked, Instant oldest) const {
    const auto found =
        std::ranges::find_if(reads_, [&](const Read& it) { return it.asked.is_like(asked); });
    return found == reads_.end() || found->asked_at < oldest ? nullptr : &*found->asked.response;
  }
  /// `asked_at`: when the request was transmitted; the data are no older than that. `writes_ended`:
  /// writes_ended() at that time. If more writes than that were accepted, the data may be from
  /// before them and are not cached.
  void put(const Transaction& asked, Instant asked_at, std::uint64_t writes_ended) {
    if (writes_ended < accepted_) {
      return;
    }
    std::erase_if(reads_, [&](const Read& it) { return it.asked.is_like(asked); });
    if (reads_.size() == kMostCachedReads) {
      reads_.erase(std::ranges::min_element(reads_, {}, &Read::asked_at));
    }
    reads_.push_back({asked, asked_at});
  }
  /// How many writes to the device have ended so far.
  [[nodiscard]] std::uint64_t writes_ended() const { return ended_; }
  void clear() { reads_.clear(); }
  void begin_write() {
    ++accepted_;
    clear();
  }
  void end_write() { ++ended_; }

 private:
  struct Read {
    Transaction asked;  ///< with its response
    Instant asked_at;
  };
  std::vector<Read> reads_;
  std::uint64_t accepted_ = 0;  // writes
  std::uint64_t ended_ = 0;     // of these
};

}  // namespace mbgate::bus
