// SPDX-License-Identifier: Apache-2.0
// Talking to simulated drives in hexadecimal.
#pragma once

#include <string>
#include <string_view>

#include "modbus/pdu.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

inline modbus::Pdu pdu_of(std::string_view text) { return *modbus::Pdu::from(unhex(text)); }

/// The drive's response to a request PDU; "silence" if it has none.
template <typename Drive>
std::string answer_of(Drive& drive, std::string_view request) {
  const auto reaction = drive.answer(pdu_of(request));
  return reaction.response ? hex(reaction.response->bytes()) : "silence";
}

}  // namespace mbgate::test
