// SPDX-License-Identifier: Apache-2.0
// The last lines of the journal, for its subscribers, which share one ring. Each continues after
// the event that it received last, and learns how many it has missed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "app/log.hpp"

namespace mbgate::app {

/// A line of the journal.
struct JournalEvent {
  std::uint64_t id = 0;  ///< counts the lines of this process from 1
  std::chrono::system_clock::time_point at;
  Level level = Level::info;
  std::string text;
};

class EventRing {
 public:
  /// The journal gets at most ten lines a minute of one kind: these are some minutes of a bad day.
  static constexpr std::size_t kSize = 256;

  struct Next {
    JournalEvent event;
    std::uint64_t lost = 0;  ///< how many between are not there
  };

  /// Takes the place of the oldest one when there are kSize. Ids rise; one that is left out counts
  /// as lost.
  void add(JournalEvent event);
  /// The id of the last one that was added; 0: there was none.
  [[nodiscard]] std::uint64_t newest() const;
  /// The id of the oldest one that is kept; 0: there was none.
  [[nodiscard]] std::uint64_t oldest() const;
  /// The first one after `id` that is there. Nothing: it is still to come.
  [[nodiscard]] std::optional<Next> after(std::uint64_t id) const;

 private:
  std::deque<JournalEvent> events_;
};

}  // namespace mbgate::app
