// SPDX-License-Identifier: Apache-2.0
#include "app/trace/trace_ring.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::app {

// Its bytes are in the text, as two digits and a blank each: the record itself is smaller.
std::size_t TraceRing::size_of(const TraceItem& item) { return sizeof item + 2 * item.text.size(); }

void TraceRing::add(TraceItem item) {
  newest_ = item.id;
  bytes_ += size_of(item);
  items_.push_back(std::move(item));
  while (bytes_ > kMostBytes && items_.size() > 1) {
    bytes_ -= size_of(items_.front());
    items_.pop_front();
  }
}

std::optional<TraceRing::Next> TraceRing::after(std::uint64_t id) const {
  const auto found = std::ranges::upper_bound(items_, id, {}, &TraceItem::id);
  if (found == items_.end()) {
    return std::nullopt;
  }
  return Next{*found, found->id - id - 1};
}

void TraceRing::clear() {
  items_.clear();
  bytes_ = 0;
}

}  // namespace mbgate::app
