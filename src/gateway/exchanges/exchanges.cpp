// SPDX-License-Identifier: Apache-2.0
#include "gateway/exchanges/exchanges.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "gateway/limits.hpp"
#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {

std::uint32_t Exchanges::open(std::optional<routing::Plan>&& plan) {
  const std::uint32_t index = exchanges_.take();
  Exchange& exchange = exchanges_[index];
  exchange.snapshot = &settings_.in_force();
  ++exchange.snapshot->exchanges;
  exchange.plan = std::move(plan);
  planned_ += exchange.planned();
  return index;
}

std::size_t Exchanges::planned(std::span<const std::uint32_t> indexes) {
  std::size_t sum = 0;
  for (const std::uint32_t index : indexes) {
    sum += exchanges_[index].planned();
  }
  return sum;
}

void Exchanges::start(std::uint32_t index, Turns turns, Instant now) {
  Exchange& exchange = exchanges_[index];
  exchange.is_held = false;
  for (const drive::Transaction& planned : exchange.plan->transactions()) {
    if (exchange.parts.empty() || exchange.parts.back().bus != planned.bus) {
      add_job(index, planned.bus, turns, exchange.deadline);
    }
    exchange.parts.back().job->transactions.push_back(planned);
  }
  submit(index, now);
}

Instant Exchanges::deadline_of(const Exchange& exchange) const {
  const routing::Route& route = exchange.route->route;
  Duration time = route.deadline.value_or(Duration{0});
  if (!route.deadline) {
    const Duration longest = buses_.longest_transaction(route.buses);
    time = exchange.plan->is_read() ? read_deadline(longest) : write_deadline(longest);
  }
  const Duration give_up = settings_.settings().listener(exchange.listener).give_up;
  return exchange.arrival + (give_up > Duration{0} ? std::min(time, give_up) : time);
}

bus::Job& Exchanges::add_job(std::uint32_t index, BusId bus, Turns turns, Instant deadline) {
  const std::uint32_t number = jobs_.take();
  bus::Job& job = jobs_[number];
  job.number = number;
  job.owner = index;
  job.source = turns.key;
  job.weight = turns.weight;
  job.deadline = deadline;
  exchanges_[index].parts.push_back({bus, &job});
  return job;
}

void Exchanges::submit(std::uint32_t index, Instant now) {
  const auto parts = exchanges_[index].parts;  // a part that ends at once is taken out
  for (const Exchange::Part& part : parts) {
    if (!buses_.touch(part.bus).submit(*part.job, now)) {
      end(*part.job, bus::Ending::cancelled);
    }
  }
  if (parts.empty()) {
    completed_.push(index);
  }
}

bool Exchanges::begin_anew(bus::Job& job, BusId bus, Instant now) {
  if (job.job_class != bus::JobClass::stop || job.abandoned || !exchanges_[job.owner].plan) {
    return false;
  }
  std::ranges::find(exchanges_[job.owner].parts, &job, &Exchange::Part::job)->bus = bus;
  job.current = 0;
  job.accepted = false;
  for (bus::Transaction& transaction : job.transactions) {
    transaction.response.reset();
  }
  if (!buses_.touch(bus).submit(job, now)) {
    end(job, bus::Ending::cancelled);
  }
  return true;
}

void Exchanges::end(bus::Job& job, bus::Ending ending) {
  const std::uint32_t index = job.owner;
  Exchange& exchange = exchanges_[index];
  const auto part = std::ranges::find(exchange.parts, &job, &Exchange::Part::job);
  MBGATE_ASSERT(part != exchange.parts.end(), "a job ends once");
  exchange.note(job, ending);
  report_effects(exchange, *part, ending, settings_.settings(), actions_);
  exchange.parts.erase(part);
  jobs_.give_back(job.number);
  if (exchange.parts.empty()) {
    completed_.push(index);
  }
}

std::optional<std::uint32_t> Exchanges::take_completed() { return completed_.poll(); }

void Exchanges::close(std::uint32_t index) {
  SettingsSnapshot& snapshot = *exchanges_[index].snapshot;
  planned_ -= exchanges_[index].planned();
  MBGATE_ASSERT(snapshot.exchanges > 0, "a request keeps the settings of its plan");
  --snapshot.exchanges;
  exchanges_.give_back(index);
  settings_.forget_unused();
}

void Exchanges::refuse(std::uint32_t index) {
  Exchange& exchange = exchanges_[index];
  exchange.is_held = false;
  exchange.failed = true;
  exchange.ended_as = bus::Ending::cancelled;
  completed_.push(index);
}

void Exchanges::cancel(std::uint32_t index) {
  if (exchanges_[index].is_held) {
    refuse(index);
    return;
  }
  const auto parts = exchanges_[index].parts;  // a part that ends is taken out
  for (const Exchange::Part& part : parts) {
    if (!part.is_stop()) {
      end_unsent(part);
    }
  }
}

// A part may have ended: a broadcast has been sent on another bus.
void Exchanges::take_back(std::uint32_t index) {
  const Exchange& exchange = exchanges_[index];
  const auto is_begun = [](const Exchange::Part& part) {
    return part.job->was_on_wire && !part.job->is_read();
  };
  const bool has_begun = exchange.was_on_wire && exchange.plan && !exchange.plan->is_read();
  if (!has_begun && std::ranges::none_of(exchange.parts, is_begun)) {
    cancel(index);
  }
}

void Exchanges::abandon(std::uint32_t index) {
  for (const Exchange::Part& part : exchanges_[index].parts) {
    buses_.touch(part.bus).abandon(*part.job);
  }
}

// Takes a job back, or, if it is on the wire, sees to it that nothing more of it follows.
void Exchanges::end_unsent(const Exchange::Part& part) {
  if (part.job->is_waiting()) {
    buses_.touch(part.bus).withdraw(*part.job);
    end(*part.job, bus::Ending::cancelled);
  } else {
    buses_.touch(part.bus).abandon(*part.job);
  }
}

// Stops are sent: settings do not move a drive, and the one that was meant is still where it was.
void Exchanges::end_changed(const SettingsSnapshot& old) {
  std::vector<Exchange::Part> changed;
  for (const Exchange& exchange : exchanges_.all()) {
    for (const Exchange::Part& part : exchange.parts) {
      if (!part.is_stop() && keeps_line(old.settings, settings_.settings(), part.bus) &&
          means_otherwise(exchange, part, old, settings_.in_force())) {
        changed.push_back(part);
      }
    }
  }
  for (const Exchange::Part& part : changed) {
    end_unsent(part);
  }
}

}  // namespace mbgate::gateway
