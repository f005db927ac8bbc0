// SPDX-License-Identifier: Apache-2.0
// The answer of a plan to responses of its device, without a bus.
#pragma once

#include <span>
#include <vector>

#include "routing/plan.hpp"

namespace mbgate::test {

/// `responses`: to the client's own transactions, in their order, as far as there are any.
inline modbus::Pdu answer_of(const routing::Plan& plan, std::span<const modbus::Pdu> responses) {
  std::vector<drive::Transaction> done(plan.transactions().begin(), plan.transactions().end());
  auto next = responses.begin();
  for (drive::Transaction& transaction : done) {
    if (transaction.must_hold == nullptr && next != responses.end()) {
      transaction.response = *next++;
    }
  }
  return plan.answer(done);
}

}  // namespace mbgate::test
