// SPDX-License-Identifier: Apache-2.0
// From the bytes of one connection to its requests.
#include "gateway/clients/intake.hpp"

#include <gtest/gtest.h>

#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::Intake;
using gateway::Request;

class IntakeAlone : public testing::Test {
 protected:
  void come(std::string_view bytes) {
    session_.input.append(unhex(bytes), Instant{1s}, Instant{1s});
  }
  bool has_nothing() {
    const Intake::Front front = intake_.front(session_);
    return !front.frame && !front.framing_lost;
  }
  Request request() { return intake_.take(session_, *intake_.front(session_).frame, Instant{1s}); }

  SettingsHistory settings_{stop_plant(1)};
  gateway::WriteRules rules_{settings_.in_force()};
  ActionQueue actions_;
  Intake intake_{settings_, rules_, actions_};
  ClientSession session_{ClientId{1}, info_of("192.0.2.1"), settings_.settings().listeners[0],
                         Instant{1s}};
};

TEST_F(IntakeAlone, GivesOneRequestAfterTheOtherAndSkipsOtherProtocols) {
  come("0001 0000 0006 01 03 0000 0001  0002 0001 0002 01 02  0003 0000 0006 02 06 0000 0001");
  const auto read = request();
  EXPECT_TRUE(read.plan && read.plan->is_read());
  const auto write = request();
  EXPECT_EQ(write.adu.header.transaction, 3);
  EXPECT_TRUE(has_nothing());
  EXPECT_EQ(intake_.counters().requests, 2U);
  EXPECT_EQ(intake_.counters().foreign_adus, 1U);
}

TEST_F(IntakeAlone, SaysWhyARequestIsRefused) {
  come("0001 0000 0006 FA 03 0000 0001  0002 0000 0002 01 64");
  EXPECT_EQ(request().refused, modbus::ExceptionCode::gateway_path_unavailable);
  EXPECT_EQ(reports<gateway::UnitNotRouted>(actions_).size(), 1U);
  intake_.set_phase(gateway::Phase::only_stops);
  come("0003 0000 0006 01 06 0000 0001  0004 0000 0006 01 06 007C 00E1");
  static_cast<void>(request());
  EXPECT_EQ(request().refused, modbus::ExceptionCode::server_device_busy);
  EXPECT_EQ(request().refused, std::nullopt);
}

TEST_F(IntakeAlone, OfAClientThatLeavesOnlyStopsAreTaken) {
  come(
      "0001 0000 0006 01 06 0000 0001  0002 0000 0006 01 06 007C 00E1  0003 0000 0006 01 03 0000 "
      "01");
  session_.is_leaving = true;
  const Request* stop = intake_.take_stop(session_, Instant{1s});
  ASSERT_NE(stop, nullptr);
  EXPECT_EQ(stop->adu.header.transaction, 2);
  EXPECT_EQ(intake_.take_stop(session_, Instant{1s}), nullptr);
  EXPECT_EQ(intake_.counters().requests, 1U);
}

TEST_F(IntakeAlone, EndsWhereFramingIsLost) {
  come("0001 0000 FFFF 01 03 0000 0001");
  EXPECT_TRUE(intake_.front(session_).framing_lost);
  EXPECT_EQ(reports<gateway::ClientFramingLost>(actions_).size(), 1U);
}

TEST_F(IntakeAlone, SaysWhatAStreamLooksLike) {
  come("3A 30 31 30 33 30 30");
  EXPECT_TRUE(intake_.front(session_).framing_lost);
  const auto lost = reports<gateway::ClientFramingLost>(actions_);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].sends, "Modbus ASCII");
}

TEST_F(IntakeAlone, SaysThatFramingIsLostOnlyIfItDoesNotLookLikeRtu) {
  come("0B 06 00 1D 01 2C 19 2B");
  EXPECT_TRUE(intake_.front(session_).framing_lost);
  EXPECT_EQ(reports<gateway::ClientSpeaksRtu>(actions_).size(), 1U);
}

}  // namespace
}  // namespace mbgate::test
