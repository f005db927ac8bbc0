// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/dispatch.hpp"

#include <algorithm>
#include <functional>

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
  next_start_.reset();
  parts_.stops.wake(now);
  ends_.expire(now);
  ends_.end_over(now);
  watch_deadlines(now);
  if (!parts_.link.is_open() || reopen_if_hung(now)) {
    wait_for_line(now);
    return;
  }
  if (serve_stops(now)) {
    return;
  }
  continue_running(now);
  while (has_place(parts_, now)) {
    const auto choice = next_turn(parts_, Passing::nothing, now);
    if (!choice) {
      return;
    }
    if (choice->at > now) {
      wait_until(wake_for(parts_, *choice->job, choice->at));
      return;
    }
    if (!has_looked()) {
      return;
    }
    begin(*choice, now);
  }
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

Transmission& Dispatch::begin(const Choice& choice, Instant now) {
  Job& job = *choice.job;
  if (choice.passed_over != nullptr) {
    choice.passed_over->passed_over = true;
  }
  if (job.is_waiting()) {
    if (!parts_.devices[job.address()].health.is_offline()) {
      diagnosis_.load().note_wait(waited_for_line(parts_, job, now), now);
    }
    parts_.queue.take(job);
    parts_.transmissions.start(parts_.transmissions.lead(job));
  }
  transmit(*job.leads, now);
  return *job.leads;
}

// Goes on with jobs of several transactions.
void Dispatch::continue_running(Instant now) {
  for (Transmission* running : parts_.transmissions.running()) {
    const Job& job = *running->leader;
    if (!parts_.transmissions.may_go_on(*running)) {
      continue;
    }
    const Instant ready = ready_at(parts_, job);
    if (running->is_between_tries() && !is_held_back(parts_, job, now)) {
      continue;  // next_turn() has it
    }
    if (now < ready) {
      wait_until(wake_for(parts_, job, ready));
    } else if (parts_.transmissions.has_room() && has_looked()) {
      transmit(*running, now);
    }
  }
}

// Only between transmissions, so that nothing on the wire is cut; what waits, and what is repeated,
// stops too, goes on once the line is open.
bool Dispatch::reopen_if_hung(Instant now) {
  if (parts_.stopping || parts_.transmissions.first_in_flight() != nullptr ||
      !parts_.adapter.is_hung(parts_.settings, now)) {
    return false;
  }
  parts_.link.restart();
  forget_look();
  const ReopenLine reopen{parts_.adapter.silence(now), parts_.adapter.requests(),
                          parts_.adapter.note_reopening()};
  parts_.actions.push(reopen);
  return true;
}

void Dispatch::rest(Instant now) {
  parts_.link.rest(parts_.settings, parts_.line.use().has_answered());
  forget_look();
  parts_.line.abort();
  outcomes_.handle_cut(now);
  pump(now);
}

// What a close has cut, and what is repeated, waits for the line. A stop has it opened at once.
void Dispatch::wait_for_line(Instant now) {
  const bool is_wanted =
      !parts_.transmissions.running().empty() || parts_.queue.size() > 0 || !parts_.stops.empty();
  if (parts_.link.is_resting() && is_wanted) {
    parts_.link.wake();
    parts_.actions.push(OpenLine{});
  }
  if (!parts_.link.is_closed()) {
    return;
  }
  const Duration deadline = stop_deadline(parts_.settings);
  while (Transmission* stop = parts_.stops.find([&](const Transmission& it) {
    return parts_.stopping || now >= it.waits_since + deadline;
  })) {
    parts_.stops.remove(*stop);
    ends_.finish(*stop, Ending::closed);
  }
  parts_.stops.visit(
      [&](const Transmission& stop) { wait_until(Wake{stop.waits_since + deadline}); });
  if (!parts_.stops.empty()) {
    parts_.link.hurry(parts_.settings, now);
  }
}

// Of what is neither in the queue nor on the wire, whatever keeps it waiting.
void Dispatch::watch_deadlines(Instant now) {
  if (const auto next = parts_.stops.next_wake()) {
    wait_until(Wake{*next});
  }
  parts_.stops.visit([&](const Transmission& stop) {
    if (const Instant held = held_until(parts_, stop); held > now) {
      wait_until(Wake{held});
    }
  });
  for (const Transmission* running : parts_.transmissions.running()) {
    if (running->in_flight || running->is_stop()) {
      continue;
    }
    wait_until(Wake{running->leader->deadline});
    for (const Job* follower : running->followers) {
      wait_until(Wake{follower->deadline});
    }
  }
}

// True: nothing else may begin now.
bool Dispatch::serve_stops(Instant now) {
  go_on_with_stops(now);
  if (!send_stops(now)) {
    return true;
  }
  parts_.stops.visit([&](const Transmission& stop) {
    const Transmission* other = in_the_way_of(parts_, *stop.leader);
    if (other != nullptr && !waits_patiently(parts_, stop, now)) {
      parts_.line.limit_wait(other->on_wire(), time_before_stop(parts_, other->on_wire()));
    }
  });
  return false;
}

// Of several transmissions, or forms, each goes like the first, and no other stop between them.
void Dispatch::go_on_with_stops(Instant now) {
  const auto next_part = [this] {
    const auto running = parts_.transmissions.running();
    const auto found = std::ranges::find_if(
        running, [](const Transmission* it) { return it->is_stop() && !it->in_flight; });
    return found == running.end() ? nullptr : *found;
  };
  while (Transmission* stop = next_part()) {
    stop->waits_since = now;
    parts_.transmissions.leave(*stop);
    parts_.stops.push_front(*stop);
  }
}

// Those that can go. False: nothing else may begin now, because one of them waits for silence.
bool Dispatch::send_stops(Instant now) {
  while (const auto choice = choose_stop(parts_, now)) {
    const auto& before = choice->before;
    if (before && before->at > now) {
      wait_until(wake_for(parts_, *before->job, before->at));
      return false;
    }
    if (before && !has_looked()) {
      return false;
    }
    if (before) {
      begin(*before, now);
    } else if (!send_stop(*choice->stop, now)) {
      return false;
    }
  }
  return true;
}

// True: it is on its way, or ended. False: not yet, because the line is not silent. Where it never
// is, there is nothing to lose: the stop is transmitted all the same, but not repeated so.
bool Dispatch::send_stop(Transmission& stop, Instant now) {
  if (stop.is_abandoned()) {
    parts_.stops.remove(stop);
    ends_.finish(stop, Ending::cancelled);
    return true;
  }
  const Instant silent_at = parts_.line.ready_for_stop_at();
  if (silent_at > now) {
    const Instant overdue_at = std::max(stop_overdue_at(parts_, stop), parts_.line.possible_at());
    if (overdue_at > now) {
      wait_until(Wake{std::min(silent_at, overdue_at), silent_at <= overdue_at});
      return false;
    }
    if (stop.tries > 0) {
      parts_.stops.remove(stop);
      outcomes_.give_up_stop(stop, now);
      return true;
    }
  }
  if (!has_looked()) {
    return false;
  }
  if (silent_at > now) {
    diagnosis_.notify(DeviceNotice::Kind::stop_forced, stop.leader->address());
  }
  parts_.stops.remove(stop);
  parts_.transmissions.start(stop);
  transmit(stop, now);
  return true;
}

}  // namespace mbgate::bus
