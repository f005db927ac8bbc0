// SPDX-License-Identifier: Apache-2.0
#include "gateway/bus_set.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::gateway {

BusSet::BusSet(const Settings& settings) : buses_(settings.buses.size()) {
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    begin(id_of(place), settings);
  }
}

void BusSet::begin(BusId id, const Settings& settings) {
  buses_[static_cast<std::size_t>(id)].bus =
      std::make_unique<bus::Bus>(settings.bus(id), settings.devices_on(id));
  touch(id).start();
}

const bus::Bus& BusSet::operator[](BusId id) const {
  return *buses_[static_cast<std::size_t>(id)].bus;
}

bus::Bus& BusSet::touch(BusId id) {
  Slot& slot = buses_[static_cast<std::size_t>(id)];
  if (!slot.touched) {
    slot.touched = true;
    touched_.push_back(id);
  }
  return *slot.bus;
}

std::optional<BusId> BusSet::take_touched() {
  if (touched_.empty()) {
    return std::nullopt;
  }
  const BusId id = touched_.back();
  touched_.pop_back();
  buses_[static_cast<std::size_t>(id)].touched = false;
  return id;
}

std::optional<bus::BusAction> BusSet::poll(BusId id) {
  return buses_[static_cast<std::size_t>(id)].bus->poll();
}

std::size_t BusSet::open_count() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(buses_, [](const Slot& slot) { return slot.bus->link().serves(); }));
}

Duration BusSet::longest_response_timeout(std::span<const BusId> buses) const {
  Duration longest{0};
  for (const BusId id : buses) {
    longest = std::max(longest, (*this)[id].longest_response_timeout());
  }
  return longest;
}

std::optional<Wake> BusSet::next_wake(std::optional<Instant> judgement) const {
  auto first = judgement ? std::optional(bus::Wake{*judgement}) : std::nullopt;
  std::size_t of = 0;
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    const auto wake = buses_[place].bus->next_wake();
    of = wake && (!first || wake->at < first->at) ? place : of;
    first = bus::earlier(first, wake);
  }
  if (!first) {
    return std::nullopt;
  }
  return Wake{first->at, first->ends_silence ? std::optional(id_of(of)) : std::nullopt};
}

void BusSet::handle_deadline(Instant now) {
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    const auto wake = buses_[place].bus->next_wake();
    if (wake && wake->at <= now) {
      touch(id_of(place)).handle_deadline(now);
    }
  }
}

void BusSet::stop(Instant now) {
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    touch(id_of(place)).stop(now);
  }
}

void BusSet::give_up(Instant now) {
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    touch(id_of(place)).give_up(now);
  }
}

void BusSet::clear_counters() {
  std::ranges::for_each(buses_, [](Slot& slot) { slot.bus->clear_counters(); });
}

std::vector<BusSet::GivenUp> BusSet::adopt(const Settings& next, const SettingsDiff& diff,
                                           Instant now) {
  auto before = std::exchange(buses_, std::vector<Slot>(next.buses.size()));
  touched_.clear();  // those under their old numbers
  std::vector<GivenUp> given_up;
  for (std::size_t place = 0; place < before.size(); ++place) {
    const auto id = diff.bus(id_of(place));
    if (diff.keeps_line(id_of(place))) {
      buses_[static_cast<std::size_t>(*id)].bus = std::move(before[place].bus);
      touch(*id).update(next.bus(*id), next.devices_on(*id), now);
    } else {
      given_up.push_back({std::move(before[place].bus), id});
    }
  }
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    if (buses_[place].bus == nullptr) {
      begin(id_of(place), next);
    }
  }
  return given_up;
}

}  // namespace mbgate::gateway
