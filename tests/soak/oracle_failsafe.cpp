// SPDX-License-Identifier: Apache-2.0
// Stops that nobody is told of: failsafe writes, and those whose client has gone.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

void Oracle::note_failsafe_asked(const Asked& asked) {
  if (asked.kind == Kind::broadcast) {
    failsafe_.forget_writers();
  } else if (asked.door->device && !asked.refused) {
    failsafe_.asked(*asked.door->device, asked, schedule_.now());
  }
}

// The gateway's own: it is sent as a stop, and answered to nobody.
void Oracle::note_failsafe_sent(Flight& flight) {
  Book& book = books_[flight.bus];
  flight.is_stop = flight.is_failsafe = true;
  book.last_stop = book.lanes[flight.address].last_stop = schedule_.now();
  report_.fault("failsafe_sent");
  const auto device = book.lanes[flight.address].device;
  if (!device || plan_.failsafe[*device].empty()) {
    violation("unknown_transmission", name(flight));
  } else if (failsafe_.is_unwanted(*device, schedule_.now()) && !stopping_) {
    report_.fault("failsafe_perhaps_unwanted");  // who wrote last is not known for sure here
  }
}

void Oracle::note_done_for_failsafe(const Flight& flight) {
  const auto device = books_[flight.bus].lanes[flight.address].device;
  if (!device) {
    return;
  }
  if (flight.is_failsafe) {
    failsafe_.done(*device, flight.pdu, schedule_.now());
  } else if (flight.is_write && !flight.is_stop && !flight.is_broadcast &&
             flight.number > before_restart_) {
    failsafe_.written(*device, schedule_.now());
    const auto asked = flight.asked.size() == 1 ? open_.find(flight.asked.front()) : open_.end();
    if (asked != open_.end() && !asked->second->client_gone) {
      failsafe_.wrote(*device, asked->second->client, schedule_.now());
    }
  }
}

// May one be sent on the bus?
bool Oracle::has_failsafe(std::size_t bus) const {
  return std::ranges::any_of(books_[bus].lanes, [&](const Lane& lane) {
    return lane.device && !plan_.failsafe[*lane.device].empty();
  });
}

// Nobody is there, and nothing goes wrong.
void Oracle::check_failsafes() const {
  for (const Book& book : books_) {
    for (const Lane& lane : book.lanes) {
      const auto missing =
          lane.device && book.open ? failsafe_.missing(*lane.device, reloaded_) : std::nullopt;
      if (missing) {
        violation("failsafe_missing", plan_.settings.devices[*lane.device].name);
      }
    }
  }
}

// Stops are sent though their client has gone, and nobody is told of their end.
void Oracle::forget_gone_stops() {
  std::vector<Asked*> over;
  for (const auto& [id, asked] : open_) {
    if (asked->client_gone && schedule_.now() > asked->accepted + kStopLife) {
      over.push_back(asked.get());
    }
  }
  std::ranges::sort(over, {}, &Asked::id);
  for (Asked* asked : over) {
    close(*asked, "stop_too_late");
  }
}

}  // namespace mbgate::soak
