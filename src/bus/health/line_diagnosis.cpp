// SPDX-License-Identifier: Apache-2.0
#include "bus/health/line_diagnosis.hpp"

#include <algorithm>
#include <utility>

#include "modbus/codes.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

constexpr Duration kNeverSilent = 1s;
constexpr Duration kLongOffline = 10s;
constexpr std::size_t kLeastHeard = 3;  // fewer bytes are a driver that turns off

/// Is it what the device is asked now?
bool is_own(const Parts& parts, const UnsolicitedFrame& unsolicited) {
  const Job* asked = parts.transmissions.in_flight_to(unsolicited.address);
  return asked != nullptr && asked->transaction().request.pdu() == unsolicited.pdu;
}

// On a serial line a drive that limits values acknowledges a write by its address alone: the frame
// is the echo of the oldest such write, unless that is an earlier try of what it is asked now.
UnsolicitedFrame as_plain_echo(Parts& parts, const UnsolicitedFrame& frame) {
  const Job* asked = parts.transmissions.in_flight_to(frame.address);
  const DeviceEntry& entry = parts.devices[frame.address];
  const auto* const write = entry.hold.oldest_that([&](const modbus::Request& it) {
    return entry.device->takes_limited(it, frame.pdu.bytes());
  });
  UnsolicitedFrame plain = frame;
  plain.pdu = write == nullptr ? frame.pdu : write->pdu();
  const bool is_own_try = is_own(parts, plain) && asked->sent.tries > 1 && !asked->is_stop();
  return is_own_try || parts.line.serial() == nullptr ? frame : plain;
}

}  // namespace

constinit const std::array<Duration, 16> kSilenceBounds = {
    500us, 1ms, 1500us, 1750us, 2ms,  2500us, 3ms,   4ms,
    5ms,   7ms, 10ms,   20ms,   50ms, 100ms,  500ms, 1s};

void LineDiagnosis::note_opened() {
  foreign_reported_ = false;
  last_never_silent_ = Instant::min();
  denied_echo_ = {};  // it may be another adapter
  never_silent_reported_ = false;
  quality_.forget();
}

// A line that is never silent is told once until somebody is understood again.
void LineDiagnosis::note_bytes(bool asked, Instant now) {
  const Duration limit = std::max(kNeverSilent, longest_stream(parts_.settings));
  const LineSilence* silence = parts_.line.silence();
  if (silence != nullptr && now >= silence->busy_since() + limit) {
    last_never_silent_ = now;
    if (!std::exchange(never_silent_reported_, true)) {
      parts_.actions.push(NeverSilent{});
    }
  }
  if (!asked) {
    quality_.note_unasked();
  }
}

void LineDiagnosis::note_begins(Instant now) {
  frame_heard_ = false;
  if (const LineSilence* silence = parts_.line.silence()) {
    silences_.note(std::max(now - silence->quiet_since(), Duration{0}));
  }
}

void LineDiagnosis::note_ended(const Asked& asked, const LineEnd& end, Instant now) {
  const Instant free_at = std::max(now, parts_.line.ready_at(Duration{0}));
  parts_.devices[asked.address].counters.wire_time += std::max(free_at - asked.sent, Duration{0});
  denied_echo_.note_ended(end.how == LineEnd::How::response && asked.is_read);
  const bool heard_frame = std::exchange(frame_heard_, false);
  note_silence(asked, now);
  if (!asked.wants_answer) {
    return;
  }
  AnswerQuality& quality = quality_[asked.address];
  switch (asked.how) {
    case LineEnd::How::response:
      quality.note_answered();
      quality_.note_answer(false);
      break;
    case LineEnd::How::damaged:
      quality.note_damaged();
      quality_.note_answer(true);
      break;
    case LineEnd::How::misfit:
      quality.note_misfit();
      if (!std::exchange(parts_.devices[asked.address].misfit_reported, true)) {
        notify(DeviceNotice::Kind::misfit, asked.address);
      }
      break;
    case LineEnd::How::no_response:
      if (end.heard >= kLeastHeard && !heard_frame && !end.may_be_echo) {
        quality.note_unreadable(end.heard_after, quality_.unasked());
      } else {
        quality.note_silent();
      }
      break;
    case LineEnd::How::sent: break;
  }
  tell_quality(asked.address);
}

