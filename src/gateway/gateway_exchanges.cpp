// SPDX-License-Identifier: Apache-2.0
// The jobs of a request: from its plan to the buses, and what becomes of them.
#include <algorithm>

#include "gateway/gateway.hpp"
#include "modbus/make_request.hpp"
#include "routing/special_writes.hpp"

namespace mbgate::gateway {

void Gateway::start(std::uint32_t index, const routing::Way& way, Instant arrival, Instant now) {
  Exchange& exchange = exchanges_[index];
  const Instant deadline = arrival + deadline_of(way.route, *exchange.plan);
  for (const routing::PlannedTransaction& planned : exchange.plan->transactions()) {
    if (exchange.parts.empty() || exchange.parts.back().bus != planned.bus) {
      exchange.parts.push_back({planned.bus, &new_job(index, deadline)});
      ask_word_order(way, *exchange.plan, *exchange.parts.back().job);
    }
    exchange.parts.back().job->transactions.push_back(
        {planned.address, planned.request, planned.silence_is_success, planned.broadcast});
  }
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
  job.source = sources_.at(exchanges_[owner].address).id;
  job.deadline = deadline;
  return job;
}

// verify_word_order: before the first write of values since the device was last out of reach, its
// own setting is read, in the same job, so that what the client sends next stays behind.
void Gateway::ask_word_order(const routing::Way& way, const routing::Plan& plan, bus::Job& job) {
  if (way.device == nullptr || !way.device->verify_word_order || plan.is_read() ||
      !plan.orders_words()) {
    return;
  }
  const drive::Device& device = *way.device;
  const std::uint32_t contact =
      buses_[static_cast<std::size_t>(device.bus)].bus.contact(device.address);
  const auto known = word_order_seen_.find({device.bus, device.address});
  if (known != word_order_seen_.end() && known->second == contact) {
    return;
  }
  const auto& setting = *device.profile.word_order_register;
  bus::Transaction question{
      device.address, modbus::make_read({modbus::Table::holding_registers, setting.address, 1})};
  question.must_hold = device.word_order == drive::WordOrder::big ? &setting.big : &setting.little;
  job.transactions.push_back(std::move(question));
}

void Gateway::note_word_order(BusId bus, const bus::Job& job, bus::Ending ending) {
  const bus::Transaction& question = job.transactions.front();
  if (question.must_hold == nullptr) {
    return;
  }
  if (ending == bus::Ending::mismatched) {
    report(WordOrderDiffers{bus, question.address});
  } else if (question.response) {
    word_order_seen_[{bus, question.address}] =
        buses_[static_cast<std::size_t>(bus)].bus.contact(question.address);
  }
}

// Whatever way it came: a drive that was set otherwise may be out of reach, or speak another order.
void Gateway::note_reconfigured(const Exchange& exchange, const Exchange::Part& part) {
  for (const drive::Device& device : settings_.devices) {
    const bool hit = device.bus == part.bus &&
                     std::ranges::any_of(part.job->transactions, [&](const bus::Transaction& it) {
                       const bool heard = it.is_broadcast()
                                              ? it.broadcast == device.profile.broadcast.form
                                              : it.address == device.address;
                       return heard && routing::reconfigures(device, it.request);
                     });
    if (hit) {
      word_order_seen_.erase({device.bus, device.address});
      report(Reconfigured{device.bus, device.address, exchange.address});
    }
  }
}

void Gateway::end_part(bus::Job& job, bus::Ending ending) {
  const std::uint32_t index = job.owner;
  Exchange& exchange = exchanges_[index];
  const auto part = std::ranges::find(exchange.parts, &job, &Exchange::Part::job);
  exchange.note(job, ending);
  note_word_order(part->bus, job, ending);
  report_effects(exchange, *part, ending);
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
  const bus::Job& job = *part.job;
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
  if (!done && job.current > begin && last && !job.transactions.front().is_broadcast()) {
    const std::uint16_t first = job.transactions[begin].request.writes()->range.first;
    const auto& failed = job.transactions[job.current].request.writes()->range;
    report(WriteEndedEarly{part.bus, address, failed.table, first, failed.first,
                           drive::end_of(last->range)});
  }
}

void Gateway::complete(std::uint32_t index) {
  Exchange& exchange = exchanges_[index];
  if (!exchange.client_gone) {
    ClientSession& session = sessions_.at(exchange.client);
    session.exchanges.erase(std::ranges::find(session.exchanges, index));
    std::optional<modbus::MbapAdu> adu;
    if (const auto pdu = exchange.result()) {
      adu = modbus::MbapAdu{exchange.header, *pdu};
    }
    send(exchange.client, session, exchange.answer, adu);
  }
  exchanges_.give_back(index);
}

// Takes back what waits; what is on the wire goes on, but is not repeated for a client that has
// gone.
void Gateway::cancel_waiting(std::uint32_t index, bool writes_only) {
  Exchange& exchange = exchanges_[index];
  if (writes_only && exchange.plan->is_read()) {
    return;
  }
  const auto parts = exchange.parts;
  for (const Exchange::Part& part : parts) {
    if (part.job->is_waiting()) {
      touch(part.bus).withdraw(*part.job);
      end_part(*part.job, bus::Ending::cancelled);
    } else {
      part.job->abandoned = true;
    }
  }
}

}  // namespace mbgate::gateway
