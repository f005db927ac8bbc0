// SPDX-License-Identifier: Apache-2.0
#include "bus/bus.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::bus {
namespace {

constexpr Duration kLongestListening = std::chrono::seconds(1);
constexpr int kBackoffFactor = 2;

auto make_timings(const BusSettings& settings, std::span<const drive::Device> devices) {
  std::array<drive::DeviceTiming, modbus::kMaxDeviceAddress + 1> timings;
  timings.fill(settings.timing);
  for (const auto& device : devices) {
    timings.at(device.address) = device.timing;
  }
  return timings;
}

}  // namespace

Bus::Bus(const BusSettings& settings, std::span<const drive::Device> devices)
    : settings_(settings),
      timings_(make_timings(settings, devices)),
      longest_response_timeout_(bus::longest_response_timeout(settings, devices)),
      line_(settings,
            settings.listen_first.value_or(std::min(longest_response_timeout_, kLongestListening)),
            counters_),
      queue_(settings.queue),
      reopen_delay_(settings.reopen_min) {}

void Bus::start() { actions_.emplace_back(OpenLine{}); }

void Bus::handle_opened(Instant now) {
  state_ = State::open;
  opened_at_ = now;
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
  line_.abort();
  if (!stopping_) {
    reopen_at_ = now + reopen_delay_;
    reopen_delay_ = std::min(reopen_delay_ * kBackoffFactor, settings_.reopen_max);
  }
  if (running_ != nullptr) {
    end_job(*std::exchange(running_, nullptr), Ending::closed);
  }
  end_waiting(Ending::closed);
}

void Bus::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (state_ != State::open) {
    return;
  }
  line_.handle_bytes(bytes, now);
  collect();
  pump(now);
}

void Bus::handle_deadline(Instant now) {
  if (reopen_at_ && now >= *reopen_at_) {
    reopen_at_.reset();
    actions_.emplace_back(OpenLine{});
  }
  if (state_ == State::open) {
    line_.handle_deadline(now);
    collect();
  }
  expire(now);
  pump(now);
}

bool Bus::submit(Job& job, Instant now) {
  if (state_ == State::closed || stopping_) {
    end_job(job, stopping_ ? Ending::cancelled : Ending::closed);
    return true;
  }
  if (!queue_.push(job)) {
    ++counters_.refused_full;
    return false;
  }
  pump(now);
  return true;
}

void Bus::stop(Instant now) {
  stopping_ = true;
  reopen_at_.reset();
  end_waiting(Ending::cancelled);
  pump(now);
}

void Bus::give_up(Instant now) {
  line_.abort();
  if (running_ != nullptr) {
    end_job(*std::exchange(running_, nullptr), Ending::no_answer);
  }
  pump(now);
}

std::optional<BusAction> Bus::poll() {
  if (actions_.empty()) {
    return std::nullopt;
  }
  BusAction action = std::move(actions_.front());
  actions_.pop_front();
  return action;
}

std::optional<Instant> Bus::next_deadline() const {
  auto deadline = earlier(reopen_at_, queue_.first_deadline());
  if (state_ != State::open) {
    return deadline;
  }
  if (line_.is_busy()) {
    return earlier(deadline, line_.next_deadline());
  }
  if (running_ != nullptr) {
    const Instant ready = line_.ready_at(timing_of(*running_).gap);
    return earlier(deadline, std::min(ready, running_->deadline));
  }
  if (const Job* job = queue_.front()) {
    deadline = earlier(deadline, line_.ready_at(timing_of(*job).gap));
  }
  return deadline;
}

void Bus::clear_counters() {
  counters_ = {};
  device_counters_ = {};
}

Job* Bus::next_job() { return running_ != nullptr ? running_ : queue_.front(); }

