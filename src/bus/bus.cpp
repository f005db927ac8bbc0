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
      line_(settings,
            settings.listen_first.value_or(std::min(longest_response_timeout_, kLongestListening)),
            counters_),
      queue_(settings.queue),
      most_running_(settings.line.framing == Framing::tcp ? settings.outstanding : 1),
      reopen_delay_(settings.reopen_min) {}

void Bus::start() { actions_.emplace_back(OpenLine{}); }

void Bus::handle_opened(Instant now) {
  state_ = State::open;
  opened_at_ = now;
  devices_.forget_settings();
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
  end_running(Ending::closed);
  end_waiting(Ending::closed);
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
    actions_.emplace_back(OpenLine{});
  }
  if (state_ == State::open) {
    line_.handle_deadline(now);
    collect(now);
  }
  pump(now);
}

void Bus::collect(Instant now) {
  while (const auto end = line_.take_end()) {
    handle_end(*end, now);
  }
  const auto fault = line_.take_fault();
  if (fault == LineFault::echo_differed) {
    actions_.emplace_back(EchoDiffered{});
  } else if (fault == LineFault::framing_lost) {
    actions_.emplace_back(CloseLine{});
    handle_lost(now);
  }
}

bool Bus::is_stop(std::uint8_t address, const modbus::Request& request,
                  drive::BroadcastForm broadcast) const {
  return devices_.is_stop(address, request, broadcast);
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

void Bus::withdraw(Job& job) {
  queue_.remove(job);
  next_start_ = pumped_at_;  // what waited behind it may go now
}

void Bus::stop(Instant now) {
  stopping_ = true;
  reopen_at_.reset();
  end_waiting(Ending::cancelled);
  pump(now);
}

void Bus::give_up(Instant now) {
  line_.abort();
  end_running(Ending::no_answer);
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
  const auto deadline = earlier(reopen_at_, earlier(queue_.first_deadline(), next_start_));
  return state_ == State::open ? earlier(deadline, line_.next_deadline()) : deadline;
}

void Bus::clear_counters() {
  counters_ = {};
  devices_.clear_counters();
}

void Bus::end_running(Ending ending) {
  for (Job* job : std::exchange(running_, {})) {
    end_job(*job, ending);
  }
}

void Bus::end_waiting(Ending ending) {
  while (Job* job = queue_.first_to_expire()) {
    queue_.remove(*job);
    end_job(*job, ending);
  }
}

}  // namespace mbgate::bus
