// SPDX-License-Identifier: Apache-2.0
// The entry points of a bus: bytes and time come in, the line comes and goes, everything ends.
#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

// What may still be owed must come first: to somebody else's requests on a port that is
// new to the gateway, so long as it listens for these, and to its own.
Instant listen_until(const Parts& parts, Instant first_until, Instant now) {
  Instant until = std::max(first_until, now);
  for (const DeviceEntry& entry : parts.devices.entries()) {
    until = std::max(until, entry.hold.until(entry.in_force()));
  }
  return until;
}

}  // namespace

void Bus::update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now) {
  diagnosis_.note_other_devices(parts_.update(settings, devices));
  ends_.end_repeats();
  dispatch_.pump(now);
}

void Bus::handle_opened(Instant now, LineKind kind) {
  parts_.link.note_opened(now);
  parts_.adapter.open(kind, now);
  parts_.devices.forget_what_was_read();
  parts_.acknowledged.forget_all();
  diagnosis_.note_opened();
  if (!listens_first_until_) {
    listens_first_until_ = now + parts_.settings.listen_first.value_or(default_listen_first(
                                     parts_.settings, parts_.devices.devices()));
  }
  parts_.line.open(now, kind, listen_until(parts_, *listens_first_until_, now));
  dispatch_.pump(now);
}

void Bus::take_over(Bus& before, Instant now) {
  before.outcomes_.note_lost(now);
  listens_first_until_ = before.listens_first_until_;
  parts_.line.take_over(before.parts_.line);
  parts_.devices.take_over(before.parts_.devices);
}

void Bus::handle_lost(Instant now, Loss loss) {
  LinkState& link = parts_.link;
  LineDiscipline& line = parts_.line;
  if (link.is_resting()) {
    return;  // nobody has asked for a line
  }
  const bool in_order =
      line.use().has_answered() || (!line.use().was_asked() && !link.is_new(parts_.settings, now));
  if (loss == Loss::closed && link.is_open() && in_order) {
    line.note_closed(now);
    dispatch_.rest(now);
    return;
  }
  parts_.counters.losses += link.serves() ? 1U : 0U;
  outcomes_.note_lost(now);
  line.abort();
  dispatch_.forget_look();
  link.note_lost(parts_.settings, now);
  if (parts_.stopping) {
    link.stop();
  } else {
    outcomes_.handle_cut_stops(now);
  }
  ends_.end_running(Ending::closed);
  ends_.end_waiting(Ending::closed);
  if (parts_.stopping) {
    ends_.end_stops(Ending::closed);
  }
  dispatch_.pump(now);
}

void Bus::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (!parts_.link.is_open()) {
    return;
  }
  parts_.adapter.note_byte(now);
  const bool asked = parts_.transmissions.first_in_flight() != nullptr;
  parts_.line.handle_bytes(bytes, now);
  diagnosis_.note_bytes(asked, now);
  collect(now);
  dispatch_.pump(now);
}

void Bus::note_unsent(std::size_t bytes) {
  if (SerialDiscipline* serial = parts_.line.serial()) {
    serial->note_unsent(bytes);
  }
}

void Bus::handle_looked(Instant now) {
  if (SerialDiscipline* serial = parts_.line.serial(); serial != nullptr && parts_.link.is_open()) {
    serial->handle_looked(now);
    collect(now);
  }
  dispatch_.pump_looked(now);
}

void Bus::handle_deadline(Instant now) {
  if (parts_.link.take_due(now)) {
    parts_.actions.push(OpenLine{});
  }
  if (parts_.link.is_open()) {
    parts_.line.handle_deadline(now);
    collect(now);
  }
  dispatch_.pump_looked(now);
}

// What the line discipline has found, in the order in which it came.
void Bus::collect(Instant now) {
  const auto diagnose_others = [this] {
    while (const auto unsolicited = parts_.line.take_unsolicited()) {
      diagnosis_.note_unsolicited(*unsolicited);
    }
  };
  diagnose_others();
  while (const auto end = parts_.line.take_end(now)) {
    outcomes_.handle_end(*end, now);
    diagnose_others();
  }
  while (const auto fault = parts_.line.take_fault()) {
    // The far end takes what is sent, and says nothing, or nothing that can be followed.
    const bool is_useless = fault == LineFault::unanswered || fault == LineFault::answer_cut_off;
    if (fault != LineFault::framing_lost &&
        (fault != LineFault::unanswered || diagnosis_.note_unanswered_connection())) {
      parts_.actions.push(LineNotice{*fault});
    }
    if (is_useless) {
      ++parts_.counters.losses;
      parts_.actions.push(CloseLine{});
      dispatch_.rest(now);
    } else if (fault == LineFault::framing_lost || fault == LineFault::driver_stalled) {
      // What the driver still holds is dropped with the line: it must not leave later.
      parts_.actions.push(CloseLine{});
      handle_lost(now);
    }
  }
}

void Bus::withdraw(Job& job) {
  parts_.queue.remove(job);
  ends_.release(job);
  dispatch_.wake_at_once();  // what waited behind it may go now
}

void Bus::abandon(Job& job) {
  job.abandoned = true;
  if (!job.sent.in_flight) {
    dispatch_.wake_at_once();  // it ends, and what waited for it may go now
  }
}

void Bus::stop(Instant now) {
  parts_.stopping = true;
  parts_.link.stop();
  ends_.end_waiting(Ending::cancelled);
  dispatch_.pump(now);
}

void Bus::give_up(Instant now) {
  parts_.line.abort();
  ends_.end_running(Ending::no_answer);
  ends_.end_waiting(Ending::cancelled);
  ends_.end_stops(Ending::cancelled);
  dispatch_.pump(now);
}

std::optional<Wake> Bus::next_wake() const {
  Wake first = dispatch_.next_wake().value_or(Wake{Instant::max()});
  const auto take = [&first](const std::optional<Instant>& at) {
    first = at && !is_before(first, {*at}) ? Wake{*at} : first;
  };
  take(parts_.link.next_attempt());
  take(parts_.queue.first_deadline());
  if (parts_.link.is_open()) {
    take(parts_.line.next_deadline());
  }
  return first.at < Instant::max() ? std::optional(first) : std::nullopt;
}

void Bus::clear_counters() {
  parts_.counters = {};
  parts_.devices.clear_counters();
  diagnosis_.clear_counters();
}

}  // namespace mbgate::bus
