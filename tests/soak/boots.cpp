// SPDX-License-Identifier: Apache-2.0
#include "soak/boots.hpp"

#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void BootRules::check(const Flight& flight) const {
  const Lane& lane = oracle_.books_[flight.bus].lanes[flight.address];
  if (!flight.is_stop && !flight.is_broadcast && flight.begin < lane.boots_until) {
    const Duration early = lane.boots_until - flight.begin;
    oracle_.violation("booting",
                      oracle_.name(flight) + " " + std::to_string(early / 1us) + " us too early");
  }
}

// When the gateway notices the end of what was told is not known: it may hold them for longer.
void BootRules::note(const Flight& flight) const {
  constexpr unsigned kNoForm = 0x7F;  // of the function
  PduBytes pdu = flight.pdu;
  pdu.front() =
      static_cast<std::uint8_t>(flight.is_broadcast ? pdu.front() & kNoForm : pdu.front());
  const auto fields = spec::fields_of(pdu);
  if (!fields || !is_silent(*fields)) {
    return;
  }
  const Instant told = oracle_.is_tcp(flight.bus) ? flight.begin : flight.end;
  auto& lanes = oracle_.books_[flight.bus].lanes;
  for (std::size_t address = 0; address < lanes.size(); ++address) {
    Lane& lane = lanes.at(address);
    if (!lane.device || (!flight.is_broadcast && address != flight.address)) {
      continue;
    }
    const drive::Profile& profile = oracle_.devices_[*lane.device].settings().profile;
    const bool is_autonics = profile.broadcast.form == drive::BroadcastForm::autonics;
    if (!flight.is_broadcast || is_autonics == (flight.address == kAutonicsAddress)) {
      // Its echo, which may be all that is heard, comes before the computed end of the frame.
      lane.boots_until = told + profile.unanswered.front().after - kAdapterHolds;
      oracle_.report_.fault(flight.is_broadcast ? "boots_by_broadcast" : "boots");
    }
  }
}

}  // namespace mbgate::soak
