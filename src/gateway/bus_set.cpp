// SPDX-License-Identifier: Apache-2.0
#include "gateway/bus_set.hpp"

#include <algorithm>
#include <utility>

#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {

BusSet::BusSet(const Settings& settings) : buses_(settings.buses.size()) {
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    begin(id_of(place), settings);
  }
}

namespace {

bool is_same_port(const bus::LineSettings& one, const bus::LineSettings& other) {
  return one.framing != bus::Framing::tcp && other.framing != bus::Framing::tcp &&
         one.has_end_of(other);
}

}  // namespace

void BusSet::begin(BusId id, const Settings& settings) {
  buses_[static_cast<std::size_t>(id)].bus =
      std::make_unique<bus::Bus>(settings.bus(id), settings.devices_on(id));
  touch(id).set_traced(traced_);
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
  while (!touched_.empty()) {
    const BusId id = touched_.back();
    touched_.pop_back();
    buses_[static_cast<std::size_t>(id)].touched = false;
    if (is_there(id)) {
      return id;
    }
  }
  return std::nullopt;
}

std::optional<bus::BusAction> BusSet::poll(BusId id) {
  return buses_[static_cast<std::size_t>(id)].bus->poll();
}

std::size_t BusSet::open_count() const {
  std::size_t open = 0;
  for_each([&](BusId, const bus::Bus& it) { open += it.link().serves() ? 1 : 0; });
  return open;
}

Duration BusSet::longest_transaction(std::span<const BusId> buses) const {
  Duration longest{0};
  for (const BusId id : buses) {
    longest = std::max(longest, (*this)[id].devices().longest_transaction());
  }
  return longest;
}

std::optional<Wake> BusSet::next_wake(std::optional<Instant> judgement) const {
  auto first = judgement ? std::optional(bus::Wake{*judgement}) : std::nullopt;
  BusId of{};
  for_each([&](BusId id, const bus::Bus& it) {
    const auto wake = it.next_wake();
    of = wake && (!first || wake->at < first->at) ? id : of;
    first = bus::earlier(first, wake);
  });
  if (!first) {
    return std::nullopt;
  }
  return Wake{first->at, first->ends_silence ? std::optional(of) : std::nullopt};
}

void BusSet::handle_deadline(Instant now) {
  for_each([&](BusId id, const bus::Bus& it) {
    const auto wake = it.next_wake();
    if (wake && wake->at <= now) {
      touch(id).handle_deadline(now);
    }
  });
}

void BusSet::set_traced(bool traced) {
  traced_ = traced;
  for (const Slot& slot : buses_) {
    if (slot.bus != nullptr) {
      slot.bus->set_traced(traced);  // not touched: what is done next stays as it is
    }
  }
}

std::vector<BusSet::GivenUp> BusSet::adopt(const Settings& old, const Settings& next, Instant now) {
  std::vector<GivenUp> given_up;
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    Slot& slot = buses_[place];
    const BusId id = id_of(place);
    if (slot.bus != nullptr && keeps_line(old, next, id)) {
      touch(id).update(next.bus(id), next.devices_on(id), now);
    } else if (slot.bus != nullptr) {
      given_up.push_back({id, std::move(slot.bus)});
    }
  }
  buses_.resize(next.buses.size());
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    if (buses_[place].bus == nullptr && !next.buses[place].is_gone) {
      begin(id_of(place), next);
      const auto before = std::ranges::find_if(given_up, [&](const GivenUp& it) {
        return is_same_port(old.bus(it.id).line, next.buses[place].line);
      });
      if (before != given_up.end()) {
        buses_[place].bus->take_over(*before->bus, now);
      }
    }
  }
  return given_up;
}

}  // namespace mbgate::gateway
