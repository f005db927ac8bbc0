// SPDX-License-Identifier: Apache-2.0
// The jobs of a request: from its plan to the buses, and what becomes of them.
#include <algorithm>

#include "base/assert.hpp"
#include "gateway/gateway.hpp"

namespace mbgate::gateway {
namespace {

// Was the transaction carried out, as far as anybody knows?
bool may_have_worked(const bus::Job& job, std::size_t at) {
  const bus::Transaction& transaction = job.transactions[at];
  return at < job.current ||
         (at == job.current && transaction.must_hold == nullptr && job.was_on_wire &&
          !(transaction.response && transaction.response->is_exception()));
}

}  // namespace

void Gateway::start(std::uint32_t index, Instant arrival, Instant now) {
  Exchange& exchange = exchanges_[index];
  const routing::ResolvedRoute& resolved =
      *current().routes.find(exchange.listener, exchange.header.unit);
  exchange.reply = resolved.route.broadcast_reply;
  exchange.word_order = resolved.route.word_order;
  const Instant deadline = arrival + deadline_of(resolved.route, *exchange.plan);
  note_accepted(exchange, now);
  for (const routing::PlannedTransaction& planned : exchange.plan->transactions()) {
    if (exchange.leaves_out(planned.bus)) {
      exchange.failed = true;
      continue;
    }
    if (exchange.parts.empty() || exchange.parts.back().bus != planned.bus) {
      exchange.parts.push_back({planned.bus, &new_job(index, deadline)});
    }
    auto& transactions = exchange.parts.back().job->transactions;
    transactions.push_back(
        {planned.address, planned.request, planned.silence_is_success, planned.broadcast});
    transactions.back().must_hold = planned.must_hold;
    transactions.back().window_begin = planned.window_begin;
    transactions.back().window_end = planned.window_end;
  }
  submit_parts(exchange, now);
}

void Gateway::submit_parts(const Exchange& exchange, Instant now) {
  const auto parts = exchange.parts;  // a part that ends at once is taken out
  for (const Exchange::Part& part : parts) {
    if (!touch(part.bus).submit(*part.job, now)) {
      end_part(*part.job, bus::Ending::cancelled);
    }
  }
}

bus::Job& Gateway::new_job(std::uint32_t owner, Instant deadline) {
  const std::uint32_t number = jobs_.take();
  bus::Job& job = jobs_[number];
  job.number = number;
  job.owner = owner;
  if (const auto source = sources_.find(exchanges_[owner].address);
      exchanges_[owner].plan && source != sources_.end()) {
    job.source = source->second.id;
    job.weight = source->second.weight;
  }
  job.deadline = deadline;
  return job;
}

// Whatever way it came: a drive that was set otherwise may be out of reach, or speak another order.
void Gateway::note_reconfigured(const Exchange& exchange, const Exchange::Part& part) {
  for (const drive::Device& device : settings().devices) {
    bool hit = false;
    for (std::size_t at = 0; device.bus == part.bus && at < part.job->transactions.size(); ++at) {
      const bus::Transaction& it = part.job->transactions[at];
      const bool heard = it.is_broadcast() ? it.broadcast == device.profile.broadcast.form
                                           : it.address == device.address;
      hit =
          hit || (heard && device.is_reconfigured_by(it.request) && may_have_worked(*part.job, at));
    }
    if (hit) {
      report(Reconfigured{device.bus, device.address, exchange.address});
    }
  }
}

void Gateway::end_part(bus::Job& job, bus::Ending ending) {
  const std::uint32_t index = job.owner;
  Exchange& exchange = exchanges_[index];
  const auto part = std::ranges::find(exchange.parts, &job, &Exchange::Part::job);
  MBGATE_ASSERT(part != exchange.parts.end(), "a job ends once");
  exchange.note(job, ending);
  if (exchange.plan) {
    report_effects(exchange, *part, ending);
  }
  if (exchange.failsafe) {
    note_failsafe_sent(*exchange.failsafe);
    exchange.failsafe->forget(job);
  }
  exchange.parts.erase(part);
  jobs_.give_back(job.number);
  if (exchange.parts.empty()) {
    complete(index);
  }
}

// What an operator must know of a write: that it ended half-way, or that it changed how the drive
// can be reached.
void Gateway::report_effects(const Exchange& exchange, const Exchange::Part& part,
                             bus::Ending ending) {
  if (part.bus == kNoBus) {
    return;  // nobody knows it any more
  }
  const bus::Job& job = *part.job;
  if (ending == bus::Ending::mismatched) {
    report(WordOrderDiffers{part.bus, job.transactions[job.current].address});
  }
  if (exchange.plan->is_read()) {
    return;
  }
  const bool done = ending == bus::Ending::transmitted ||
                    (ending == bus::Ending::answered && job.current == job.transactions.size());
  const std::uint8_t address = job.transactions.front().address;
  if (job.was_on_wire) {
    note_reconfigured(exchange, part);
  }
  const std::size_t begin = job.transactions.front().must_hold != nullptr ? 1 : 0;
  const auto& last = job.transactions.back().request.writes();
  if (!done && job.current > begin && last && !job.is_broadcast()) {
    const std::uint16_t first = job.transactions[begin].request.writes()->range.first;
    const auto& failed = job.transactions[job.current].request.writes()->range;
    report(WriteEndedEarly{part.bus, address, failed.table, first, failed.first,
                           drive::end_of(last->range)});
  }
}

void Gateway::complete(std::uint32_t index) {
  end_failsafe(index);
  Exchange& exchange = exchanges_[index];
  if (!exchange.client_gone) {
    ClientSession& session = sessions_.at(exchange.client);
    session.exchanges.erase(std::ranges::find(session.exchanges, index));
    std::optional<modbus::MbapAdu> adu;
    if (const auto pdu = exchange.result()) {
      adu = modbus::MbapAdu{exchange.header, *pdu};
    }
    if (!session.ahead.keep_answer(index, adu)) {
      send(exchange.client, session, exchange.answer, adu);
    }
  }
  MBGATE_ASSERT(exchange.snapshot->exchanges > 0, "a request keeps the settings of its plan");
  --exchange.snapshot->exchanges;
  exchanges_.give_back(index);
  forget_generations();
}

void Gateway::forget_generations() {
  snapshots_.remove_if(
      [this](const SettingsSnapshot& it) { return it.exchanges == 0 && &it != &current(); });
}

// Takes back what waits; what is on the wire goes on, but is not repeated for a client that has
// gone. Stops are carried out whatever becomes of their client.
void Gateway::cancel_waiting(std::uint32_t index, bool writes_only) {
  const Exchange& exchange = exchanges_[index];
  if (writes_only && exchange.plan->is_read()) {
    return;
  }
  const auto parts = exchange.parts;  // a part that ends is taken out
  for (const Exchange::Part& part : parts) {
    if (!part.is_stop()) {
      end_unsent(part);
    }
  }
}

void Gateway::end_unsent(const Exchange::Part& part) {
  if (part.job->is_waiting()) {
    touch(part.bus).withdraw(*part.job);
    end_part(*part.job, bus::Ending::cancelled);
  } else {
    part.job->abandoned = true;
  }
}

}  // namespace mbgate::gateway
