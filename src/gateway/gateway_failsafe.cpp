// SPDX-License-Identifier: Apache-2.0
// Failsafe writes: from when they are due until they were transmitted.
#include <algorithm>

#include "gateway/gateway.hpp"

namespace mbgate::gateway {

void Gateway::note_asked(ClientId id, ClientSession& session, Instant now) {
  session.has_asked = true;
  ++client_counters_.requests;
  for (const std::size_t device : failsafe_.client_asked(id, now)) {
    report_failsafe({device, FailsafeReason::gone}, FailsafeOutcome::client_back);
  }
}

// They go as stops of nobody. Each is a job of its own, because a stop is repeated and another
// write is not. The bus is asked even if its line is away: it may be one that is opened on demand.
void Gateway::send_failsafe(Failsafe::Due due, Instant now) {
  const drive::Device& device = settings().devices[due.device];
  if (device.stop_cancels) {
    stop_marks_.note(due.device, std::nullopt, now);
  }
  const std::uint32_t index = exchanges_.take();
  Exchange& exchange = exchanges_[index];
  exchange.snapshot = &current();
  ++exchange.snapshot->exchanges;
  exchange.client_gone = true;
  exchange.is_stop = true;
  FailsafeRun& run = exchange.failsafe.emplace();
  run.due = std::move(due);
  const auto writes = current().failsafe(run.due.device);
  for (std::size_t place = 0; place < writes.size(); ++place) {
    if (std::ranges::find(run.due.sent, place) != run.due.sent.end()) {
      continue;
    }
    bus::Job& job = new_job(index, now);
    job.job_class = bus::JobClass::stop;
    job.transactions.push_back({device.address, writes[place]});
    exchange.parts.push_back({device.bus, &job});
    run.unsent.push_back({&job, place});
  }
  failsafe_runs_.push_back(index);
  submit_parts(exchange, now);
}

// A bus has transmitted something.
void Gateway::note_failsafe_sent() {
  for (const std::uint32_t index : failsafe_runs_) {
    if (auto& run = exchanges_[index].failsafe) {
      note_failsafe_sent(*run);
    }
  }
}

void Gateway::note_failsafe_sent(FailsafeRun& run) {
  if (run.unsent.empty()) {
    return;  // said already
  }
  std::erase_if(run.unsent, [&](const FailsafeRun::Write& write) {
    const bool was_sent = write.job != nullptr && write.job->was_on_wire;
    if (was_sent) {
      run.due.sent.push_back(write.place);
    }
    return was_sent;
  });
  if (run.unsent.empty()) {
    report_failsafe(run.due, FailsafeOutcome::sent);
  }
}

// Its jobs have ended. What was not transmitted stays due.
void Gateway::end_failsafe(std::uint32_t index) {
  std::erase(failsafe_runs_, index);
  const auto& run = exchanges_[index].failsafe;
  if (!run || run->unsent.empty()) {
    return;
  }
  Failsafe::Due due = run->due;
  if (run->is_outdated) {
    due.sent.clear();
  }
  const bool was_told = std::exchange(due.told, true);
  if (stopping_) {
    report_failsafe(due, FailsafeOutcome::given_up);
  } else if (!failsafe_.put_back(due)) {
    report_failsafe(due, FailsafeOutcome::client_back);
  } else if (!was_told) {
    report_failsafe(due, FailsafeOutcome::waits);
  }
}

// What is due and what `failsafe_on_exit` asks for; what cannot be sent any more is said.
void Gateway::take_failsafe_at_exit(Instant now) {
  for (std::size_t place = 0; place < settings().devices.size(); ++place) {
    auto due = failsafe_.take_at_exit(place);
    if (!due) {
      continue;
    }
    if (current().guard(place)->failsafe_on_exit) {
      send_failsafe(*std::move(due), now);
    } else if (due->told) {
      report_failsafe(*due, FailsafeOutcome::given_up);
    }
  }
}

void Gateway::report_failsafe(const Failsafe::Due& due, FailsafeOutcome outcome) {
  const drive::Device& device = settings().devices[due.device];
  report(FailsafeNews{device.bus, device.address, due.reason, outcome});
}

}  // namespace mbgate::gateway
