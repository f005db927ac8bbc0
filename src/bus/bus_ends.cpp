// SPDX-License-Identifier: Apache-2.0
// What becomes of a job when a transmission of it has ended.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

bool holds_one_of(const std::vector<std::uint16_t>& wanted, const Transaction& transaction) {
  constexpr std::size_t kData = 2;  // after function and byte count (6.3)
  const modbus::Pdu& response = *transaction.response;
  return !response.is_exception() &&
         std::ranges::find(wanted, modbus::load_be16(response.bytes(), kData)) != wanted.end();
}

}  // namespace

void Bus::handle_end(const LineEnd& end, Instant now) {
  Job& job = **std::ranges::find_if(
      running_, [&](Job* running) { return &running->transaction() == end.transaction; });
  job.in_flight = false;
  switch (end.how) {
    case LineEnd::How::response: handle_response(job, now); return;
    case LineEnd::How::sent:
      devices_.hold_booting(*end.transaction, now);
      advance(job, Ending::transmitted);
      return;
    case LineEnd::How::no_response: handle_silence(job, now); return;
    case LineEnd::How::damaged:
      ++counters_.bad_crcs;
      ++devices_[end.transaction->address].counters.bad_crcs;
      handle_failure(job);
      return;
  }
}

void Bus::handle_response(Job& job, Instant now) {
  const Transaction& transaction = job.transaction();
  DeviceEntry& entry = devices_[transaction.address];
  const bool exception = transaction.response->is_exception();
  ++counters_.responses;
  ++entry.counters.responses;
  counters_.exceptions += exception ? 1U : 0U;
  entry.counters.exceptions += exception ? 1U : 0U;
  entry.counters.unanswered_in_row = 0;
  if (transaction.must_hold != nullptr) {
    entry.setting_known = holds_one_of(*transaction.must_hold, transaction);
    if (!entry.setting_known) {
      finish(job, Ending::mismatched);
      return;
    }
  }
  if (exception) {
    finish(job, Ending::answered);
    return;
  }
  if (transaction.boot_time) {
    entry.free_at = now + *transaction.boot_time;  // it boots, though it has answered before
  }
  advance(job, Ending::answered);
}

void Bus::handle_silence(Job& job, Instant now) {
  const Transaction& transaction = job.transaction();
  DeviceEntry& entry = devices_[transaction.address];
  entry.setting_known = false;
  if (transaction.may_stay_silent()) {
    if (transaction.boot_time) {
      entry.free_at = now + *transaction.boot_time;
    }
    advance(job, Ending::transmitted);
    return;
  }
  ++counters_.timeouts;
  ++entry.counters.timeouts;
  ++entry.counters.unanswered_in_row;
  handle_failure(job);
}

void Bus::handle_failure(Job& job) {
  const drive::DeviceTiming& timing = devices_[job.transaction().address].device->timing;
  const bool may_repeat = job.transaction().request.is_read() || timing.retry_writes;
  if (!may_repeat || job.tries > timing.retries) {
    finish(job, Ending::no_answer);
  }
}

void Bus::advance(Job& job, Ending ending) {
  job.tries = 0;
  if (++job.current == job.transactions.size()) {
    finish(job, ending);
  }
}

void Bus::finish(Job& job, Ending ending) {
  std::erase(running_, &job);
  end_job(job, ending);
}

}  // namespace mbgate::bus
