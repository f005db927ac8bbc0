// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/early_stops.hpp"

#include <algorithm>

#include "base/assert.hpp"

namespace mbgate::gateway {

void EarlyStops::add(const Stop& stop) {
  stops_.insert(std::ranges::upper_bound(stops_, stop.position, {}, &Stop::position), stop);
}

void EarlyStops::note_write(std::size_t device, std::uint64_t position) {
  const bool known =
      !writes_.empty() && writes_.back().device == device && writes_.back().position == position;
  if (!known) {  // a run is many transactions
    writes_.push_back({device, position});
  }
}

void EarlyStops::begin_look(std::uint64_t front, bool at_all) {
  looking_at_ = at_all ? front : std::max(looked_at_, front);
  first_held_.reset();
  // Reading has come to the others, or they will be looked at again.
  std::erase_if(writes_,
                [&](const Place& it) { return it.position < front || it.position >= looking_at_; });
}

bool EarlyStops::write_lies_before(const DevicePlaces& devices, std::uint64_t position) const {
  return std::ranges::any_of(writes_, [&](const Place& it) {
    return it.position < position && std::ranges::find(devices, it.device) != devices.end();
  });
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