void LineDiagnosis::note_silence(const Asked& asked, Instant now) {
  Silence& silence = parts_.devices[asked.address].silence;
  if (asked.how == LineEnd::How::response) {
    silence.note_answer(now);
  } else if (asked.how == LineEnd::How::damaged || asked.how == LineEnd::How::misfit) {
    silence.note_damaged(now);
  } else if (asked.how == LineEnd::How::no_response && asked.wants_answer) {
    silence.note_unanswered(asked.sent, asked.is_first);
  }
}

// On a connection it is not known which part of the time is the wire's.
void LineDiagnosis::note_times(const Job& job, const LineEnd& end, Instant now) {
  AnswerTimes& times = parts_.devices[job.transaction().address].times;
  const Duration whole = std::max(now - job.sent.last_at, Duration{0});
  const Duration device = end.heard > 0 ? end.heard_after : whole;
  times.device.note(device);
  times.wire.note(whole - device);
  if (job.current == 0 && job.sent.tries == 1) {
    times.queue.note(job.sent.first_at - job.accepted_at);
  }
}

void LineDiagnosis::note_other_devices(const Addresses& addresses) {
  for (std::size_t address = 0; address < addresses.size(); ++address) {
    if (addresses[address]) {
      quality_.forget(static_cast<std::uint8_t>(address));
    }
  }
}

void LineDiagnosis::tell_quality(std::uint8_t address) {
  while (const auto change = quality_.take_change(address)) {
    parts_.actions.push(*change);
  }
}

bool LineDiagnosis::note_heard(std::uint8_t address, Instant now) {
  DeviceHealth& health = parts_.devices[address].health;
  never_silent_reported_ = false;
  const Instant offline_since = health.state_since();
  if (!health.note_heard(now)) {
    return false;
  }
  if (now > offline_since + kLongOffline) {
    parts_.probes.expect_others(now);
  }
  notify(DeviceNotice::Kind::back, address);
  return true;
}

void LineDiagnosis::notify(DeviceNotice::Kind kind, std::uint8_t address) {
  DeviceNotice notice{kind, address};
  notice.answered_before = quality_[address].has_answered();
  notice.transmissions = parts_.devices[address].health.unanswered_in_row();
  if (const auto& stop = parts_.devices[address].failed_stop) {
    notice.exception = stop->exception;
  }
  parts_.actions.push(notice);
}

void LineDiagnosis::note_unsolicited(const UnsolicitedFrame& unsolicited) {
  const std::uint8_t address = unsolicited.address;
  DeviceEntry& entry = parts_.devices[address];
  frame_heard_ = true;
  // Pieces of damaged answers may make a good frame by chance, of an address that nobody asked.
  if (unsolicited.is_echo || parts_.is_unreached(unsolicited.pdu) ||
      (unsolicited.pause > Duration{0} && entry.is_unknown())) {
    return;
  }
  if (unsolicited.pause > Duration{0}) {  // whose answer it was, nobody can tell
    entry.note_heard();
    if (unsolicited.is_response && !std::exchange(entry.pause_reported, true)) {
      parts_.actions.push(DeviceNotice{DeviceNotice::Kind::pauses, address, unsolicited.pause});
    }
    return;
  }
  const UnsolicitedFrame plain = as_plain_echo(parts_, unsolicited);
  const auto late = !unsolicited.is_request
                        ? entry.hold.note_late(plain.pdu.bytes(), plain.came, entry.in_force(),
                                               entry.health.is_offline())
                        : std::optional<Hold::Late>();
  if (!late) {
    if (!note_second_answer(plain) && !note_misfit(unsolicited)) {
      note_foreign(unsolicited);
    }
    return;
  }
  ++parts_.counters.late_responses;
  ++entry.counters.late_responses;
  entry.note_heard();
  entry.silence.note_answer(unsolicited.came);
  if (late->grew) {
    parts_.actions.push(DeviceNotice{DeviceNotice::Kind::late, address, late->lateness,
                                     entry.hold.tail(unsolicited.came, entry.in_force())});
  }
  if (note_heard(address, unsolicited.came)) {
    quality_[address].note_heard();        // it was asked by probes only: no matter of its timeout
  } else if (late->shown > Duration{0}) {  // else what stood before it was in its way
    quality_[address].note_late(late->shown, entry.in_force().response_timeout);
    tell_quality(address);
  }
}

