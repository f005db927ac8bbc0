// SPDX-License-Identifier: Apache-2.0
#include "gateway/exchanges/exchange.hpp"

namespace mbgate::gateway {

void Exchange::note(const bus::Job& job, bus::Ending ending) {
  was_on_wire = was_on_wire || job.was_on_wire;
  ended_as = failed ? ended_as : ending;
  if (!plan) {  // nobody is answered
    response = job.transactions.back().response;
    return;
  }
  switch (ending) {
    case bus::Ending::answered: response = plan->answer(job.transactions); break;
    case bus::Ending::transmitted: failed = failed || plan->is_answered_with_data(); break;
    case bus::Ending::mismatched: failed = wrong_word_order = true; break;
    case bus::Ending::closed:
      failed = true;
      had_no_path = had_no_path || !job.was_on_wire;
      break;
    case bus::Ending::offline:
      failed = true;
      // A read that is refused gets the answer that it would have got; a write says that it was
      // never transmitted.
      was_on_wire = was_on_wire || plan->is_read();
      break;
    case bus::Ending::no_answer:
    case bus::Ending::expired:
    case bus::Ending::cancelled: failed = true; break;
  }
}

std::optional<modbus::Pdu> Exchange::result() const {
  using modbus::ExceptionCode;
  if (failed) {
    ExceptionCode code = ExceptionCode::server_device_busy;
    if (wrong_word_order) {
      code = ExceptionCode::server_device_failure;
    } else if (had_no_path) {
      code = ExceptionCode::gateway_path_unavailable;
    } else if (was_on_wire) {
      code = ExceptionCode::gateway_target_failed_to_respond;
    }
    return modbus::Pdu::exception(plan->function(), code);
  }
  if (response) {
    return response;
  }
  return route->route.broadcast_reply == routing::BroadcastReply::echo ? std::optional(plan->echo())
                                                                       : std::nullopt;
}

namespace {

// Was the transaction carried out, as far as anybody knows?
bool may_have_worked(const drive::Device& device, const bus::Job& job, std::size_t at) {
  const bus::Transaction& transaction = job.transactions[at];
  return at < job.current ||
         (at == job.current && transaction.must_hold == nullptr && job.was_on_wire &&
          (!transaction.response || device.has_accepted(*transaction.response)));
}

// Whatever way it came: a drive that was set otherwise may be out of reach, or speak another order.
void report_reconfigured(const Exchange& exchange, const Exchange::Part& part,
                         const Settings& settings, ActionQueue& actions) {
  for (const drive::Device& device : settings.devices) {
    bool hit = false;
    bool by_value = true;
    for (std::size_t at = 0; device.bus == part.bus && at < part.job->transactions.size(); ++at) {
      const bus::Transaction& it = part.job->transactions[at];
      const bool heard = device.is_addressed_by(it.address, it.broadcast);
      if (heard && device.is_reconfigured_by(it.request) &&
          may_have_worked(device, *part.job, at)) {
        hit = true;
        by_value =
            by_value && !drive::touches(device.profile.communication, it.request.writes()->range);
      }
    }
    if (hit) {
      actions.push(Report{Reconfigured{device.bus, device.address, exchange.address, by_value}});
    }
  }
}

}  // namespace

bool means_otherwise(const Exchange& exchange, const Exchange::Part& part,
                     const SettingsSnapshot& old, const SettingsSnapshot& next) {
  if (!exchange.client_gone && !next.settings.listener(exchange.listener).is_gone) {
    return unit_means_otherwise({exchange.listener, exchange.header.unit}, old, next, part.bus);
  }
  return part.job->is_broadcast()
             ? has_other_devices(old, next, part.bus)
             : is_other_device(old, next, part.bus, part.job->transactions.front().unit);
}

void report_effects(const Exchange& exchange, const Exchange::Part& part, bus::Ending ending,
                    const Settings& settings, ActionQueue& actions) {
  if (!exchange.plan || settings.bus(part.bus).is_gone) {
    return;  // nobody knows the bus any more
  }
  const bus::Job& job = *part.job;
  if (ending == bus::Ending::mismatched) {
    actions.push(Report{WordOrderDiffers{part.bus, job.transactions[job.current].address}});
  }
  if (exchange.plan->is_read()) {
    return;
  }
  const bool done = ending == bus::Ending::transmitted ||
                    (ending == bus::Ending::answered && job.current == job.transactions.size());
  const std::uint8_t address = job.transactions.front().address;
  if (job.was_on_wire) {
    report_reconfigured(exchange, part, settings, actions);
  }
  const std::size_t begin = job.transactions.front().must_hold != nullptr ? 1 : 0;
  const auto& last = job.transactions.back().request.writes();
  if (!done && job.current > begin && last && !job.is_broadcast()) {
    const std::uint16_t first = job.transactions[begin].request.writes()->range.first;
    const auto& failed = job.transactions[job.current].request.writes()->range;
    actions.push(Report{WriteEndedEarly{part.bus, address, failed.table, first, failed.first,
                                        drive::end_of(last->range)}});
  }
}

}  // namespace mbgate::gateway