void Bus::pump(Instant now) {
  while (state_ == State::open && !line_.is_busy()) {
    Job* job = next_job();
    if (job == nullptr) {
      return;
    }
    if (end_if_over(*job, now)) {
      continue;
    }
    if (now < line_.ready_at(timing_of(*job).gap)) {
      return;
    }
    if (job != running_) {
      queue_.pop_front();
      running_ = job;
    }
    transmit(*job, now);
  }
}

// May the job whose turn it is not be transmitted (again)?
bool Bus::end_if_over(Job& job, Instant now) {
  const bool is_running = &job == running_;
  const bool withdrawn = is_running && (job.abandoned || stopping_);
  if (!withdrawn && now < job.deadline) {
    return false;
  }
  if (is_running) {
    running_ = nullptr;
  } else {
    queue_.remove(job);
  }
  counters_.expired += withdrawn ? 0U : 1U;
  end_job(job, withdrawn ? Ending::cancelled : Ending::expired);
  return true;
}

void Bus::transmit(Job& job, Instant now) {
  Transaction& transaction = job.transaction();
  job.was_on_wire = true;
  counters_.retries += job.tries > 0 ? 1U : 0U;
  counters_.broadcasts += transaction.is_broadcast() ? 1U : 0U;
  ++job.tries;
  ++counters_of(job).transmissions;
  actions_.emplace_back(TransmitFrame{line_.begin(transaction, timing_of(job), now)});
}

void Bus::collect() {
  if (line_.take_echo_mismatch()) {
    actions_.emplace_back(EchoDiffered{});
  }
  if (const auto how = line_.take_end()) {
    handle_end(*how);
  }
}

void Bus::handle_end(RtuLine::End how) {
  Job& job = *running_;
  DeviceCounters& device = counters_of(job);
  switch (how) {
    case RtuLine::End::response:
      job.transaction().response = line_.response();
      handle_response(job);
      return;
    case RtuLine::End::sent:
      running_ = nullptr;
      end_job(job, Ending::transmitted);
      return;
    case RtuLine::End::no_response:
      if (job.transaction().silence_is_success) {
        running_ = nullptr;
        end_job(job, Ending::transmitted);
        return;
      }
      ++device.timeouts;
      ++device.unanswered_in_row;
      break;
    case RtuLine::End::bad_crc: ++device.bad_crcs; break;
  }
  handle_failure(job);
}

void Bus::handle_response(Job& job) {
  DeviceCounters& device = counters_of(job);
  const bool exception = job.transaction().response->is_exception();
  ++counters_.responses;
  ++device.responses;
  counters_.exceptions += exception ? 1U : 0U;
  device.exceptions += exception ? 1U : 0U;
  device.unanswered_in_row = 0;
  job.tries = 0;
  if (exception || ++job.current == job.transactions.size()) {
    running_ = nullptr;
    end_job(job, Ending::answered);
  }
}

void Bus::handle_failure(Job& job) {
  const drive::DeviceTiming& timing = timing_of(job);
  const bool may_repeat = job.transaction().request.is_read() || timing.retry_writes;
  if (!may_repeat || job.tries > timing.retries) {
    running_ = nullptr;
    end_job(job, Ending::no_answer);
  }
}

void Bus::end_job(Job& job, Ending ending) { actions_.emplace_back(JobEnded{&job, ending}); }

void Bus::end_waiting(Ending ending) {
  while (Job* job = queue_.front()) {
    queue_.remove(*job);
    end_job(*job, ending);
  }
}

void Bus::expire(Instant now) {
  for (Job* job = queue_.first_to_expire(); job != nullptr && now >= job->deadline;
       job = queue_.first_to_expire()) {
    queue_.remove(*job);
    ++counters_.expired;
    end_job(*job, Ending::expired);
  }
}

const drive::DeviceTiming& Bus::timing_of(const Job& job) const {
  return timings_.at(job.transactions[job.current].address);
}

DeviceCounters& Bus::counters_of(const Job& job) {
  return device_counters_.at(job.transactions[job.current].address);
}

}  // namespace mbgate::bus
