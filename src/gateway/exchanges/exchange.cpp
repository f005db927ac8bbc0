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
    case bus::Ending::answered: response = plan->answer(job.responses()); break;
    case bus::Ending::transmitted: break;
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

}  // namespace mbgate::gateway
