// SPDX-License-Identifier: Apache-2.0
#include "gateway/taken_ahead.hpp"

#include <algorithm>

namespace mbgate::gateway {

void TakenAhead::forbid(const DevicePlaces& devices, std::uint64_t before) {
  for (const std::size_t device : devices) {
    const auto known = std::ranges::find(forbidden_, device, &Forbidden::device);
    if (known != forbidden_.end()) {
      known->before = before;
    } else {
      forbidden_.push_back({device, before});
    }
  }
}

bool TakenAhead::forbids(std::size_t device, std::uint64_t position) const {
  return std::ranges::any_of(
      forbidden_, [&](const Forbidden& it) { return it.device == device && position < it.before; });
}

std::optional<TakenAhead::Stop> TakenAhead::take(std::uint64_t position) {
  if (stops_.empty() || stops_.front().position != position) {
    return std::nullopt;
  }
  Stop stop = std::move(stops_.front());
  stops_.erase(stops_.begin());
  if (stops_.empty()) {
    forbidden_.clear();  // each of them lay before a stop
  }
  return stop;
}

bool TakenAhead::keep_answer(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer) {
  const auto stop = std::ranges::find(stops_, std::optional(exchange), &Stop::exchange);
  if (stop == stops_.end()) {
    return false;
  }
  stop->exchange.reset();
  stop->answer = answer;
  return true;
}

}  // namespace mbgate::gateway
