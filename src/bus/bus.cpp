// SPDX-License-Identifier: Apache-2.0
// The doors of a bus: its line comes and goes, jobs are handed in and taken back.
#include "bus/bus.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::bus {
namespace {

constexpr Duration kLongestListening = std::chrono::seconds(1);
constexpr int kBackoffFactor = 2;

}  // namespace

Bus::Bus(const BusSettings& settings, std::span<const drive::Device> devices)
    : settings_(settings),
      devices_(settings, devices),
      longest_response_timeout_(bus::longest_response_timeout(settings, devices)),
      line_(settings, listening_time(), counters_),
      queue_(settings.queue),
      most_running_(settings.line.framing == Framing::tcp ? settings.outstanding : 1),
      quarantines_(settings.line.framing != Framing::tcp),
      reopen_delay_(settings.reopen_min) {}

void Bus::update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now) {
  settings_ = settings;
  devices_.update(settings, devices);
  longest_response_timeout_ = bus::longest_response_timeout(settings, devices);
  line_.update(settings_, listening_time());
  queue_.set_limit(settings.queue);
  overtake_writes();
  most_running_ = settings.line.framing == Framing::tcp ? settings.outstanding : 1;
  pump(now);
}

Duration Bus::listening_time() const {
  return settings_.listen_first.value_or(std::min(longest_response_timeout_, kLongestListening));
}

void Bus::start() { actions_.push(OpenLine{}); }

void Bus::handle_opened(Instant now) {
  state_ = State::open;
  opened_at_ = now;
  devices_.forget_what_was_read();
  foreign_reported_ = false;
  reopen_at_.reset();
  line_.open(now);
  pump(now);
}

void Bus::handle_lost(Instant now) {
  if (state_ == State::open) {
    ++counters_.losses;
    if (now - opened_at_ >= settings_.reopen_max) {
      // A line that dies as soon as it is open gets no such favour.
      reopen_delay_ = settings_.reopen_min;
    }
  }
  state_ = State::closed;
  for (Job* job : running_) {
    if (job->in_flight && !job->on_wire().is_broadcast() && !job->on_wire().may_stay_silent()) {
      devices_[job->on_wire().address].health.note_spoilt(line_.response_due());
    }
  }
  line_.abort();
  if (!stopping_) {
    reopen_at_ = now + reopen_delay_;
    reopen_delay_ = std::min(reopen_delay_ * kBackoffFactor, settings_.reopen_max);
  }
  end_running(Ending::closed);
  end_waiting(Ending::closed, true);
  pump(now);
}

void Bus::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (state_ != State::open) {
    return;
  }
  line_.handle_bytes(bytes, now);
  collect(now);
  pump(now);
}

void Bus::handle_deadline(Instant now) {
  if (reopen_at_ && now >= *reopen_at_) {
    reopen_at_.reset();
    actions_.push(OpenLine{});
  }
  if (state_ == State::open) {
    line_.handle_deadline(now);
    collect(now);
  }
  pump(now);
}

void Bus::collect(Instant now) {
  while (const auto stray = line_.take_stray()) {
    handle_stray(*stray, now);
  }
  while (const auto end = line_.take_end()) {
    handle_end(*end, now);
  }
  const auto fault = line_.take_fault();
  if (fault == LineFault::echo_differed) {
    actions_.push(EchoDiffered{});
  } else if (fault == LineFault::framing_lost) {
    actions_.push(CloseLine{});
    handle_lost(now);
  }
}

void Bus::withdraw(Job& job) {
  queue_.remove(job);
  release(job);
  next_start_ = pumped_at_;  // what waited behind it may go now
}

void Bus::stop(Instant now) {
  stopping_ = true;
  reopen_at_.reset();
  end_waiting(Ending::cancelled, false);
  pump(now);
}

void Bus::give_up(Instant now) {
  line_.abort();
  end_running(Ending::no_answer);
  end_waiting(Ending::cancelled, true);
  pump(now);
}

std::optional<BusAction> Bus::poll() { return actions_.poll(); }

std::optional<Instant> Bus::next_deadline() const {
  const auto deadline = earlier(reopen_at_, earlier(queue_.first_deadline(), next_start_));
  return state_ == State::open ? earlier(deadline, line_.next_deadline()) : deadline;
}

void Bus::clear_counters() {
  counters_ = {};
  devices_.clear_counters();
}

Duration Bus::held_back(std::uint8_t address, Instant now) const {
  const DeviceEntry& entry = devices_[address];
  const Instant until = entry.health.held_until(entry.timing());
  return quarantines_ && until > now ? until - now : Duration{0};
}

void Bus::end_running(Ending ending) {
  for (Job* job : std::exchange(running_, {})) {
    end_group(*job, ending);
  }
}

void Bus::end_waiting(Ending ending, bool stops_too) {
  while (Job* job = queue_.first_to_expire()) {
    queue_.remove(*job);
    end_job(*job, ending);
  }
  while (Job* stop = stops_too ? queue_.first_stop() : nullptr) {
    queue_.remove(*stop);
    end_group(*stop, ending);
  }
}

// The job, and before it those that share its transmission. Stops share its responses too.
void Bus::end_group(Job& leader, Ending ending) {
  for (Job* follower : leader.followers) {
    if (leader.job_class == JobClass::stop) {
      follower->transactions = leader.transactions;
      follower->current = leader.current;
    }
    end_job(*follower, ending);
  }
  leader.followers.clear();
  end_job(leader, ending);
}

void Bus::end_job(Job& job, Ending ending) {
  release(job);
  actions_.push(JobEnded{&job, ending});
}

// The bus has it no more.
void Bus::release(Job& job) {
  if (!std::exchange(job.accepted, false)) {
    return;
  }
  if (job.job_class != JobClass::read) {
    devices_.end_write(job);
  }
  DeviceEntry& entry = devices_[job.address()];
  if (entry.probe == &job) {
    entry.probe = nullptr;
  }
}

void Bus::notify(DeviceNotice::Kind kind, std::uint8_t address) {
  actions_.push(DeviceNotice{kind, address});
}

}  // namespace mbgate::bus