// The device has answered just now. A single one may be an answer to somebody who had the line
// before this gateway.
bool LineDiagnosis::note_second_answer(const UnsolicitedFrame& unsolicited) {
  constexpr unsigned kSure = 3;
  const Instant now = unsolicited.came;
  DeviceEntry& entry = parts_.devices[unsolicited.address];
  const bool is_others = now <= entry.others_at + entry.in_force().response_timeout;
  if (is_others || unsolicited.after_noise || is_own(parts_, unsolicited) ||
      !entry.hold.note_second(unsolicited.pdu.bytes(), now, entry.in_force())) {
    return false;
  }
  entry.second_at = now;
  const bool is_read = modbus::is_read(unsolicited.pdu.bytes());
  entry.second_read_at = echo() == NoticedEcho::found && is_read ? now : entry.second_read_at;
  const bool is_sure = entry.hold.seconds() >= kSure ||
                       now >= parts_.link.opened_at() + entry.in_force().quarantine_max;
  if (is_sure && !std::exchange(entry.second_reported, true)) {
    notify(DeviceNotice::Kind::second_answer, unsolicited.address);
  }
  return true;
}

// It stands in the place of the answer to what the device is asked, and fits in its function alone.
bool LineDiagnosis::note_misfit(const UnsolicitedFrame& unsolicited) {
  SerialDiscipline* line = parts_.line.serial();  // a connection's identifiers tell answers apart
  const Job* asked = parts_.transmissions.in_flight_to(unsolicited.address);
  const std::uint8_t function = unsolicited.pdu.function() & ~modbus::kExceptionBit;
  if (line == nullptr || unsolicited.after_noise || unsolicited.is_request || asked == nullptr ||
      asked->transaction().request.function() != function ||
      unsolicited.came < asked->sent.last_at || is_own(parts_, unsolicited)) {
    return false;
  }
  DeviceEntry& entry = parts_.devices[unsolicited.address];
  entry.note_heard();
  // A stop with another value is none; it may be the late echo of another stop.
  if (!asked->is_stop() &&
      entry.device->takes_limited(asked->transaction().request, unsolicited.pdu.bytes())) {
    line->take_misfit(unsolicited.pdu, std::nullopt);
    return true;
  }
  const Duration longest =
      asked->transaction().request.is_read() ? entry.hold.pace().longest_answer() : Duration{0};
  line->take_misfit(unsolicited.pdu,
                    unsolicited.came + parts_.settings.frame_slack_or_default() + longest);
  return true;
}

// A request that somebody else sent, or a frame of a device that has owed nothing for so long that
// it can be no late answer: another client is on this line, or another device at this address. Just
// after an opening it says nothing; nor on Modbus TCP, where the identifier was this gateway's.
void LineDiagnosis::note_foreign(const UnsolicitedFrame& unsolicited) {
  if (parts_.settings.line.framing == Framing::tcp) {
    return;
  }
  const Instant now = unsolicited.came;
  DeviceEntry& entry = parts_.devices[unsolicited.address];
  const Duration longest = entry.in_force().quarantine_max;
  const bool is_asked = parts_.transmissions.in_flight_to(unsolicited.address) != nullptr;
  const bool is_request_of_now = is_own(parts_, unsolicited);
  entry.others_at = unsolicited.is_request && !is_request_of_now ? now : entry.others_at;
  if (is_request_of_now && unsolicited.is_request && parts_.settings.line.echo == false &&
      denied_echo_.note_heard(now)) {
    parts_.actions.push(LineNotice{LineFault::echo_denied});
  }
  const bool answers_broadcast =
      unsolicited.is_response && parts_.line.silence()->is_in_turnaround(now);
  if (unsolicited.after_noise || is_request_of_now || answers_broadcast ||
      now < parts_.link.opened_at() + longest) {
    return;
  }
  const bool is_old = entry.owed_until == Instant::min() || now > entry.owed_until + longest;
  if (!unsolicited.is_request && (!unsolicited.is_response || is_asked || !is_old)) {
    return;
  }
  ++parts_.counters.foreign_frames;
  last_foreign_ = now;
  last_foreign_request_ = unsolicited.is_request ? now : last_foreign_request_;
  if (!std::exchange(foreign_reported_, true)) {
    DeviceNotice notice{DeviceNotice::Kind::foreign, unsolicited.address};
    notice.is_request = unsolicited.is_request;
    parts_.actions.push(notice);
  }
}

}  // namespace mbgate::bus
