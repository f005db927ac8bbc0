// SPDX-License-Identifier: Apache-2.0
// Drives that hear broadcasts, and a plant in which a request to all is planned.
#pragma once

#include "device_rig.hpp"
#include "routing/route_table.hpp"

namespace mbgate::test {

using drive::BroadcastForm;
using routing::BusId;
using routing::ListenerId;

inline drive::Device aic(std::uint8_t address = 17) {
  drive::Device device;
  device.name = "turntable";
  device.address = address;
  device.word_order = WordOrder::big;
  device.profile.name = "autonics-aic";
  device.profile.broadcast = {
      BroadcastForm{129, 0x80}, 2,
      drive::RangeList{{Table::coils, 10, 17}, {Table::holding_registers, 50, 20}}};
  device.profile.values.add({Table::holding_registers, 60});
  return device;
}

inline drive::Device moons(std::uint8_t address, std::optional<WordOrder> order) {
  drive::Device device;
  device.name = "axis";
  device.address = address;
  device.word_order = order;
  device.profile.name = "moons-st";
  device.profile.functions = std::bitset<128>().set(3).set(6).set(16);
  device.profile.values.add({Table::holding_registers, 30});
  device.profile.communication = {{Table::holding_registers, 5, 1}};
  return device;
}

class Broadcasts : public testing::Test {
 protected:
  /// Form and PDU of what is sent, or the exception.
  Texts sent(std::string_view request, std::uint8_t unit = 0) {
    const routing::RouteTable table(listeners, routes, devices);
    const routing::ResolvedRoute* resolved = table.find(ListenerId{0}, unit);
    if (resolved == nullptr) {
      return {"no resolved"};
    }
    const auto plan = routing::Plan::make(*resolved, unit, {}, pdu(request));
    if (!plan) {
      return {modbus::exception_text(static_cast<std::uint8_t>(plan.error()))};
    }
    Texts texts;
    for (const auto& transaction : plan->transactions()) {
      texts.push_back(std::to_string(transaction.address) +
                      (transaction.broadcast == BroadcastForm{129, 0x80} ? " OR 80: " : ": ") +
                      hex(transaction.request.pdu().bytes()));
    }
    return texts;
  }
  static routing::Route broadcast_route(std::optional<WordOrder> order = {}) {
    routing::Route route;
    route.buses = {BusId{0}};
    route.word_order = order;
    return route;
  }

  std::vector<routing::ListenerKind> listeners{1};
  std::vector<drive::Device> devices;
  std::vector<routing::Route> routes{broadcast_route()};
};

}  // namespace mbgate::test
