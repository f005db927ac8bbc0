// SPDX-License-Identifier: Apache-2.0
// The writes that the accepted stops forbid, device by device: a write that arrived before a stop,
// wherever it was held meanwhile, must not be sent after it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "gateway/client.hpp"

namespace mbgate::gateway {

class StopMarks {
 public:
  explicit StopMarks(std::size_t devices) : marks_(devices) {}

  /// A stop for the device was accepted from this client, as the gateway's request number
  /// `sequence`; from none, if it is the gateway's own.
  void note(std::size_t device, std::optional<ClientId> client, std::uint64_t sequence,
            Instant now) {
    Mark& mark = marks_[device];
    if (mark.client != client) {
      mark.others_at = mark.at;
      mark.client = client;
    }
    mark.at = now;
    mark.sequence = sequence;
  }
  /// Does a stop of another client forbid a write to the device that arrived at `arrival`? What
  /// lies in a client's stream behind its own stop comes after it.
  [[nodiscard]] bool forbids(std::size_t device, ClientId client, Instant arrival) const {
    const Mark& mark = marks_[device];
    return arrival < (mark.client == client ? mark.others_at : mark.at);
  }
  /// Was a stop for the device accepted after request number `sequence`?
  [[nodiscard]] bool came_after(std::size_t device, std::uint64_t sequence) const {
    return sequence < marks_[device].sequence;
  }
  /// Other settings: nothing is known of what is gone.
  void adopt(const std::vector<drive::Device>& devices) {
    marks_.resize(devices.size());
    for (std::size_t device = 0; device < devices.size(); ++device) {
      if (devices[device].is_gone()) {
        marks_[device] = {};
      }
    }
  }

 private:
  struct Mark {
    Instant at = Instant::min();
    std::optional<ClientId> client;      ///< whose stop that was
    Instant others_at = Instant::min();  ///< the last stop before that of any other client
    std::uint64_t sequence = 0;
  };
  std::vector<Mark> marks_;
};

}  // namespace mbgate::gateway
