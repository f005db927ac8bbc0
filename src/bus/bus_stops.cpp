// SPDX-License-Identifier: Apache-2.0
// Stops: they go next, take back what they stop, and are repeated until they are acknowledged.
#include <algorithm>
#include <functional>

#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

// Is it one of those that a stop with `stop_cancels = false` lets go first? A broadcast is a write
// to every device.
bool goes_before(const Job& write, const Job& stop) {
  return write.job_class == JobClass::write && write.sequence < stop.sequence &&
         (write.is_broadcast() || write.address() == stop.address());
}

}  // namespace

// Writes to the same device that were accepted before it and are not on the wire are never
// transmitted; of one that is, no further part is. `let_go_first`: even those that it let go first.
void Bus::overtake_writes(const Job& stop, bool let_go_first) {
  const auto is_overtaken = [&](const Job& job) {
    return let_go_first ? goes_before(job, stop) : is_stopped_by(stop, job);
  };
  std::vector<Job*> overtaken;
  queue_.visit_all([&](Job& job) {
    if (is_overtaken(job)) {
      overtaken.push_back(&job);
    }
  });
  for (Job* job : overtaken) {
    queue_.remove(*job);
    end_job(*job, Ending::cancelled);
  }
  counters_.overtaken_writes += overtaken.size();
  for (Job* job : running_) {
    job->overtaken = job->overtaken || is_overtaken(*job);
  }
}

void Bus::overtake_writes() {
  queue_.visit_stops([this](const Job& stop) { overtake_writes(stop); });
}

bool Bus::is_stopped_by(const Job& stop, const Job& write) const {
  if (write.job_class != JobClass::write || write.sequence > stop.sequence) {
    return false;
  }
  const auto stops_device = [&](const drive::Device& device) {
    const auto reaches = [&](const Transaction& transaction) {
      return transaction.is_broadcast() ? transaction.broadcast == device.profile.broadcast.form
                                        : transaction.address == device.address;
    };
    const bool stopped = std::ranges::any_of(stop.transactions, [&](const Transaction& it) {
      return reaches(it) && (!it.is_broadcast() || device.is_stop(it.request));
    });
    // A broadcast waits for nobody's writes.
    return stopped && (device.stop_cancels || stop.is_broadcast()) &&
           std::ranges::any_of(write.transactions, reaches);
  };
  return std::ranges::any_of(devices_.devices(), stops_device);
}

// With `stop_cancels = false` the writes that were accepted before it go first.
bool Bus::lets_writes_go(const Job& stop) const {
  return !stop.is_broadcast() && !devices_[stop.address()].device->stop_cancels;
}

bool Bus::must_let_writes_go(const Job& stop) const {
  return lets_writes_go(stop) && (queue_.write_waits_before(stop.address(), stop.sequence) ||
                                  std::ranges::any_of(running_, [&](const Job* job) {
                                    return !job->in_flight && goes_before(*job, stop);
                                  }));
}

// When the next transmission for those writes may begin; nothing: not before others of other
// devices.
std::optional<Instant> Bus::next_before(const Job& stop, Instant now) {
  const auto running = std::ranges::find_if(running_, [&](const Job* job) {
    return job->address() == stop.address() || job->is_broadcast();
  });
  if (running != running_.end()) {
    return ready_at(**running);
  }
  const auto choice = choose({&stop}, now);
  return choice ? std::optional(ready_at(*choice->job)) : std::nullopt;
}

// For how long the stop, which could go itself, waits for what may begin then.
Duration Bus::held_by(const Job& stop, Instant ready) const {
  return std::max(ready - std::max(stop.waits_since, line_.ready_for_stop_at()), Duration{0});
}

// What keeps it, or the writes that it lets go first, from being transmitted. On a connection
// others may be on their way, but never to a device that has a write outstanding, nor a write to
// one that has a read outstanding; where all places are taken, the one that has had its place for
// longest.
Job* Bus::in_the_way_of(const Job& stop) const {
  const bool write_goes_first = must_let_writes_go(stop);
  const auto occupies_device = [&](const Job* job) {
    return job->in_flight && job->address() == stop.address() &&
           (write_goes_first || job->job_class != JobClass::read);
  };
  const auto occupying = std::ranges::find_if(running_, occupies_device);
  if (occupying != running_.end()) {
    return *occupying;
  }
  const auto oldest = std::ranges::find_if(running_, [](const Job* job) { return job->in_flight; });
  return in_flight() < most_running_ ? nullptr : *oldest;
}

// A write that is let go first has the line as the stop itself would, and as much time for its
// answer as any running transaction; but while such writes are held back (quarantine, `gap`, boot
// time, `settle`) they hold the stop for `stop_wait` at most, all together. If the next one cannot
// begin in that time, all that wait are taken back at once: they must not follow the stop. So are
// they where the line is never silent, and the stop's deadline is over.
void Bus::take_back_held_writes(Instant now) {
  const Job* stop = queue_.first_stop();
  if (stop == nullptr || !must_let_writes_go(*stop) || in_the_way_of(*stop) != nullptr) {
    return;
  }
  const auto next = next_before(*stop, now);
  if (!next || now >= stop_overdue_at(*stop) ||
      stop->held_by_writes + held_by(*stop, *next) > settings_.stop_wait) {
    overtake_writes(*stop, true);
    end_over(now);
  }
}

