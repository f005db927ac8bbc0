// SPDX-License-Identifier: Apache-2.0
// When a stop was last taken for each device. A write that had arrived before, wherever it lay
// meanwhile, must not follow it.
#pragma once

#include <optional>
#include <vector>

#include "gateway/event.hpp"

namespace mbgate::gateway {

class StopMarks {
 public:
  explicit StopMarks(std::size_t devices) : marks_(devices) {}

  /// A stop for the device was taken from this client; from none, if it is the gateway's own.
  void note(std::size_t device, std::optional<ClientId> client, Instant now) {
    Mark& mark = marks_[device];
    if (mark.client != client) {
      mark.others_at = mark.at;
      mark.client = client;
    }
    mark.at = now;
  }
  /// Does a stop forbid a write to the device that arrived then? A client's own stops do not count
  /// here: its connection knows which of its writes lie before them (EarlyStops), and those behind
  /// them may be as old by the clock.
  [[nodiscard]] bool forbids(std::size_t device, ClientId client, Instant arrival) const {
    const Mark& mark = marks_[device];
    return arrival < (mark.client == client ? mark.others_at : mark.at);
  }
  [[nodiscard]] std::size_t size() const { return marks_.size(); }
  /// The mark of a device in `old` goes over to its new place.
  void carry(std::size_t device, const StopMarks& old, std::size_t old_device) {
    marks_[device] = old.marks_[old_device];
  }

 private:
  struct Mark {
    Instant at = Instant::min();
    std::optional<ClientId> client;      ///< whose stop that was
    Instant others_at = Instant::min();  ///< the last one before that of anybody else
  };
  std::vector<Mark> marks_;
};

}  // namespace mbgate::gateway
