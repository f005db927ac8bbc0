// SPDX-License-Identifier: Apache-2.0
// A device that has not answered: what that costs the others, and when it is offline.
#include <algorithm>

#include "bus/transmission/outcomes.hpp"

namespace mbgate::bus {
namespace {

// At an address that no [[device]] has, and that was never heard, there may be nobody.
unsigned offline_after(const DeviceEntry& entry) {
  const unsigned usual = entry.timing().offline_after;
  return entry.is_unknown() ? std::min(usual, 1U) : usual;
}

}  // namespace

// Nothing came from the device; what is owed on a connection holds nothing.
void Outcomes::note_unreached(Transmission& transmission, Instant now) {
  const Transaction& sent = transmission.on_wire();
  DeviceEntry& entry = parts_.devices[sent.address];
  entry.setting_known = false;
  entry.cache.clear();
  entry.unreached = sent.response->bytes()[1];
  note_unanswered(transmission, now, now);
}

// Something else goes before the next stop to this device.
void Outcomes::note_turn(const Transmission& transmission) {
  if (transmission.is_stop()) {
    parts_.devices[transmission.on_wire().address].last_stop_turn = transmission.turn;
  }
}

void Outcomes::note_unanswered(Transmission& transmission, Instant due, Instant now) {
  const std::uint8_t address = transmission.on_wire().address;
  DeviceEntry& entry = parts_.devices[address];
  note_turn(transmission);
  parts_.payback.note_lost(transmission.last_sent, now);
  parts_.probes.note_unanswered(transmission, now);
  if (entry.health.note_unanswered(transmission.last_sent, due, offline_after(entry))) {
    go_offline(entry, address, now);
  }
}

void Outcomes::go_offline(DeviceEntry& entry, std::uint8_t address, Instant now) {
  entry.health.set_probe_at(now + entry.timing().probe_interval);
  entry.merge_refused = false;
  diagnosis_.notify(DeviceNotice::Kind::lost, address);
  ends_.end_waiting_for(address);
}

}  // namespace mbgate::bus
