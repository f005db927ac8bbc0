// SPDX-License-Identifier: Apache-2.0
// One unit-0 write in every form that the devices on a bus use.
#include <algorithm>

#include "broadcast_rig.hpp"
#include "routing/device_plan.hpp"

namespace mbgate::test {
namespace {

TEST_F(Broadcasts, UnknownDevicesHearTheStandardForm) {
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  EXPECT_EQ(sent("03 0001 0002"), Texts{kNotAllowed});
}

TEST_F(Broadcasts, GoOutOnceInEveryFormThatIsUsed) {
  routes[0].broadcast_mixed = true;
  devices = {moons(1, WordOrder::little), moons(2, WordOrder::little), aic()};
  EXPECT_EQ(sent("06 0034 0002"), (Texts{"0: 06 00 34 00 02", "129 OR 80: 06 00 34 00 02"}));
  // Coils are none of the MOONS', these registers none of the AiC's.
  EXPECT_EQ(sent("05 000B FF00"), Texts{"129 OR 80: 05 00 0B FF 00"});
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  EXPECT_EQ(sent("10 0033 0003 06 0001 0002 0003"),
            Texts{"0: 10 00 33 00 03 06 00 01 00 02 00 03"});
  EXPECT_EQ(sent("05 0001 FF00"), Texts{kIllegalAddress});
}

TEST_F(Broadcasts, TheAicTakesOnlyWhatItsManualLists) {
  devices = {aic()};
  EXPECT_EQ(sent("05 0009 FF00"), Texts{kIllegalAddress});
  EXPECT_EQ(sent("10 0033 0003 06 0001 0002 0003"), Texts{kIllegalAddress});
  EXPECT_EQ(sent("10 0033 0002 04 0001 0002"), Texts{"129 OR 80: 10 00 33 00 02 04 00 01 00 02"});
  EXPECT_EQ(sent("10 0031 0002 04 0001 0002"), Texts{kIllegalAddress}) << "one of them alone";
}

TEST_F(Broadcasts, AValueNeedsOneWordOrderAmongAllReceivers) {
  devices = {moons(1, WordOrder::little), moons(2, WordOrder::little)};
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{"0: 10 00 1E 00 02 04 00 01 00 02"});
  routes = {broadcast_route(WordOrder::big)};
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{"0: 10 00 1E 00 02 04 00 02 00 01"});
  EXPECT_EQ(sent("10 001E 0001 02 0001"), Texts{kIllegalValue});
  EXPECT_EQ(sent("06 001E 0001"), Texts{kIllegalValue});
  devices[1].word_order = WordOrder::big;
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{kIllegalValue});
  EXPECT_EQ(sent("10 001C 0002 04 0001 0002"), Texts{"0: 10 00 1C 00 02 04 00 01 00 02"});
  devices[0].word_order = devices[1].word_order = std::nullopt;
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{kIllegalValue});
}

TEST_F(Broadcasts, AValueMustBeOneToAllWhoHearIt) {
  devices = {aic(), moons(1, WordOrder::big)};
  devices[0].profile.broadcast.allowed->push_back({Table::holding_registers, 28, 8});
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{kIllegalValue});
  std::swap(devices[0], devices[1]);
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), Texts{kIllegalValue});
  devices[1].profile.values.add({Table::holding_registers, 30});
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"), (Texts{"0: 10 00 1E 00 02 04 00 01 00 02",
                                                      "129 OR 80: 10 00 1E 00 02 04 00 01 00 02"}));
}

TEST_F(Broadcasts, CommunicationRegistersAreRefused) {
  devices = {moons(1, {}), moons(2, {})};
  EXPECT_EQ(sent("06 0005 0001"), Texts{kNotAllowed});
  devices[0].allow_reconfigure = true;
  EXPECT_EQ(sent("06 0005 0001"), Texts{kNotAllowed});
  devices[1].allow_reconfigure = true;
  EXPECT_EQ(sent("06 0005 0001"), Texts{"0: 06 00 05 00 01"});
}

