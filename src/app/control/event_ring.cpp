// SPDX-License-Identifier: Apache-2.0
#include "app/control/event_ring.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::app {

void EventRing::add(JournalEvent event) {
  if (events_.size() == kSize) {
    events_.pop_front();
  }
  events_.push_back(std::move(event));
}

std::uint64_t EventRing::newest() const { return events_.empty() ? 0 : events_.back().id; }

std::uint64_t EventRing::oldest() const { return events_.empty() ? 0 : events_.front().id; }

std::optional<EventRing::Next> EventRing::after(std::uint64_t id) const {
  const auto found = std::ranges::upper_bound(events_, id, {}, &JournalEvent::id);
  if (found == events_.end()) {
    return std::nullopt;
  }
  return Next{*found, found->id - id - 1};
}

}  // namespace mbgate::app
