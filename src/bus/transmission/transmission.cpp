// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/transmission.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"

namespace mbgate::bus {
namespace {

bool is_in_flight(const Job* job) { return job->sent.in_flight; }

}  // namespace

TransmissionTitle title_of(const Job& leader) {
  TransmissionTitle title{leader.number, {leader.owner}};
  for (const Job* follower : leader.sent.followers) {
    title.requests.push_back(follower->owner);
  }
  return title;
}

void Transmissions::leave(Job& leader) {
  MBGATE_ASSERT(!leader.sent.in_flight, "what is on the wire runs until it ends");
  std::erase(running_, &leader);
}

void Transmissions::end(Job& leader) {
  MBGATE_ASSERT(leader.sent.followers.empty(), "who shares a transmission gets its end");
  std::erase(running_, &leader);
  leader.sent = {};
}

void Transmissions::hand_over(Job& leader) {
  MBGATE_ASSERT(!leader.sent.in_flight, "who is asked for on the wire leads");
  Job& heir = *leader.sent.followers.front();
  heir.sent = std::exchange(leader.sent, {});
  heir.sent.followers.erase(heir.sent.followers.begin());
  std::ranges::replace(running_, &leader, &heir);
}

Job& Transmissions::find(const Transaction* on_wire) const {
  const auto found = std::ranges::find_if(
      running_, [&](const Job* running) { return &running->transaction() == on_wire; });
  MBGATE_ASSERT(found != running_.end(), "what ends on the wire runs");
  return **found;
}

Job* Transmissions::first_in_flight() const {
  const auto first = std::ranges::find_if(running_, is_in_flight);
  return first == running_.end() ? nullptr : *first;
}

const Job* Transmissions::in_flight_to(std::uint8_t address) const {
  const auto asked = std::ranges::find_if(running_, [&](const Job* it) {
    return is_in_flight(it) && it->transaction().address == address;
  });
  return asked == running_.end() ? nullptr : *asked;
}

std::size_t Transmissions::in_flight() const {
  return static_cast<std::size_t>(std::ranges::count_if(running_, is_in_flight));
}

bool Transmissions::may_go_on(const Job& running) const {
  const auto is_stop_for_it = [&](const Job* other) {
    return is_in_flight(other) && other->is_stop() && other->address() == running.address();
  };
  return !running.sent.in_flight && std::ranges::none_of(running_, is_stop_for_it);
}

}  // namespace mbgate::bus
