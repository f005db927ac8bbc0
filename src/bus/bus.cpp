// SPDX-License-Identifier: Apache-2.0
// The doors of a bus: bytes and time come in, jobs are taken back, everything ends.
#include "bus/bus.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::bus {
namespace {

constexpr Duration kLongestListening = std::chrono::seconds(1);
constexpr Duration kNeverSilent = std::chrono::seconds(1);

}  // namespace

Bus::Bus(const BusSettings& settings, std::span<const drive::Device> devices)
    : settings_(settings),
      devices_(settings, devices),
      longest_response_timeout_(bus::longest_response_timeout(settings, devices)),
      line_(settings, listening_time(), counters_),
      queue_(settings.queue),
      probes_(settings_, devices_),
      most_running_(settings.line.framing == Framing::tcp ? settings.outstanding : 1),
      quarantines_(settings.line.framing != Framing::tcp),
      link_(settings.reopen_min) {}

void Bus::update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now) {
  settings_ = settings;
  devices_.update(settings, devices);
  longest_response_timeout_ = bus::longest_response_timeout(settings, devices);
  line_.update(settings_, listening_time());
  queue_.set_limit(settings.queue);
  overtake_writes();
  end_repeats();
  most_running_ = settings.line.framing == Framing::tcp ? settings.outstanding : 1;
  pump(now);
}

Duration Bus::listening_time() const {
  return settings_.listen_first.value_or(std::min(longest_response_timeout_, kLongestListening));
}

void Bus::start() { actions_.push(OpenLine{}); }

void Bus::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (!link_.is_open()) {
    return;
  }
  adapter_.note_byte(now);
  const bool asked = in_flight() > 0;
  line_.handle_bytes(bytes, now);
  watch_silence(now);
  if (!asked) {
    quality_.note_unasked();
  }
  collect(now);
  pump(now);
}

void Bus::handle_looked(Instant now) {
  looking_ = Looking::done;
  pump(now);
  looking_ = Looking::no;
}

// Told once until somebody is understood again.
void Bus::watch_silence(Instant now) {
  const Duration limit = std::max(kNeverSilent, longest_stream(settings_));
  const auto since = line_.busy_since();
  if (since && now >= *since + limit && !std::exchange(never_silent_reported_, true)) {
    actions_.push(NeverSilent{});
  }
}

void Bus::handle_deadline(Instant now) {
  if (link_.take_due(now)) {
    actions_.push(OpenLine{});
  }
  if (link_.is_open()) {
    line_.handle_deadline(now);
    collect(now);
  }
  handle_looked(now);
}

void Bus::collect(Instant now) {
  while (const auto unsolicited = line_.take_unsolicited()) {
    handle_unsolicited(*unsolicited);
  }
  while (const auto end = line_.take_end()) {
    handle_end(*end, now);
  }
  while (const auto fault = line_.take_fault()) {
    if (fault == LineFault::framing_lost) {
      actions_.push(CloseLine{});
      handle_lost(now);
    } else if (fault != LineFault::unanswered) {
      actions_.push(LineNotice{*fault});
    } else if (!stopping_) {
      replace(now);
    }
  }
}

void Bus::withdraw(Job& job) {
  queue_.remove(job);
  release(job);
  next_start_ = Wake{pumped_at_};  // what waited behind it may go now
}

void Bus::abandon(Job& job) {
  job.abandoned = true;
  if (!job.in_flight) {
    next_start_ = Wake{pumped_at_};  // it ends, and what waited for it may go now
  }
}

void Bus::stop(Instant now) {
  stopping_ = true;
  link_.stop();
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

std::optional<Wake> Bus::next_wake() const {
  auto judgement = earlier(link_.next_attempt(), queue_.first_deadline());
  if (link_.is_open()) {
    judgement = earlier(judgement, line_.next_deadline());
  }
  return earlier(judgement ? std::optional(Wake{*judgement}) : std::nullopt, next_start_);
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
  probes_.note_released(job, pumped_at_);
}

void Bus::notify(DeviceNotice::Kind kind, std::uint8_t address) {
  DeviceNotice notice{kind, address};
  notice.answered_before = quality_[address].has_answered();
  notice.requests = devices_[address].health.unanswered_in_row();
  actions_.push(notice);
}

}  // namespace mbgate::bus