/// Some clients can only say unit 0.
TEST_F(Broadcasts, ARouteThatNamesADeviceIsNone) {
  devices = {moons(7, {}), aic()};
  routes[0].device = 0;
  routes[0].first_address = 7;
  EXPECT_EQ(sent("03 0001 0002"), Texts{"7: 03 00 01 00 02"});
  EXPECT_EQ(sent("06 0034 0002"), Texts{"7: 06 00 34 00 02"});
  // Nobody may broadcast here, though unit 0 has a way to the bus.
  routes.emplace_back();
  routes[1].buses = {BusId{0}};
  routes[1].first_unit = routes[1].last_unit = routes[1].first_address = 129;
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"no resolved"});
  devices = {moons(0, {})};  // a Modbus TCP server may have this address
  routes[0].first_address = 0;
  EXPECT_EQ(sent("03 0001 0002"), Texts{"0: 03 00 01 00 02"});
}

TEST_F(Broadcasts, TheAicsBroadcastAddressIsNoDevice) {
  listeners = {{BusId{0}}};
  devices = {aic(), moons(1, {})};
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"no resolved"});
  EXPECT_EQ(sent("05 000B FF00", 128), Texts{"128: 05 00 0B FF 00"});
  listeners[0].broadcast = true;
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"129 OR 80: 05 00 0B FF 00"});
  EXPECT_EQ(sent("06 0001 0001", 129), Texts{kIllegalAddress});
  EXPECT_EQ(sent("03 0001 0001", 129), Texts{kNotAllowed});
  listeners[0].broadcast_reply = routing::BroadcastReply::none;
  const routing::RouteTable table(listeners, routes, devices);
  EXPECT_EQ(table.find(ListenerId{0}, 129)->route.broadcast_reply, routing::BroadcastReply::none);
  devices = {moons(1, {})};
  EXPECT_EQ(sent("06 0001 0001", 129), Texts{"129: 06 00 01 00 01"});
}

TEST_F(Broadcasts, SoIsItOnARouteToTheBus) {
  routing::Route range;
  range.first_unit = range.first_address = 100;
  range.last_unit = 140;
  range.buses = {BusId{0}};
  devices = {aic()};
  routes = {range};
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"no resolved"});
  routes.push_back(broadcast_route());
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"129 OR 80: 05 00 0B FF 00"});
  routes[0].access = routing::Access::read_only;
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{kNotAllowed});
  routes[0].access = routing::Access::read_write;
  routes[1].access = routing::Access::read_only;
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{kNotAllowed}) << "who may not broadcast";
  routes[1].access = routing::Access::read_write;
  routes[1].buses = {BusId{1}};
  EXPECT_EQ(sent("05 000B FF00", 129), Texts{"no resolved"}) << "unit 0 is another bus";
}

TEST_F(Broadcasts, TheRouteToTheAicsBroadcastAddressKeepsItsWindowsAndFunctions) {
  routing::Route own;
  own.first_unit = own.last_unit = 29;
  own.first_address = 129;
  own.buses = {BusId{0}};
  own.functions.allowed = std::bitset<128>().set(5);
  own.windows = {{Table::coils, 0, 17, Table::coils, 10}};
  devices = {aic()};
  routes = {own, broadcast_route()};
  EXPECT_EQ(sent("05 000F FF00", 29), Texts{"129 OR 80: 05 00 19 FF 00"});
  EXPECT_EQ(sent("05 0011 FF00", 29), Texts{kIllegalAddress}) << "outside the window";
  EXPECT_EQ(sent("06 0034 0002", 29), Texts{kNotAllowed});
  routes[1].functions.allowed.reset(5);
  EXPECT_EQ(sent("05 000F FF00", 29), Texts{kNotAllowed}) << "who may not broadcast";
}

TEST_F(Broadcasts, TheAicsBroadcastAddressIsOnTheLineOfItsRouteAlone) {
  routing::Route range;
  range.first_unit = range.last_unit = range.first_address = 129;
  range.buses = {BusId{1}};
  devices = {aic()};
  devices[0].bus = BusId{1};
  routes = {range, broadcast_route()};
  routes[1].buses = {BusId{0}, BusId{1}};
  const routing::RouteTable table(listeners, routes, devices);
  const routing::ResolvedRoute* resolved = table.find(ListenerId{0}, 129);
  ASSERT_NE(resolved, nullptr);
  EXPECT_EQ(resolved->route.buses, std::vector{BusId{1}});
}

