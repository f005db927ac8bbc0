// SPDX-License-Identifier: Apache-2.0
// A request planned for one device, and answered by it.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "routing/plan.hpp"
#include "support/hex.hpp"
#include "support/plan_answer.hpp"

namespace mbgate::test {

using drive::WordOrder;
using modbus::Table;

inline modbus::Pdu pdu(std::string_view text) { return *modbus::Pdu::from(unhex(text)); }

inline const std::string kNotAllowed = modbus::exception_text(1);
inline const std::string kIllegalAddress = modbus::exception_text(2);
inline const std::string kIllegalValue = modbus::exception_text(3);

/// A drive with 32-bit values at 4, 6, 10 and 20 and a 64-bit one at 30; writing 20 starts motion.
inline drive::Device small_drive(std::optional<WordOrder> order = WordOrder::little) {
  drive::Device device;
  device.name = "axis";
  device.word_order = order;
  for (const auto& [first, registers, motion] :
       {std::tuple{4, 2, false}, {6, 2, false}, {10, 2, false}, {20, 2, true}, {30, 4, false}}) {
    device.profile.values.add({Table::holding_registers, static_cast<std::uint16_t>(first),
                               static_cast<std::uint8_t>(registers), motion});
  }
  return device;
}

struct Planned {
  explicit Planned(const drive::Device& to, std::string_view request,
                   std::optional<WordOrder> seen = WordOrder::big)
      : plan(make(to, request, seen)) {}

  static Result<routing::Plan, modbus::ExceptionCode> make(const drive::Device& device,
                                                           std::string_view request,
                                                           std::optional<WordOrder> seen) {
    routing::ResolvedRoute resolved;
    resolved.device = &device;
    resolved.route.first_unit = resolved.route.last_unit = resolved.route.first_address = 1;
    resolved.route.buses = {device.bus};
    resolved.route.word_order = seen;
    return routing::Plan::make(resolved, 1, {}, pdu(request));
  }
  /// What goes on the bus, or the exception.
  [[nodiscard]] std::vector<std::string> requests() const {
    if (!plan) {
      return {modbus::exception_text(static_cast<std::uint8_t>(plan.error()))};
    }
    std::vector<std::string> texts;
    for (const auto& transaction : plan->transactions()) {
      texts.push_back(hex(transaction.request.pdu().bytes()));
    }
    return texts;
  }
  [[nodiscard]] std::string answer(const std::vector<std::string>& responses) const {
    std::vector<modbus::Pdu> pdus;
    pdus.reserve(responses.size());
    for (const auto& response : responses) {
      pdus.push_back(pdu(response));
    }
    return hex(answer_of(*plan, pdus).bytes());
  }

  Result<routing::Plan, modbus::ExceptionCode> plan;
};

using Texts = std::vector<std::string>;

}  // namespace mbgate::test