// Those that can go. False: nothing else may begin now, because one of them waits for silence.
bool Bus::send_stops(Instant now) {
  const auto can_go = [this](const Job& stop) {
    return !must_let_writes_go(stop) && in_the_way_of(stop) == nullptr;
  };
  const auto is_new = [&](const Job& stop) { return can_go(stop) && !gives_way(stop, now); };
  const auto goes_first = [&](const Job& stop) {
    return is_new(stop) || (can_go(stop) && was_passed(stop));
  };
  for (;;) {
    const bool others_wait = queue_.find_stop(is_new) != nullptr;
    Job* stop = others_wait ? queue_.find_stop(goes_first) : queue_.find_stop(can_go);
    if (stop == nullptr) {
      return true;
    }
    const auto turn = !others_wait ? turn_before(*stop, now) : std::nullopt;
    if (turn && turn->at > now) {
      next_start_ = earlier(next_start_, Wake{turn->at, held_until(*turn->job) < turn->at});
      return false;
    }
    if (turn && !has_looked()) {
      return false;
    }
    if (turn) {
      begin(*turn, now);
      let_by_ = turn->job;
    } else if (!transmit_stop(*stop, now)) {
      return false;
    }
  }
}

// The stop that waits for the line: before all others one that cuts what runs, and before those
// that let writes go first one that does not.
Job* Bus::next_stop() {
  const auto may_go = [this](const Job& stop) { return !must_let_writes_go(stop); };
  const auto cuts = [&](const Job& stop) { return may_go(stop) && !waits_patiently(stop); };
  Job* stop = queue_.find_stop(cuts);
  stop = stop != nullptr ? stop : queue_.find_stop(may_go);
  return stop != nullptr ? stop : queue_.first_stop();
}

// Of several transmissions, or forms, each goes like the first, and no other stop between them.
void Bus::go_on_with_stops(Instant now) {
  const auto is_between_parts = [](const Job* job) {
    return job->job_class == JobClass::stop && !job->in_flight;
  };
  const auto parts = std::ranges::stable_partition(running_, std::not_fn(is_between_parts));
  for (Job* job : parts) {
    job->waits_since = now;
    queue_.push_stop_front(*job);
  }
  running_.erase(parts.begin(), parts.end());
}

// True: nothing else may begin now. False: no stop waits, or only such as let writes go first, and
// nothing but these may begin.
bool Bus::serve_stops(Instant now) {
  go_on_with_stops(now);
  take_back_held_writes(now);
  if (!send_stops(now)) {
    return true;
  }
  const Job* stop = next_stop();
  Job* other = stop != nullptr ? in_the_way_of(*stop) : nullptr;
  if (other != nullptr && !waits_patiently(*stop)) {
    const bool has_own_time = other->job_class == JobClass::stop || other == let_by_ ||
                              (lets_writes_go(*stop) && goes_before(*other, *stop));
    line_.limit_wait(other->on_wire(), stop->waits_since + settings_.stop_wait,
                     has_own_time ? settings_.stop_wait : Duration{0});
  }
  return other != nullptr;
}

// True: it is on its way, or ended. False: not yet, because the line is not silent. Where it never
// is, there is nothing to lose: the stop is transmitted all the same, but not repeated so.
bool Bus::transmit_stop(Job& stop, Instant now) {
  const Instant silent_at = line_.ready_for_stop_at();
  if (silent_at > now) {
    const Instant overdue_at = std::max(stop_overdue_at(stop), line_.possible_at());
    if (overdue_at > now) {
      next_start_ =
          earlier(next_start_, Wake{std::min(silent_at, overdue_at), silent_at <= overdue_at});
      return false;
    }
    if (stop.tries > 0) {
      queue_.remove(stop);
      part_from_untried(stop);
      give_up_stop(stop);
      return true;
    }
  }
  if (!has_looked()) {
    return false;
  }
  if (silent_at > now) {
    notify(DeviceNotice::Kind::stop_forced, stop.address());
  }
  queue_.take(stop);
  running_.push_back(&stop);
  transmit(stop, now);
  return true;
}

// Only the time in which an open line is not silent counts.
Instant Bus::stop_overdue_at(const Job& stop) const {
  const auto busy_since = line_.busy_since();
  return busy_since ? std::max(stop.waits_since, *busy_since) + stop_deadline(settings_)
                    : Instant::max();
}

void Bus::handle_stop_failure(Job& stop, Instant now) {
  DeviceEntry& entry = devices_[stop.on_wire().address];
  // What its owner sends as a stop, but is none, may not be harmless if it is done twice.
  const Transaction& sent = stop.transaction();
  const bool may_repeat = devices_.is_stop(sent.address, sent.request, sent.broadcast);
  const bool is_given_up = stop.is_one_try && entry.stops_given_up;
  if (may_repeat && !is_given_up && stop.tries <= entry.timing().stop_retries) {
    repeat_stop(stop, now);
    return;
  }
  entry.stops_given_up = entry.last_stop_turn != 0 && (may_repeat || entry.stops_given_up);
  give_up_stop(stop);
}

// It goes behind other stops that wait, so that a dead device does not keep them waiting.
void Bus::repeat_stop(Job& stop, Instant now) {
  std::erase(running_, &stop);
  stop.waits_since = now;
  queue_.push_again(stop);
}

// Those that joined it after its last transmission are still to be transmitted once.
void Bus::part_from_untried(Job& stop) {
  const auto untried = std::ranges::stable_partition(stop.followers, &Job::was_on_wire);
  if (untried.empty()) {
    return;
  }
  Job& heir = *untried.front();
  heir.followers.assign(untried.begin() + 1, untried.end());
  stop.followers.erase(untried.begin(), untried.end());
  queue_.push_again(heir);
}

void Bus::give_up_stop(Job& stop) {
  ++counters_.stops_unanswered;
  notify(DeviceNotice::Kind::stop_unanswered, stop.on_wire().address);
  finish(stop, Ending::no_answer);
}

}  // namespace mbgate::bus
