// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/doctor/findings.hpp"
#include "line_bytes.hpp"

namespace mbgate::ctl {
namespace {

constexpr LineMode kNineSix{modbus::Baud{9600}, {8, modbus::Parity::even, 1}};

IdleLine idle_with(const LineBytes& heard) {
  return {heard, heard.size(), std::chrono::seconds(2)};
}

Finding found_in(const LineBytes& heard) { return idle_finding(idle_with(heard), kNineSix); }

TEST(IdleLine, IsSilentWhereAllIsWell) {
  EXPECT_EQ(found_in({}), (Finding{Judgement::ok, "idle line", "nothing was heard in 2s"}));
  EXPECT_FALSE(is_of_another_client(idle_with({})));
  EXPECT_FALSE(may_be_of_another_client(idle_with({})));
}

TEST(IdleLine, HasAnotherClientWhereARequestIsHeard) {
  const auto heard = one_after_the_other({rtu_frame(5, kReadPdu), rtu_frame(5, kAnswerPdu)});
  EXPECT_EQ(found_in(heard),
            (Finding{Judgement::fault, "idle line",
                     "another client is on this line: 2 frames heard in 2s, the first: unit 5: "
                     "read holding registers 0",
                     kOneClient}));
  EXPECT_TRUE(is_of_another_client(idle_with(heard)));
}

TEST(IdleLine, HasAnotherClientWhereSeveralAnswersAreHeard) {
  const auto answer = rtu_frame(5, kAnswerPdu);
  const auto heard = one_after_the_other({answer, answer});
  EXPECT_EQ(found_in(heard),
            (Finding{Judgement::fault, "idle line",
                     "2 frames of devices heard in 2s, but not the requests: another client "
                     "whose requests do not reach this port, as on four wires, the first: unit 5: "
                     "1 register: 0x1234",
                     kOneClient}));
  EXPECT_TRUE(is_of_another_client(idle_with(heard)));
}

TEST(IdleLine, MayHaveALateAnswerOnIt) {
  const auto heard = rtu_frame(5, kAnswerPdu);
  EXPECT_EQ(found_in(heard),
            (Finding{Judgement::unknown, "idle line",
                     "1 frame heard in 2s: unit 5: 1 register: 0x1234; a late answer to a program "
                     "that has ended, or another client",
                     "run this again"}));
  EXPECT_FALSE(is_of_another_client(idle_with(heard)));
  EXPECT_TRUE(may_be_of_another_client(idle_with(heard)));
}

TEST(IdleLine, MayHaveAnotherClientWhereMoreThanAFewBytesAreHeard) {
  EXPECT_FALSE(may_be_of_another_client(idle_with({0x00, 0x00})));
  EXPECT_TRUE(may_be_of_another_client(idle_with({0x00, 0x00, 0x00})));
  EXPECT_FALSE(is_of_another_client(idle_with({0x00, 0x00, 0x00})));
}

TEST(IdleLine, NamesAllCausesOfBytesThatAreNoFrame) {
  EXPECT_EQ(
      found_in({0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0, 0x11}),
      (Finding{Judgement::fault, "idle line",
               "9 bytes heard in 2s that are not a frame at 9600 8E1: 12 34 56 78 9A BC DE F0 ..",
               "looks like noise (termination, bias, shield, motor cables beside it), or like "
               "another client at another rate or parity"}));
  EXPECT_EQ(
      found_in({0x00, 0x00, 0x00}),
      (Finding{
          Judgement::fault, "idle line",
          "3 bytes heard in 2s that are not a frame at 9600 8E1: 00 00 00",
          "looks like a line without an idle level (are A and B exchanged, is bias or termination "
          "missing, is a wire loose?), or like another client at another rate or parity"}));
}

TEST(IdleLine, IsNotCondemnedForAByteOfTheAdapter) {
  EXPECT_EQ(found_in({0x00}),
            (Finding{Judgement::unknown, "idle line",
                     "1 byte heard in 2s that is not a frame at 9600 8E1: 00",
                     "an adapter may make them when it is opened: run this again"}));
}

}  // namespace
}  // namespace mbgate::ctl
