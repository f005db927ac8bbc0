// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/dispatch.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

// For how long the line was what the job waited for, and not its device, which boots or may still
// send a late answer.
Duration waited_for_line(const Parts& parts, const Job& job, Instant now) {
  return now - std::clamp(held_until(parts, job), job.accepted_at, now);
}

}  // namespace

void Dispatch::pump_looked(Instant now) {
  looking_ = Looking::done;
  pump(now);
  looking_ = Looking::no;
}

void Dispatch::pump(Instant now) {
  decide(now);
  const bool is_busy = parts_.transmissions.first_in_flight() != nullptr;
  if (LineLoad& load = diagnosis_.load(); is_busy != load.is_busy()) {
    load.note(is_busy, now, parts_.line.ready_at(Duration{0}));
  }
}

void Dispatch::decide(Instant now) {
  parts_.pumped_at = now;
  next_wake_.reset();
  parts_.stops.wake(now);
  ends_.expire(now);
  ends_.end_over(now);
  watch_deadlines(now);
  if (!parts_.link.is_open() || reopen_if_hung(now)) {
    wait_for_line(now);
    return;
  }
  go_on_with_stops();
  Next next = scheduler_.next(now);
  while (carry_out(next, now)) {
    next = scheduler_.next(now);
  }
  wait_for(next.at);
  limit_waits(now);
}

// False: nothing more can be done now.
bool Dispatch::carry_out(const Next& next, Instant now) {
  switch (next.step) {
    case Next::Step::wait: return false;
    case Next::Step::transmit:
      if (!has_looked()) {
        return false;
      }
      begin(*next.job, now);
      return true;
    case Next::Step::cancel:
      parts_.stops.remove(*next.job);
      ends_.finish(*next.job, Ending::cancelled);
      return true;
    case Next::Step::give_up:
      parts_.stops.remove(*next.job);
      outcomes_.give_up_stop(*next.job, now);
      return true;
  }
  return false;
}

// Nothing is transmitted before what already lies in the line was looked at: it may be the answer
// to an earlier request, or show that the line is not silent.
bool Dispatch::has_looked() {
  if (looking_ == Looking::no) {
    looking_ = Looking::asked;
    parts_.actions.push(LookAtLine{});
  }
  return looking_ == Looking::done;
}

void Dispatch::begin(Job& job, Instant now) {
  if (job.is_stop()) {
    if (parts_.line.ready_for_stop_at() > now) {
      diagnosis_.notify(DeviceNotice::Kind::stop_forced, job.address());
    }
    parts_.stops.remove(job);
    parts_.transmissions.start(job);
  } else if (job.is_waiting()) {
    if (!parts_.devices[job.address()].health.is_offline()) {
      diagnosis_.load().note_wait(waited_for_line(parts_, job, now), now);
    }
    parts_.queue.take(job);
    parts_.transmissions.start(job);
  }
  transmit(job, now);
}

// Only between transmissions, so that nothing on the wire is cut; what waits, and what is repeated,
// stops too, goes on once the line is open.
bool Dispatch::reopen_if_hung(Instant now) {
  if (parts_.stopping || parts_.transmissions.first_in_flight() != nullptr ||
      !parts_.adapter.is_hung(parts_.settings, now)) {
    return false;
  }
  parts_.link.restart(now);
  forget_look();
  const ReopenLine reopen{parts_.adapter.silence(now), parts_.adapter.requests(),
                          parts_.adapter.note_reopening()};
  parts_.actions.push(reopen);
  return true;
}

void Dispatch::rest(Instant now) {
  parts_.link.rest(parts_.settings, parts_.line.use().has_answered(), now);
  forget_look();
  outcomes_.note_lost(now);
  parts_.line.abort();
  outcomes_.handle_cut(now);
  pump(now);
}

// What a close has cut, and what is repeated, waits for the line. A stop has it opened at once.
void Dispatch::wait_for_line(Instant now) {
  const bool is_wanted =
      !parts_.transmissions.running().empty() || parts_.queue.size() > 0 || !parts_.stops.empty();
  if (parts_.link.is_resting() && is_wanted) {
    parts_.link.wake(now);
    parts_.actions.push(OpenLine{});
  }
  if (parts_.link.is_open()) {
    return;
  }
  // Of the time for which a stop has waited, that counts in which the line was not open.
  const auto deadline_of = [&](const Job& stop) {
    return std::max(stop.sent.waits_since, parts_.link.left_at()) + stop_deadline(parts_.settings);
  };
  while (Job* stop = parts_.stops.find([&](const Job& it) {
    return (parts_.stopping && parts_.link.is_closed()) || now >= deadline_of(it);
  })) {
    parts_.stops.remove(*stop);
    ends_.finish(*stop, Ending::closed);
  }
  parts_.stops.visit([&](const Job& stop) { wait_for(wake_at(deadline_of(stop))); });
  if (!parts_.stops.empty()) {
    parts_.link.hurry(parts_.settings, now);
  }
}

void Dispatch::watch_deadlines(Instant now) {
  wait_for(wake_at(parts_.stops.next_wake()));
  parts_.stops.visit([&](const Job& stop) {
    if (const Instant held = held_until(parts_, stop); held > now) {
      wait_for(wake_at(held));
    }
  });
  for (const Job* running : parts_.transmissions.running()) {
    if (running->sent.in_flight || running->is_stop()) {
      continue;
    }
    wait_for(wake_at(running->deadline > now ? running->deadline : running->ends_at(*running)));
    for (const Job* follower : running->sent.followers) {
      wait_for(wake_at(running->ends_at(*follower)));
    }
  }
}

// Of several transmissions, or forms, each goes like the first, and no other stop between them.
void Dispatch::go_on_with_stops() {
  const auto next_part = [this] {
    const auto running = parts_.transmissions.running();
    const auto found = std::ranges::find_if(
        running, [](const Job* it) { return it->is_stop() && !it->sent.in_flight; });
    return found == running.end() ? nullptr : *found;
  };
  while (Job* stop = next_part()) {
    parts_.transmissions.leave(*stop);
    parts_.stops.push_front(*stop);
  }
}

// What is in the way of a stop has its time for an answer, and no more. Where identifiers tell
// answers apart that is another stop to the same drive, and its answer hinders nobody.
void Dispatch::limit_waits(Instant now) {
  if (!parts_.quarantines()) {
    return;
  }
  parts_.stops.visit([&](const Job& stop) {
    const Job* other = in_the_way_of(parts_, stop);
    if (other != nullptr && may_cut(parts_, stop, now)) {
      parts_.line.limit_wait(other->transaction(), time_before_stop(parts_, other->transaction()));
    }
  });
}

}  // namespace mbgate::bus
