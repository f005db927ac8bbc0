// SPDX-License-Identifier: Apache-2.0
// Drives on Ethernet, with the ADUs of MOONS' manual.
#include "sim/wire/tcp_bus.hpp"

#include <gmock/gmock.h>

#include "manuals/vectors.hpp"
#include "support/hex.hpp"

namespace mbgate::test::tcp_bus_test {
namespace {

using namespace std::chrono_literals;
using bus::Instant;
using sim::DeviceSettings;
using sim::Duration;
using sim::ModelKind;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kReadStatus = "00 07 00 00 00 06 FF 03 00 01 00 01";
constexpr auto kStatus = "00 07 00 00 00 05 FF 03 02 00 09";

class TcpDrives : public testing::Test {
 protected:
  explicit TcpDrives(std::vector<DeviceSettings> devices = {{.address = 255}, {.address = 1}})
      : bus_(devices, true) {}

  bool receive(sim::ConnectionId connection, std::string_view bytes, Duration at = 0ms) {
    return bus_.receive(connection, unhex(bytes), Instant(at));
  }
  /// All that is sent from now on: connection, time and bytes.
  std::vector<std::string> run() {
    std::vector<std::string> sent;
    while (const auto at = bus_.next_event()) {
      for (const sim::TcpResponse& response : bus_.advance(*at)) {
        const auto milliseconds = (*at).time_since_epoch() / 1ms;
        sent.push_back(std::to_string(response.connection) + " at " + std::to_string(milliseconds) +
                       ": " + hex({response.bytes.data(), response.bytes.size()}));
      }
    }
    return sent;
  }

  sim::TcpBus bus_;
};

TEST_F(TcpDrives, AnswerAfterTheirProcessingTime) {
  EXPECT_TRUE(receive(3, kReadStatus, 10ms));
  EXPECT_THAT(run(), ElementsAre(std::string("3 at 11: ") + kStatus));
  EXPECT_EQ(bus_.counters(), (sim::TcpBusCounters{.requests = 1, .answers = 1}));
}

TEST_F(TcpDrives, TakeRequestsInPartsAndPipelined) {
  EXPECT_TRUE(receive(1, "00 01 00 00 00 06 FF"));
  EXPECT_THAT(run(), IsEmpty());
  EXPECT_TRUE(receive(1, "03 00 1B 00 01 00 02 00 00 00 06 FF 03 00 1C 00 01 00 03 00"));
  EXPECT_TRUE(receive(2, "00 09 00 00 00 06 01 03 00 01 00 01"));
  EXPECT_TRUE(receive(1, "00 00 06 FF 06 00 7C 00 01"));
  EXPECT_THAT(run(), ElementsAre("1 at 1: 00 01 00 00 00 05 FF 03 02 00 F0",
                                 "2 at 1: 00 09 00 00 00 05 01 03 02 00 09",
                                 "1 at 2: 00 02 00 00 00 05 FF 03 02 00 F0",
                                 "1 at 3: 00 03 00 00 00 03 FF 86 13"));
}

TEST_F(TcpDrives, AnswerTheirOwnUnitOnly) {
  EXPECT_TRUE(receive(1, "00 01 00 00 00 06 02 03 00 01 00 01"));
  EXPECT_TRUE(receive(1, "00 02 00 00 00 06 00 06 00 1B 00 07"));  // no broadcast either
  EXPECT_THAT(run(), IsEmpty());
  EXPECT_EQ(bus_.device(255)->drive<sim::MoonsDrive>()->registers().get(0x001B), 240U);
  EXPECT_EQ(bus_.counters(), (sim::TcpBusCounters{.requests = 2, .answers = 0}));
}

TEST_F(TcpDrives, SkipForeignProtocolsAndRefuseLostFraming) {
  EXPECT_TRUE(receive(1, std::string("00 01 00 05 00 03 FF 03 00 ") + kReadStatus));
  EXPECT_THAT(run(), ElementsAre(std::string("1 at 1: ") + kStatus));
  EXPECT_FALSE(receive(1, "00 01 00 00 00 01 FF"));
}

TEST_F(TcpDrives, ForgetWhatNobodyWaitsFor) {
  EXPECT_TRUE(receive(1, std::string(kReadStatus) + " 00 01"));
  EXPECT_TRUE(receive(2, kReadStatus));
  bus_.forget(1);
  EXPECT_THAT(run(), ElementsAre(std::string("2 at 2: ") + kStatus));
  EXPECT_TRUE(receive(1, kReadStatus, 5ms));
  bus_.forget_all();
  EXPECT_THAT(run(), IsEmpty());
}

TEST_F(TcpDrives, HaveFaultsWhenTold) {
  bus_.device(255)->set_faults({.silent = true});
  bus_.device(1)->set_faults({.answer_after = 40ms, .wrong_unit = true});
  EXPECT_TRUE(receive(1, kReadStatus));
  EXPECT_TRUE(receive(1, "00 08 00 00 00 06 01 03 00 01 00 01"));
  EXPECT_THAT(run(), ElementsAre("1 at 40: 00 08 00 00 00 05 02 03 02 00 09"));
}

class UnitZero : public TcpDrives {
 protected:
  UnitZero() : TcpDrives({{.address = 0}}) {}
};

TEST_F(UnitZero, IsAUnitLikeAnyOther) {
  EXPECT_TRUE(receive(1, "00 02 00 00 00 06 00 06 00 1B 00 07"));
  EXPECT_THAT(run(), ElementsAre("1 at 1: 00 02 00 00 00 06 00 06 00 1B 00 07"));
}

class PrintedUnits : public TcpDrives {
 protected:
  PrintedUnits()
      : TcpDrives(
            {{.address = 1, .series = sim::MoonsSeries::m3}, {.address = 10}, {.address = 11}}) {}
};

TEST_F(PrintedUnits, AnswerThePrintedWritesAsPrinted) {
  unsigned compared = 0;
  for (const auto& [request, response] : manuals::load_transactions()) {
    // Section 7.3 is about an M3; two of its examples have the low word first.
    const bool homing = request.line >= 586 && request.line <= 680;
    const bool little = request.line == 621 || request.line == 667;
    const bool known = (request.rtu[0] != 1 || homing) && !little;
    if (!known || !response) {
      continue;
    }
    EXPECT_TRUE(bus_.receive(1, request.tcp, Instant{}));
    const auto sent = bus_.advance(Instant(1h));
    ASSERT_EQ(sent.size(), 1U) << request.where();
    EXPECT_EQ(hex({sent[0].bytes.data(), sent[0].bytes.size()}), hex(response->tcp))
        << request.where();
    ++compared;
  }
  EXPECT_GE(compared, 5U);
}

}  // namespace
}  // namespace mbgate::test::tcp_bus_test
