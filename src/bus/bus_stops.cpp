// SPDX-License-Identifier: Apache-2.0
// Stops: they go next, take back what they stop, and are repeated until they are acknowledged.
#include <algorithm>

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
  const auto choice = choose(now);
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
// begin in that time, all that wait are taken back at once: they must not follow the stop.
void Bus::take_back_held_writes(Instant now) {
  const Job* stop = queue_.first_stop();
  if (stop == nullptr || !must_let_writes_go(*stop) || in_the_way_of(*stop) != nullptr) {
    return;
  }
  const auto next = next_before(*stop, now);
  if (!next || stop->held_by_writes + held_by(*stop, *next) > settings_.stop_wait) {
    overtake_writes(*stop, true);
    end_over(now);
  }
}

// True: nothing else may begin now. False: no stop waits, or only such as let writes go first, and
// nothing but these may begin.
bool Bus::serve_stops(Instant now) {
  take_back_held_writes(now);
  const auto may_go = [this](const Job& stop) { return !must_let_writes_go(stop); };
  const auto can_go = [&](const Job& stop) {
    return may_go(stop) && in_the_way_of(stop) == nullptr;
  };
  while (Job* stop = queue_.find_stop(can_go)) {
    const Instant ready = line_.ready_for_stop_at();
    if (ready > now) {
      next_start_ = earlier(next_start_, ready);
      return true;
    }
    queue_.take(*stop);
    running_.push_back(stop);
    transmit(*stop, now);
  }
  Job* stop = queue_.find_stop(may_go);
  if (stop == nullptr) {
    stop = queue_.first_stop();
  }
  if (stop == nullptr) {
    return false;
  }
  if (Job* other = in_the_way_of(*stop)) {
    const bool has_own_time =
        other->job_class == JobClass::stop || (lets_writes_go(*stop) && goes_before(*other, *stop));
    line_.limit_wait(other->on_wire(), stop->waits_since + settings_.stop_wait,
                     has_own_time ? settings_.stop_wait : Duration{0});
    return true;
  }
  return false;
}

// It goes behind other stops that wait, so that a dead device does not keep them waiting.
void Bus::repeat_stop(Job& stop, Instant now) {
  std::erase(running_, &stop);
  stop.waits_since = now;
  queue_.push_again(stop);
}

}  // namespace mbgate::bus
