// SPDX-License-Identifier: Apache-2.0
// Stops: they go next, take back what they stop, and are repeated until they are acknowledged.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {

// Writes to the same device that were accepted before it and are not on the wire are never
// transmitted; of one that is, no further part is.
void Bus::overtake_writes(const Job& stop) {
  std::vector<Job*> overtaken;
  queue_.visit_all([&](Job& job) {
    if (is_stopped_by(stop, job)) {
      overtaken.push_back(&job);
    }
  });
  for (Job* job : overtaken) {
    queue_.remove(*job);
    end_job(*job, Ending::cancelled);
  }
  counters_.overtaken_writes += overtaken.size();
  for (Job* job : running_) {
    job->overtaken = job->overtaken || is_stopped_by(stop, *job);
  }
}

bool Bus::is_stopped_by(const Job& stop, const Job& write) const {
  if (write.job_class != JobClass::write) {
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
bool Bus::must_let_writes_go(const Job& stop) const {
  const std::uint8_t address = stop.address();
  if (stop.is_broadcast() || devices_[address].device->stop_cancels) {
    return false;
  }
  return queue_.write_waits_before(address, stop.sequence) ||
         std::ranges::any_of(running_, [&](const Job* job) {
           return job->job_class == JobClass::write && job->address() == address && !job->in_flight;
         });
}

// What keeps it from being transmitted. On a connection others may be on their way, but never to a
// device that has a write outstanding; where all places are taken, the one that has had its place
// for longest.
Job* Bus::in_the_way_of(const Job& stop) const {
  const auto writes_to_it = [&](const Job* job) {
    return job->in_flight && job->address() == stop.address() && job->job_class != JobClass::read;
  };
  const auto write = std::ranges::find_if(running_, writes_to_it);
  if (write != running_.end()) {
    return *write;
  }
  const auto oldest = std::ranges::find_if(running_, [](const Job* job) { return job->in_flight; });
  return in_flight() < most_running_ ? nullptr : *oldest;
}

// True: nothing else may begin now.
bool Bus::serve_stops(Instant now) {
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
    return false;
  }
  Job& other = *in_the_way_of(*stop);
  // A stop has as much time for its own acknowledgement.
  const Instant since = other.job_class == JobClass::stop
                            ? std::max(stop->waits_since, other.last_sent)
                            : stop->waits_since;
  line_.limit_wait(other.on_wire(), since + settings_.stop_wait);
  return true;
}

// It goes behind other stops that wait, so that a dead device does not keep them waiting.
void Bus::repeat_stop(Job& stop, Instant now) {
  std::erase(running_, &stop);
  stop.waits_since = now;
  queue_.push_again(stop);
}

}  // namespace mbgate::bus
