// SPDX-License-Identifier: Apache-2.0
// Good frames that answer nothing that is asked: late answers, other clients, echoes.
#include <algorithm>
#include <utility>

#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

// Another client may have asked for the same a moment before, and an adapter kept that; hardly for
// two requests in a row.
constexpr unsigned kEchoesToTell = 2;

}  // namespace

// A good frame came that answers nothing that is asked now.
void Bus::handle_unsolicited(const UnsolicitedFrame& unsolicited) {
  const std::uint8_t address = unsolicited.address;
  DeviceEntry& entry = devices_[address];
  frame_heard_ = true;
  if (unsolicited.is_echo) {
    return;
  }
  const auto late =
      unsolicited.is_response
          ? entry.health.note_unexpected(unsolicited.pdu.bytes(), unsolicited.came, entry.timing())
          : std::optional<DeviceHealth::Late>();
  if (!late) {
    note_foreign(unsolicited);
    return;
  }
  ++counters_.late_responses;
  ++entry.counters.late_responses;
  entry.note_heard();
  if (late->grew) {
    actions_.push(DeviceNotice{DeviceNotice::Kind::late, address, late->lateness,
                               entry.health.quarantine(unsolicited.came, entry.timing())});
  }
  if (late->back) {
    notify(DeviceNotice::Kind::back, address);
    quality_[address].note_heard();  // it was asked by probes only: no matter of its timeout
  } else if (late->lateness > Duration{0}) {  // else what stood before it was in its way
    quality_[address].note_late(late->lateness, entry.timing().response_timeout);
    tell_quality(address);
  }
}

// A request that somebody else sent, or a frame of a device that has owed nothing for so long that
// it can be no late answer: another client is on this line, or another device at this address. What
// a line had in store when it was opened says nothing.
void Bus::note_foreign(const UnsolicitedFrame& unsolicited) {
  const Instant now = unsolicited.came;
  const std::uint8_t address = unsolicited.address;
  DeviceEntry& entry = devices_[address];
  const Duration longest = entry.timing().quarantine_max;
  const auto asked = std::ranges::find_if(
      running_, [&](Job* job) { return job->in_flight && job->on_wire().address == address; });
  const bool is_asked = asked != running_.end();
  const bool is_own = is_asked && std::ranges::equal((*asked)->on_wire().request.pdu().bytes(),
                                                     unsolicited.pdu.bytes());
  if (is_own && unsolicited.is_request && !std::exchange(own_heard_, true)) {
    note_denied_echo(true);
  }
  if (unsolicited.after_noise || is_own || now < link_.opened_at() + longest) {
    return;
  }
  const bool is_old = entry.owed_until == Instant::min() || now > entry.owed_until + longest;
  if (!unsolicited.is_request && (!unsolicited.is_response || is_asked || !is_old)) {
    return;
  }
  const bool answered_just_now = unsolicited.is_response && entry.answered_at != Instant::min() &&
                                 now <= entry.answered_at + entry.timing().response_timeout &&
                                 unsolicited.pdu.function() == entry.answered_function;
  if (answered_just_now && !foreign_reported_) {
    if (!std::exchange(entry.second_reported, true)) {
      notify(DeviceNotice::Kind::second_answer, address);
    }
    return;
  }
  ++counters_.foreign_frames;
  if (!std::exchange(foreign_reported_, true)) {
    DeviceNotice notice{DeviceNotice::Kind::foreign, address};
    notice.is_request = unsolicited.is_request;
    actions_.push(notice);
  }
}

// Was the own request heard, though the settings say that there is no echo? Told once.
void Bus::note_denied_echo(bool was_heard) {
  if (settings_.line.echo != false || denied_echoes_ == kEchoesToTell) {
    return;
  }
  denied_echoes_ = was_heard ? denied_echoes_ + 1 : 0;
  if (denied_echoes_ == kEchoesToTell) {
    actions_.push(LineNotice{LineFault::echo_denied});
  }
}

}  // namespace mbgate::bus