TEST_F(Broadcasts, SoIsItUnderWhateverUnit) {
  routing::Route range;
  range.first_address = 100;
  range.first_unit = 1;
  range.last_unit = 40;
  range.buses = {BusId{0}};
  devices = {aic()};
  routes = {range};
  EXPECT_EQ(sent("05 000B FF00", 30), Texts{"no resolved"});
  EXPECT_EQ(sent("05 000B FF00", 29), Texts{"128: 05 00 0B FF 00"});
}

TEST_F(Broadcasts, WhoeverMayListenIsAsked) {
  // At address 0 a drive without a stated form may hear what is meant for another.
  devices = {moons(1, {}), moons(2, {})};
  devices[1].profile.broadcast.form = std::nullopt;
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  devices[0].allow_reconfigure = true;
  EXPECT_EQ(sent("06 0005 0001"), Texts{kNotAllowed});
  devices[1].allow_reconfigure = true;
  EXPECT_EQ(sent("06 0005 0001"), Texts{"0: 06 00 05 00 01"});
  // A list of what may be broadcast protects a drive from what another takes.
  devices[1].profile.broadcast = {BroadcastForm{}, {}, drive::RangeList{}};
  EXPECT_EQ(sent("06 0001 0002"), Texts{kIllegalAddress});
}

TEST_F(Broadcasts, VerifiedReceiversAreAskedForTheirWordOrderFirst) {
  devices = {moons(1, WordOrder::little), moons(2, WordOrder::little)};
  devices[1].verify_word_order = true;
  devices[1].profile.word_order_register = drive::WordOrderRegister{5, {5}, {133}};
  routes = {broadcast_route(WordOrder::big)};
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"),
            (Texts{"2: 03 00 05 00 01", "0: 10 00 1E 00 02 04 00 02 00 01"}));
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  devices.push_back(devices[1]);  // and on each line
  devices[2].bus = BusId{1};
  devices[2].address = 3;
  routes[0].buses = {BusId{0}, BusId{1}};
  EXPECT_EQ(sent("10 001E 0002 04 0001 0002"),
            (Texts{"2: 03 00 05 00 01", "0: 10 00 1E 00 02 04 00 02 00 01", "3: 03 00 05 00 01",
                   "0: 10 00 1E 00 02 04 00 02 00 01"}));
}

TEST_F(Broadcasts, DevicesWhoseManualStatesNoneAreNotMeant) {
  devices = {moons(1, {})};
  devices[0].profile.broadcast.form = std::nullopt;
  EXPECT_EQ(sent("06 0001 0001"), Texts{kIllegalAddress});
}

TEST_F(Broadcasts, EveryDeviceOfTheBusMustHaveTheRegister) {
  devices = {moons(1, {}), aic()};
  EXPECT_EQ(sent("06 0001 0002"), Texts{kIllegalAddress}) << "none of the AiC's";
  EXPECT_EQ(sent("05 000B FF00"), Texts{kIllegalAddress}) << "none of the MOONS'";
  routes[0].broadcast_mixed = true;
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  routes[0].broadcast_mixed = false;
  devices = {moons(1, {})};
  devices[0].profile.map = {{Table::holding_registers, 0, 100}};
  EXPECT_EQ(sent("06 0064 0002"), Texts{kIllegalAddress});
}

TEST_F(Broadcasts, ARegisterMustMeanTheSameToAllWhoHearIt) {
  devices = {moons(1, {}), moons(2, {})};
  devices[1].profile.name = "moons-m3";
  EXPECT_EQ(sent("06 0001 0002"), Texts{kIllegalValue});
  routes[0].broadcast_mixed = true;
  EXPECT_EQ(sent("06 0001 0002"), Texts{"0: 06 00 01 00 02"});
  EXPECT_EQ(sent("06 001E 0001"), Texts{kIllegalValue}) << "half a value, all the same";
}

