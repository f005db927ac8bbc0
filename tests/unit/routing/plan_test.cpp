// SPDX-License-Identifier: Apache-2.0
#include "routing/plan.hpp"

#include <gtest/gtest.h>

#include <array>
#include <initializer_list>

#include "routing/route.hpp"
#include "routing/route_table.hpp"
#include "support/hex.hpp"
#include "support/plan_answer.hpp"

namespace mbgate::test {
namespace {

using modbus::ExceptionCode;
using routing::BusId;
using routing::ListenerId;
using routing::Route;

constexpr auto kHolding = modbus::Table::holding_registers;

modbus::Pdu pdu(std::string_view text) { return *modbus::Pdu::from(unhex(text)); }

Route window_route() {
  Route route;
  route.first_unit = route.last_unit = 11;
  route.first_address = 1;
  route.buses = {BusId{0}};
  route.functions = routing::FunctionRules::rewritable();
  route.windows = {{kHolding, 1000, 600, kHolding, 100}};
  return route;
}

std::string on_the_bus(const Route& route, std::string_view request) {
  const auto plan = routing::Plan::make(routing::ResolvedRoute{route}, 11, {}, pdu(request));
  return plan ? hex(plan->transactions()[0].request.pdu().bytes())
              : modbus::exception_text(static_cast<std::uint8_t>(plan.error()));
}

std::string answer(const routing::Plan& plan, std::string_view response) {
  return hex(answer_of(plan, std::array{pdu(response)}).bytes());
}

TEST(Plan, MovesTheAddressesOfEveryFunctionThatHasOne) {
  const Route route = window_route();
  EXPECT_EQ(on_the_bus(route, "03 03E8 0002"), "03 00 64 00 02");
  EXPECT_EQ(on_the_bus(route, "06 03E9 1234"), "06 00 65 12 34");
  EXPECT_EQ(on_the_bus(route, "10 03E8 0001 02 1234"), "10 00 64 00 01 02 12 34");
  EXPECT_EQ(on_the_bus(route, "16 03E8 00F2 0025"), "16 00 64 00 F2 00 25");
  EXPECT_EQ(on_the_bus(route, "17 03E8 0001 03E9 0001 02 00FF"),
            "17 00 64 00 01 00 65 00 01 02 00 FF");
  EXPECT_EQ(on_the_bus(route, "18 03E8"), "18 00 64");
}

TEST(Plan, RefusesWhatLiesNotWhollyInTheWindow) {
  const Route route = window_route();
  const auto outside = modbus::exception_text(2);
  EXPECT_EQ(on_the_bus(route, "03 03E7 0001"), outside);
  EXPECT_EQ(on_the_bus(route, "03 063F 0002"), outside);
  EXPECT_EQ(on_the_bus(route, "03 063F 0001"), "03 02 BB 00 01");
  EXPECT_EQ(on_the_bus(route, "17 03E8 0001 0000 0001 02 00FF"), outside);
  EXPECT_EQ(on_the_bus(route, "17 0000 0001 03E8 0001 02 00FF"), outside);
  EXPECT_EQ(on_the_bus(route, "04 03E8 0001"), outside);
  EXPECT_EQ(on_the_bus(route, "01 03E8 0001"), outside);
  EXPECT_EQ(on_the_bus(route, "2B 0E 01 00"), modbus::exception_text(1));
}

TEST(Plan, GivesTheClientItsOwnAddressesBack) {
  const auto plan = routing::Plan::make(routing::ResolvedRoute{window_route()}, 11, {},
                                        pdu("10 03E8 0001 02 1234"));
  ASSERT_TRUE(plan);
  EXPECT_EQ(answer(*plan, "10 0064 0001"), "10 03 E8 00 01");
  EXPECT_EQ(answer(*plan, "90 03"), "90 03");
  EXPECT_EQ(hex(plan->echo().bytes()), "10 03 E8 00 01");
}

TEST(Plan, AWindowMayReachTheLastAddress) {
  Route route = window_route();
  route.windows = {{kHolding, 0, 65536, kHolding, 0}};
  EXPECT_EQ(on_the_bus(route, "03 FFFF 0001"), "03 FF FF 00 01");
  EXPECT_EQ(on_the_bus(route, "03 FFFF 0002"), modbus::exception_text(2));
}

TEST(Plan, WindowsLeadToOtherTables) {
  constexpr auto kInput = modbus::Table::input_registers;
  constexpr auto kCoils = modbus::Table::coils;
  Route route = window_route();
  route.windows = {{kHolding, 0, 10, kHolding, 100},
                   {kHolding, 1000, 10, kInput, 5},
                   {kInput, 0, 10, kHolding, 200},
                   {kCoils, 0, 16, modbus::Table::discrete_inputs, 32}};
  EXPECT_EQ(on_the_bus(route, "03 0000 0002"), "03 00 64 00 02");
  EXPECT_EQ(on_the_bus(route, "03 03E8 0002"), "04 00 05 00 02");
  EXPECT_EQ(on_the_bus(route, "04 0001 0001"), "03 00 C9 00 01");
  EXPECT_EQ(on_the_bus(route, "01 0003 0008"), "02 00 23 00 08");
  // What lies in two windows lies in none.
  EXPECT_EQ(on_the_bus(route, "03 0009 0002"), modbus::exception_text(2));
  // Nobody writes input registers or discrete inputs.
  EXPECT_EQ(on_the_bus(route, "06 03E8 0001"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "05 0000 FF00"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "17 03E8 0001 0000 0001 02 00FF"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "17 0000 0001 0001 0001 02 00FF"),
            "17 00 64 00 01 00 65 00 01 02 00 FF");
}

TEST(Plan, AnswersWithTheFunctionThatTheClientAskedFor) {
  Route route = window_route();
  route.windows = {{kHolding, 1000, 10, modbus::Table::input_registers, 5},
                   {modbus::Table::coils, 0, 16, modbus::Table::discrete_inputs, 32}};
  const auto registers =
      routing::Plan::make(routing::ResolvedRoute{route}, 11, {}, pdu("03 03E8 0002"));
  EXPECT_EQ(answer(*registers, "04 04 0001 0002"), "03 04 00 01 00 02");
  EXPECT_EQ(answer(*registers, "84 02"), "83 02");
  const auto bits = routing::Plan::make(routing::ResolvedRoute{route}, 11, {}, pdu("01 0003 000A"));
  EXPECT_EQ(answer(*bits, "02 02 CD 01"), "01 02 CD 01");
}

TEST(Plan, ReadOnlyRoutesAndClientsMayOnlyRead) {
  Route route = window_route();
  route.access = routing::Access::read_only;
  EXPECT_EQ(on_the_bus(route, "06 03E8 0001"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "17 03E8 0001 03E8 0001 02 00FF"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "03 03E8 0001"), "03 00 64 00 01");
  const auto plan =
      routing::Plan::make(routing::ResolvedRoute{window_route()}, 11, {true}, pdu("06 03E8 0001"));
  EXPECT_EQ(plan.error(), ExceptionCode::illegal_function);
}

TEST(FunctionRules, OfAWindowAreThoseThatItCanRewrite) {
  const auto rules = routing::FunctionRules::rewritable();
  std::vector<std::size_t> allowed;
  for (std::size_t function = 0; function < rules.allowed.size(); ++function) {
    if (rules.allowed.test(function)) {
      allowed.push_back(function);
    }
  }
  EXPECT_EQ(allowed, (std::vector<std::size_t>{1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 24}));
}

// Its answer has another form than that of the other diagnostics, and would be taken for no answer.
TEST(Plan, RefusesTheStatisticsOfModbusPlus) {
  Route route = window_route();
  route.functions = routing::FunctionRules::all();
  route.windows.clear();
  EXPECT_EQ(on_the_bus(route, "08 0014 0000"), "08 00 14 00 00");
  EXPECT_EQ(on_the_bus(route, "08 0015 0003"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "08 0015 0004"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "08 0016 0000"), "08 00 16 00 00");
}

TEST(Plan, ANamedDiagnosticPassesAndNoOther) {
  using routing::FunctionRules;
  const auto denied = modbus::exception_text(1);
  Route route = window_route();
  route.windows.clear();
  const std::array named = {std::pair("08 0001 0000", &FunctionRules::restart_communications),
                            std::pair("08 0003 3B00", &FunctionRules::change_delimiter),
                            std::pair("08 0004 0000", &FunctionRules::force_listen_only)};
  for (const auto& [request, rule] : named) {
    route.functions = {};
    route.functions.allowed.set(3);
    EXPECT_FALSE(route.functions.codes().test(8));
    EXPECT_EQ(on_the_bus(route, request), denied);
    route.functions.*rule = true;
    EXPECT_TRUE(route.functions.codes().test(8));
    for (const auto* asked : {"08 0000 0000", "08 000A 0000", "08 0001 0000", "08 0003 3B00",
                              "08 0004 0000", "08 0015 0003"}) {
      EXPECT_EQ(on_the_bus(route, asked) != denied, asked == std::string_view(request)) << asked;
    }
  }
}

// Nobody knows which it would have been.
TEST(Plan, ADiagnosticThatEndsWithinItsSubFunctionIsMalformedAndNotForbidden) {
  Route route = window_route();
  route.functions.allowed.set(8);
  EXPECT_EQ(on_the_bus(route, "08 0004 0000"), modbus::exception_text(1));
  EXPECT_EQ(on_the_bus(route, "08 00"), modbus::exception_text(3));
}

TEST(RouteTable, MapsRangesOfUnitsToAddresses) {
  Route range;
  range.first_unit = 100;
  range.last_unit = 131;
  range.first_address = 1;
  range.buses = {BusId{0}};
  const std::vector<routing::ListenerKind> listeners(1);
  const routing::RouteTable table(listeners, std::vector{range}, {});
  EXPECT_EQ(table.find(ListenerId{0}, 99), nullptr);
  EXPECT_EQ(table.find(ListenerId{0}, 132), nullptr);
  const routing::ResolvedRoute* found = table.find(ListenerId{0}, 131);
  ASSERT_NE(found, nullptr);
  const auto plan = routing::Plan::make(*found, 131, {}, pdu("03 0000 0001"));
  EXPECT_EQ(plan->transactions()[0].address, 32);
}

TEST(RouteTable, ARouteOfTheListenerGoesBeforeOneOfAll) {
  Route any;
  any.first_unit = any.last_unit = any.first_address = 5;
  any.buses = {BusId{0}};
  Route own = any;
  own.listener = ListenerId{1};
  own.buses = {BusId{1}};
  const std::vector<routing::ListenerKind> listeners(2);
  const routing::RouteTable table(listeners, std::vector{own, any}, {});
  EXPECT_EQ(table.find(ListenerId{0}, 5)->route.buses[0], BusId{0});
  EXPECT_EQ(table.find(ListenerId{1}, 5)->route.buses[0], BusId{1});
}

TEST(RouteTable, TransparentListenersHaveRoutesOfTheirOwnOnly) {
  Route any;
  any.first_unit = any.last_unit = 250;
  any.first_address = 5;
  any.buses = {BusId{0}};
  const std::vector<routing::ListenerKind> listeners{{BusId{1}, true, {}}};
  const routing::RouteTable table(listeners, std::vector{any}, {});
  EXPECT_EQ(table.find(ListenerId{0}, 250), nullptr);
  EXPECT_TRUE(table.find(ListenerId{0}, 0)->is_broadcast());
  EXPECT_EQ(table.find(ListenerId{0}, 247)->route.buses[0], BusId{1});
}

TEST(RouteTable, TransparentListenersPassAReservedAddressIfADeviceHasIt) {
  std::vector<drive::Device> devices(3);
  for (std::size_t at = 0; at < devices.size(); ++at) {
    devices[at].bus = BusId{1};
    devices[at].address = static_cast<std::uint8_t>(253 + at);
  }
  devices[0].bus = BusId{0};
  const std::vector<routing::ListenerKind> listeners{{BusId{1}, false, {}}};
  const routing::RouteTable table(listeners, {}, devices);
  EXPECT_EQ(table.find(ListenerId{0}, 253), nullptr);  // of another bus
  const routing::ResolvedRoute* found = table.find(ListenerId{0}, 254);
  ASSERT_NE(found, nullptr);
  const auto plan = routing::Plan::make(*found, 254, {}, pdu("03 0000 0001"));
  EXPECT_EQ(plan->transactions()[0].address, 254);
  EXPECT_EQ(table.find(ListenerId{0}, 255), nullptr);  // the gateway
}

/// Does a route that lets these functions through count as one that may write?
bool may_write(std::initializer_list<std::size_t> functions) {
  Route route;
  route.functions = {};
  for (const std::size_t function : functions) {
    route.functions.allowed.set(function);
  }
  return route.may_write();
}

TEST(Route, LeadsToTheDeviceOfItsBusAtItsAddress) {
  routing::ResolvedRoute resolved;
  resolved.route.first_unit = 11;
  resolved.route.last_unit = 12;
  resolved.route.first_address = 5;
  resolved.route.buses = {BusId{1}};
  const auto leads_to = [&](std::uint8_t unit, std::uint32_t bus, std::uint8_t address) {
    return resolved.leads_to({"axis", BusId{bus}, address, {}}, unit);
  };
  EXPECT_TRUE(leads_to(11, 1, 5));
  EXPECT_FALSE(leads_to(11, 1, 6));
  EXPECT_TRUE(leads_to(12, 1, 6));
  EXPECT_FALSE(leads_to(11, 0, 5));
  resolved.devices_of_buses.emplace_back();
  EXPECT_TRUE(leads_to(11, 1, 6));
  EXPECT_FALSE(leads_to(11, 0, 5));
}

TEST(Route, MayWriteByWhateverIsNoRead) {
  EXPECT_TRUE(may_write({3, 6}));
  EXPECT_TRUE(may_write({3, 0x15}));  // file records
  EXPECT_TRUE(may_write({3, 0x65}));  // a maker's own
  EXPECT_TRUE(may_write({0x7F}));
  EXPECT_FALSE(may_write({1, 2, 3, 4, 7, 11, 12, 17, 20, 24}));
  EXPECT_FALSE(may_write({3, 8, 43}));  // diagnosis sets nothing going
  EXPECT_FALSE(may_write({}));
  Route reading;
  EXPECT_TRUE(reading.may_write());
  reading.access = routing::Access::read_only;
  EXPECT_FALSE(reading.may_write());
}

}  // namespace
}  // namespace mbgate::test
