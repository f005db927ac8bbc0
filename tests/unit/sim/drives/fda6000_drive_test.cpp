// SPDX-License-Identifier: Apache-2.0
// Frames and rules of the HIGEN FDA6000's manual, without address and CRC.
#include "sim/drives/fda6000_drive.hpp"

#include <gtest/gtest.h>

#include <map>

#include "manuals/vectors.hpp"
#include "sim/drives/device.hpp"
#include "unit/sim/drives/drive_rig.hpp"

namespace mbgate::test::fda6000_drive_test {
namespace {

using namespace std::chrono_literals;
using bus::Instant;
using sim::Device;
using sim::Duration;
using sim::Framing;
using sim::ModelKind;

class Fda6000Model : public testing::Test {
 protected:
  std::string answer(std::string_view request) { return answer_of(drive_, request); }
  std::uint32_t get(std::uint16_t address) { return drive_.registers().get(address); }

  sim::Fda6000Drive drive_;
};

TEST_F(Fda6000Model, AnswersEveryPrintedRequestWithThePrintedResponse) {
  Device device({.address = 2, .model = ModelKind::fda6000});
  std::map<unsigned, std::string> answers;
  unsigned compared = 0;
  for (const manuals::Frame& frame : manuals::load_rtu()) {
    if (frame.manual != "higen-fda6000") {
      continue;
    }
    if (frame.direction == manuals::Direction::request) {
      const auto answer = device.receive(frame.bytes, Instant(1s));
      ASSERT_TRUE(answer) << frame.where();
      answers[frame.line] = hex(answer->frame);
    } else {
      EXPECT_EQ(answers[frame.answers.value()], hex(frame.bytes)) << frame.where();
      ++compared;
    }
  }
  EXPECT_EQ(compared, 5U);
}

TEST_F(Fda6000Model, AnswersTheSameInAscii) {
  Device device({.address = 2, .model = ModelKind::fda6000}, Framing::ascii);
  for (const auto& [request, response] :
       {std::pair{"03 00 6B 00 02", "03 04 02 2B 00 00"},
        std::pair{"06 00 01 00 03", "06 00 01 00 03"}, std::pair{"01 04 A1 00 01", "81 02"}}) {
    const auto answer = device.receive(modbus::encode_ascii(2, pdu_of(request)), Instant(1s));
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->frame, modbus::encode_ascii(2, pdu_of(response)));
  }
}

TEST_F(Fda6000Model, NeverAnswersADamagedFrame) {
  Device rtu({.address = 2, .model = ModelKind::fda6000});
  EXPECT_FALSE(rtu.receive(unhex("02 03 00 6B 00 02 B5 E5"), Instant(1s)));
  Device ascii({.address = 2, .model = ModelKind::fda6000}, Framing::ascii);
  const std::string_view wrong = ":0203006B00028F\r\n";
  EXPECT_FALSE(ascii.receive(std::vector<std::uint8_t>(wrong.begin(), wrong.end()), Instant(1s)));
}

TEST_F(Fda6000Model, CarriesWhatIsPrintedAsFloatTimesTen) {
  EXPECT_EQ(answer("03 00 CF 00 01"), "03 02 01 F4");  // 50.0 RPM
  EXPECT_EQ(answer("03 01 2C 00 04"), "03 08 03 E8 13 88 27 10 3A 98");
  EXPECT_EQ(answer("06 01 F4 80 00"), "06 01 F4 80 00");  // -3276.8
  EXPECT_EQ(answer("06 00 D4 FC 18"), "06 00 D4 FC 18");  // -100.0 %
  EXPECT_EQ(answer("06 00 D4 FC 17"), "86 03");
  EXPECT_EQ(answer("03 02 13 00 01"), "03 02 0C 80");  // P5-32: 320
}

TEST_F(Fda6000Model, KeepsRightsAndRanges) {
  EXPECT_EQ(answer("06 00 0A 00 01"), "86 02");  // St-01 is read only
  EXPECT_EQ(answer("03 00 13 00 01"), "83 02");  // behind St-09
  EXPECT_EQ(answer("03 00 72 00 02"), "83 02");  // reaching behind P1-15
  EXPECT_EQ(answer("06 00 71 00 20"), "86 03");  // address 32
  EXPECT_EQ(answer("06 00 C8 01 F5"), "86 03");
  EXPECT_EQ(answer("10 00 C8 00 02 04 00 01 27 10"), "90 03");
  EXPECT_EQ(get(0x00C8), 50U);  // all or nothing
}

TEST_F(Fda6000Model, LeavesMaskedParametersAsTheyAre) {
  EXPECT_EQ(answer("10 00 64 00 09 12 00 2A FF FF FF FF FF FF FF FF FF FF FF FF FF FF FF FF"),
            "10 00 64 00 09");
  EXPECT_EQ(get(0x0064), 42U);
  EXPECT_EQ(get(0x006B), 555U);
  EXPECT_EQ(answer("06 00 71 FF FF"), "06 00 71 FF FF");
  EXPECT_EQ(get(0x0071), 1U);
  EXPECT_EQ(answer("10 00 64 00 02 04 00 2B 00 01"), "90 02");  // P1-02 is read only
  EXPECT_EQ(get(0x0064), 42U);
}

TEST_F(Fda6000Model, TakesAllOnesForAValueElsewhere) {
  EXPECT_EQ(answer("06 01 F4 FF FF"), "06 01 F4 FF FF");  // -0.1
  EXPECT_EQ(get(sim::kFdaFirstPosition), 0xFFFFU);
  EXPECT_EQ(answer("06 00 72 FF FF"), "86 03");  // P1-15 is behind the masked ones
}

TEST_F(Fda6000Model, RepeatsFunctionsOfItsOwn) {
  for (const auto* const request : {"46", "47 00 01", "48 01 02 03", "49", "4A FF", "50 12 34"}) {
    EXPECT_EQ(answer(request), request);
  }
}

TEST_F(Fda6000Model, RefusesOtherFunctions) {
  EXPECT_EQ(answer("04 00 0A 00 01"), "84 01");
  EXPECT_EQ(answer("45"), "C5 01");
  EXPECT_EQ(answer("0D"), "8D 07");
  EXPECT_EQ(answer("0E 01"), "8E 07");
}

TEST_F(Fda6000Model, AcknowledgesALongCommandAndIsBusyUntilItIsDone) {
  Device device({.address = 2, .model = ModelKind::fda6000});
  const auto ask = [&device](std::string_view pdu, Duration at) {
    return hex(device.receive(modbus::RtuAdu{2, pdu_of(pdu)}, Instant(at))->adu.pdu.bytes());
  };
  EXPECT_EQ(ask("06 00 C8 00 07", 1000ms), "06 00 C8 00 07");
  EXPECT_EQ(ask("06 00 DF 00 01", 1001ms), "86 05");
  EXPECT_EQ(ask("03 00 C8 00 01", 1002ms), "83 06");
  EXPECT_EQ(ask("06 00 C8 00 08", 1300ms), "86 06");
  EXPECT_EQ(ask("46", 1300ms), "C6 06");
  EXPECT_EQ(ask("03 00 C8 00 01", 1301ms), "03 02 00 32");
  EXPECT_EQ(ask("03 00 DF 00 01", 1302ms), "03 02 00 00");
  EXPECT_EQ(ask("06 00 DF 00 00", 1303ms), "06 00 DF 00 00");
}

TEST_F(Fda6000Model, ObeysNoBroadcast) {
  EXPECT_FALSE(sim::Fda6000Drive::hear_broadcast(pdu_of("06 00 C8 00 01")).response);
  Device device({.address = 2, .model = ModelKind::fda6000});
  EXPECT_FALSE(device.receive(modbus::RtuAdu{0, pdu_of("06 00 C8 00 01")}, Instant(1s)));
  EXPECT_EQ(device.drive<sim::Fda6000Drive>()->registers().get(0x00C8), 50U);
}

}  // namespace
}  // namespace mbgate::test::fda6000_drive_test
