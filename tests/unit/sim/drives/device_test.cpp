// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/device.hpp"

#include <gtest/gtest.h>

#include "unit/sim/wire/wire_rig.hpp"

namespace mbgate::test {
namespace {

using sim::Device;
using sim::Faults;

std::string answer_of(Device& device, std::string_view frame, Duration end = 1s) {
  const auto answer = device.receive(unhex(frame), Instant(end));
  return answer ? hex(answer->frame) : "silence";
}

std::string answer_with(const Faults& faults) {
  Device device({.address = 1, .faults = faults});
  return answer_of(device, kReadStatus);
}

TEST(Device, AnswersThePrintedFrame) {
  Device device({.address = 1});
  EXPECT_EQ(answer_of(device, kReadStatus), kStatus);
  EXPECT_EQ(device.heard(), 1U);
}

TEST(Device, AnswersUnderItsOwnAddressOnly) {
  Device device({.address = 1});
  EXPECT_EQ(answer_of(device, kReadStatus2), "silence");
  EXPECT_EQ(device.heard(), 0U);
}

TEST(Device, IgnoresDamagedFrames) {
  Device device({.address = 1});
  EXPECT_EQ(answer_of(device, "01 03 00 01 00 01 D5 CB"), "silence");
  EXPECT_EQ(answer_of(device, "01 03"), "silence");
  EXPECT_EQ(answer_of(device, ""), "silence");
  EXPECT_EQ(device.heard(), 0U);
}

TEST(Device, IsSilentWhenTold) {
  Device device({.address = 1, .faults = {.silent = true}});
  EXPECT_EQ(answer_of(device, "01 06 00 7C 00 96 C8 7C"), "silence");
  EXPECT_EQ(device.drive<sim::MoonsDrive>()->registers().get(sim::kMoonsStatus), 0x0009U);
  device.set_faults({});
  EXPECT_EQ(answer_of(device, kReadStatus), kStatus);
}

TEST(Device, SpoilsItsAnswersWhenTold) {
  EXPECT_EQ(answer_with({.bad_crc = true}), "01 03 02 00 09 78 BD");
  EXPECT_EQ(answer_with({.wrong_unit = true}), kStatus2);
  EXPECT_EQ(answer_with({.wrong_function = true}), "01 04 02 00 09 79 36");
}

TEST(Device, RefusesEveryNthRequestWhenTold) {
  Device device({.address = 1, .faults = {.exception_every = 3}});
  EXPECT_EQ(answer_of(device, kReadStatus), kStatus);
  EXPECT_EQ(answer_of(device, kReadStatus), kStatus);
  EXPECT_EQ(answer_of(device, kReadStatus), "01 83 04 40 F3");
  EXPECT_EQ(answer_of(device, kReadStatus), kStatus);
}

TEST(Device, AnswersLateWhenTold) {
  Device device({.address = 1, .response_wait = 7ms, .processing = 2ms});
  auto answer = device.receive(unhex(kReadStatus), Instant(1s));
  EXPECT_EQ(answer->after, 9ms);
  EXPECT_FALSE(answer->counts_from_end);
  device.set_faults({.answer_after = 400ms});
  answer = device.receive(unhex(kReadStatus), Instant(1s));
  EXPECT_EQ(answer->after, 400ms);
  EXPECT_TRUE(answer->counts_from_end);
}

TEST(Device, IsDeafWhileTheStepperRestarts) {
  Device device({.address = 1, .model = ModelKind::stepper});
  EXPECT_EQ(answer_of(device, "01 06 00 D4 01 00 C8 62", 1s), "silence");
  EXPECT_EQ(answer_of(device, "01 03 00 00 00 02 C4 0B", 1499ms), "silence");
  EXPECT_EQ(answer_of(device, "01 03 00 00 00 02 C4 0B", 1500ms), "01 03 04 37 31 00 30 A5 9C");
}

TEST(Device, IsDeafAfterABroadcastRestart) {
  Device device({.address = 1, .model = ModelKind::stepper});
  EXPECT_EQ(answer_of(device, "00 06 00 D4 01 00 C9 B3", 1s), "silence");
  EXPECT_EQ(device.heard(), 1U);
  EXPECT_EQ(answer_of(device, "01 03 00 00 00 02 C4 0B", 1100ms), "silence");
  EXPECT_EQ(device.heard(), 1U);
}

TEST(Device, GivesAccessToItsDriveOfTheRightKindOnly) {
  Device device({.address = 1, .model = ModelKind::aic});
  EXPECT_NE(device.drive<sim::AicDrive>(), nullptr);
  EXPECT_EQ(device.drive<sim::MoonsDrive>(), nullptr);
}

}  // namespace
}  // namespace mbgate::test
