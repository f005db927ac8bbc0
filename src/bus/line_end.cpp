// SPDX-License-Identifier: Apache-2.0
#include "bus/line_end.hpp"

#include <algorithm>

namespace mbgate::bus {

OwedAnswers::iterator first_fit(OwedAnswers& owed, const modbus::Pdu& response) {
  return std::ranges::find_if(owed, [&](const OwedAnswer& it) {
    return is_fitting(modbus::check_response(it.asked, response.bytes()));
  });
}

std::string_view to_text(LineState state) {
  switch (state) {
    case LineState::initial: return "initial";
    case LineState::idle: return "idle";
    case LineState::emission: return "emission";
    case LineState::waiting_for_reply: return "waiting for reply";
    case LineState::waiting_turnaround_delay: return "waiting turnaround delay";
    case LineState::draining: return "draining";
  }
  return "";
}

}  // namespace mbgate::bus
