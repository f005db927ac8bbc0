// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/early_stops.hpp"

#include <algorithm>

#include "base/assert.hpp"

namespace mbgate::gateway {

void EarlyStops::add(const Stop& stop) {
  stops_.insert(std::ranges::upper_bound(stops_, stop.position, {}, &Stop::position), stop);
}

void EarlyStops::begin_look(std::uint64_t front, bool at_all) {
  looking_at_ = at_all ? front : std::max(looked_at_, front);
}

EarlyStops::Stop EarlyStops::take(std::uint64_t position) {
  MBGATE_ASSERT(!stops_.empty() && stops_.front().position == position,
                "stops taken early are passed in the order of their positions");
  Stop stop = std::move(stops_.front());
  stops_.erase(stops_.begin());
  return stop;
}

bool EarlyStops::keep_answer(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer) {
  const auto stop = std::ranges::find(stops_, std::optional(exchange), &Stop::exchange);
  if (stop == stops_.end()) {
    return false;
  }
  stop->exchange.reset();
  stop->answer = answer;
  return true;
}

}  // namespace mbgate::gateway