TEST_F(Broadcasts, AStopGoesInEveryFormThatCanCarryIt) {
  devices = {moons(1, WordOrder::big), moons(2, WordOrder::little), aic()};
  devices[1].profile.name = "moons-m3";
  devices[0].profile.stops = {{Table::holding_registers, 30, 0xFFFF, 0xE1}};
  devices[0].profile.values = {};
  devices[2].profile.stops = {{Table::coils, 11, 0xFFFF, 0xFF00}};
  EXPECT_EQ(sent("06 001E 00E1"), Texts{"0: 06 00 1E 00 E1"}) << "half a value of the other one";
  EXPECT_EQ(sent("06 001E 0066"), Texts{kIllegalAddress}) << "a feed";
  EXPECT_EQ(sent("05 000B FF00"), Texts{"129 OR 80: 05 00 0B FF 00"});
  devices[1].profile.communication = {{Table::holding_registers, 30, 1}};
  EXPECT_EQ(sent("06 001E 00E1"), Texts{kNotAllowed});
}

TEST_F(Broadcasts, TheParametersOfAStopAreInTheOrderOfTheDrives) {
  devices = {moons(1, WordOrder::little)};
  devices[0].profile.values = {};
  devices[0].profile.values.add({Table::holding_registers, 101});
  devices[0].profile.stops = {{Table::holding_registers, 100, 0xFFFF, 0, false, 2}};
  routes = {broadcast_route(WordOrder::big)};
  EXPECT_EQ(sent("10 0064 0003 06 0000 1111 2222"),
            Texts{"0: 10 00 64 00 03 06 00 00 22 22 11 11"});
  devices.push_back(devices[0]);
  devices[1].address = 2;
  devices[1].word_order = WordOrder::big;
  EXPECT_EQ(sent("10 0064 0003 06 0000 1111 2222"), Texts{"0: 10 00 64 00 03 06 00 00 11 11 22 22"})
      << "two orders, and it is never refused";
}

TEST_F(Broadcasts, WhatStopsOnlyADriveThatIsNotKnownToHearItIsNoStop) {
  devices = {moons(1, {}), moons(2, {})};
  devices[1].profile.name = "servo";
  devices[1].profile.stops = {{Table::holding_registers, 40, 0xFFFF, 1}};
  EXPECT_EQ(sent("06 0028 0001"), Texts{"0: 06 00 28 00 01"});
  devices[1].profile.broadcast.form = std::nullopt;
  EXPECT_EQ(sent("06 0028 0001"), Texts{kIllegalValue});
  devices[1].profile.broadcast = {BroadcastForm{9, 0}, {}, {}, false};
  EXPECT_EQ(sent("06 0028 0001"), (Texts{"0: 06 00 28 00 01", "9: 06 00 28 00 01"}))
      << "its manual says that it hears address 0 too";
}

TEST_F(Broadcasts, AStopIsNoWriteOnLinesWhereItStopsNobody) {
  devices = {moons(1, {}), moons(1, {})};
  devices[0].profile.stops = {{Table::holding_registers, 40, 0xFFFF, 0xE1}};
  devices[1].bus = BusId{1};
  devices[1].profile.name = "moons-m3";
  routes[0].buses = {BusId{0}, BusId{1}};
  EXPECT_EQ(sent("06 0028 00E1"), Texts{"0: 06 00 28 00 E1"});
}

TEST_F(Broadcasts, ItIsKnownWhomTheyAreNotFor) {
  devices = {moons(1, {}), moons(2, {}), aic()};
  devices[0].name = "axis-1";
  devices[1].profile.broadcast.form = std::nullopt;
  devices[1].name = "axis-2";
  devices[0].profile.stops = devices[1].profile.stops = {{Table::holding_registers, 40, 0xFFFF, 1}};
  routes[0].broadcast_mixed = true;
  const auto left_out = [this](std::string_view request, bool is_stop) {
    const routing::RouteTable table(listeners, routes, devices);
    const routing::ResolvedRoute& resolved = *table.find(ListenerId{0}, 0);
    const auto plan = routing::Plan::make(resolved, 0, {}, pdu(request));
    Texts names;
    for (const drive::Device* device : routing::not_addressed(resolved, *plan, is_stop)) {
      names.push_back(device->name);
    }
    return names;
  };
  EXPECT_EQ(left_out("06 0034 0002", false), Texts{"axis-2"}) << "its manual states no broadcasts";
  EXPECT_EQ(left_out("06 0028 0001", true), (Texts{"axis-2", "turntable"}));
}

}  // namespace
}  // namespace mbgate::test
