// SPDX-License-Identifier: Apache-2.0
// What the end of a stop's transmission means: it counts as carried out, is repeated, or is given
// up.
#include <algorithm>

#include "bus/transmission/outcomes.hpp"

namespace mbgate::bus {

// Not beside a write on a Modbus TCP connection, which the server may carry out after the stop.
void Outcomes::note_stopped(const Transmission& transmission, Instant now) {
  const Transaction& sent = transmission.on_wire();
  const auto may_undo = [&](const Transmission* other) {
    return other->in_flight && other->leader->job_class == JobClass::write &&
           other->leader->address() == sent.address;
  };
  const bool stops =
      sent.is_broadcast() || parts_.devices.is_stop(sent.address, sent.request, sent.broadcast);
  if (transmission.is_stop() && stops &&
      std::ranges::none_of(parts_.transmissions.running(), may_undo)) {
    parts_.acknowledged.note(sent, now);
  }
}

// It is repeated behind other stops that wait, so that a dead device does not keep them waiting.
void Outcomes::handle_stop_failure(Transmission& stop, Instant now) {
  // What its owner sends as a stop, but is none, may not be harmless if it is done twice.
  const Transaction& sent = stop.on_wire();
  DeviceEntry& entry = parts_.devices[sent.address];
  const bool may_repeat = parts_.devices.is_stop(sent.address, sent.request, sent.broadcast);
  const bool is_given_up = stop.is_one_try && entry.stops_given_up;
  if (may_repeat && !is_given_up && stop.tries <= entry.timing().stop_retries) {
    parts_.transmissions.leave(stop);
    stop.waits_since = now;
    parts_.stops.push(stop);
    return;
  }
  entry.stops_given_up = entry.last_stop_turn != 0 && (may_repeat || entry.stops_given_up);
  give_up_stop(stop);
}

void Outcomes::give_up_stop(Transmission& stop) {
  part_from_untried(stop);
  ++parts_.counters.stops_unanswered;
  diagnosis_.notify(DeviceNotice::Kind::stop_unanswered, stop.on_wire().address);
  ends_.finish(stop, Ending::no_answer);
}

// Those that joined it after its last transmission are still to be transmitted once.
void Outcomes::part_from_untried(Transmission& stop) {
  const auto untried = std::ranges::stable_partition(stop.followers, &Job::was_on_wire);
  if (untried.empty()) {
    return;
  }
  Transmission& heir = parts_.transmissions.lead(*untried.front());
  heir.followers.assign(untried.begin() + 1, untried.end());
  stop.followers.erase(untried.begin(), untried.end());
  parts_.stops.push_in_order(heir);
}

}  // namespace mbgate::bus
