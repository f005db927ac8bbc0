// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/read_ahead.hpp"

#include "gateway/limits.hpp"

namespace mbgate::gateway {

void ReadAhead::append(modbus::Bytes bytes, bus::Instant arrival) {
  if (bytes.empty()) {
    return;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(consumed_));
  consumed_ = 0;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  if (!marks_.empty() && marks_.back().arrival == arrival) {
    marks_.back().bytes += bytes.size();
    return;
  }
  if (marks_.size() == kArrivalMarks) {
    forget_one();
  }
  const bool is_behind_reload =
      !marks_.empty() && marks_.back().arrival < reloaded_ && arrival >= reloaded_;
  marks_.push_back({bytes.size(), arrival, is_behind_reload});
}

// Its bytes look older. If each was the first behind a reload, that is the second of all.
void ReadAhead::forget_one() {
  auto between = marks_.end() - kLastMarks;
  while (between->is_behind_reload && between != marks_.begin() + 1) {
    --between;
  }
  (between - 1)->bytes += between->bytes;
  marks_.erase(between);
}

bus::Instant ReadAhead::arrival_at(std::size_t offset) const {
  auto mark = marks_.begin();
  while (offset >= mark->bytes) {
    offset -= mark->bytes;
    ++mark;
  }
  return mark->arrival;
}

void ReadAhead::consume(std::size_t bytes) {
  consumed_ += bytes;
  if (consumed_ == bytes_.size()) {
    bytes_.clear();
    consumed_ = 0;
  }
  while (bytes > 0) {
    Mark& front = marks_.front();
    if (front.bytes > bytes) {
      front.bytes -= bytes;
      return;
    }
    bytes -= front.bytes;
    marks_.erase(marks_.begin());
  }
}

}  // namespace mbgate::gateway
