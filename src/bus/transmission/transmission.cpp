// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/transmission.hpp"

#include <algorithm>
#include <memory>
#include <new>

#include "base/assert.hpp"

namespace mbgate::bus {

TransmissionTitle title_of(const Transmission& transmission) {
  TransmissionTitle title{transmission.leader->number, {transmission.leader->owner}};
  for (const Job* follower : transmission.followers) {
    title.requests.push_back(follower->owner);
  }
  return title;
}

Transmission& Transmissions::lead(Job& leader) {
  if (free_.empty()) {
    free_.push_back(&all_.emplace_back());
  }
  Transmission& transmission = *free_.back();
  free_.pop_back();
  transmission.leader = &leader;
  transmission.waits_since = leader.accepted_at;
  leader.leads = &transmission;
  return transmission;
}

void Transmissions::start(Transmission& transmission) { running_.push_back(&transmission); }

void Transmissions::leave(Transmission& transmission) {
  MBGATE_ASSERT(!transmission.in_flight, "what is on the wire runs until it ends");
  std::erase(running_, &transmission);
}

void Transmissions::end(Transmission& transmission) {
  MBGATE_ASSERT(transmission.followers.empty(), "who shares a transmission gets its end");
  std::erase(running_, &transmission);
  transmission.leader->leads = nullptr;
  std::destroy_at(&transmission);  // each member has an initialiser or a constructor
  free_.push_back(::new (static_cast<void*>(&transmission)) Transmission);
}

void Transmissions::hand_over(Transmission& transmission) {
  MBGATE_ASSERT(!transmission.in_flight, "who is asked for on the wire leads");
  transmission.leader->leads = nullptr;
  transmission.leader = transmission.followers.front();
  transmission.leader->leads = &transmission;
  transmission.followers.erase(transmission.followers.begin());
}

Transmission& Transmissions::find(const Transaction* on_wire) const {
  const auto found = std::ranges::find_if(
      running_, [&](const Transmission* running) { return &running->on_wire() == on_wire; });
  MBGATE_ASSERT(found != running_.end(), "what ends on the wire runs");
  return **found;
}

Transmission* Transmissions::first_in_flight() const {
  const auto first = std::ranges::find_if(running_, &Transmission::in_flight);
  return first == running_.end() ? nullptr : *first;
}

const Transmission* Transmissions::in_flight_to(std::uint8_t address) const {
  const auto asked = std::ranges::find_if(running_, [&](const Transmission* it) {
    return it->in_flight && it->on_wire().address == address;
  });
  return asked == running_.end() ? nullptr : *asked;
}

std::size_t Transmissions::in_flight() const {
  return static_cast<std::size_t>(std::ranges::count_if(running_, &Transmission::in_flight));
}

bool Transmissions::may_go_on(const Transmission& running) const {
  const auto is_stop_for_it = [&](const Transmission* other) {
    return other->in_flight && other->is_stop() &&
           other->leader->address() == running.leader->address();
  };
  return !running.in_flight && std::ranges::none_of(running_, is_stop_for_it);
}

}  // namespace mbgate::bus
