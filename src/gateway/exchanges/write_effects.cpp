// SPDX-License-Identifier: Apache-2.0
#include "gateway/exchanges/exchange.hpp"

namespace mbgate::gateway {
namespace {

// Was the transaction carried out, as far as anybody knows?
bool may_have_worked(const bus::Job& job, std::size_t at) {
  const bus::Transaction& transaction = job.transactions[at];
  return at < job.current ||
         (at == job.current && transaction.must_hold == nullptr && job.was_on_wire &&
          !(transaction.response && transaction.response->is_exception()));
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
      if (heard && device.is_reconfigured_by(it.request) && may_have_worked(*part.job, at)) {
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
