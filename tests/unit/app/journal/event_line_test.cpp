// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <optional>

#include "app/journal/event_topic.hpp"

namespace mbgate::app::event_line_test {
namespace {

using gateway::BusId;

constexpr BusId kAxes{0};

Level level_of_device(bus::DeviceNotice::Kind kind) {
  return level_of(gateway::DeviceNews{kAxes, {.kind = kind, .address = 1}});
}

Level level_of_line(bus::LineFault fault) { return level_of(gateway::LineNews{kAxes, fault}); }

Level level_of_quality(bus::Quality quality) {
  bus::QualityNotice notice{std::nullopt, {}};
  notice.verdict.quality = quality;
  return level_of(gateway::QualityNews{kAxes, notice});
}

TEST(EventLevel, IsAWarningForWhatSomebodyMustLookAt) {
  EXPECT_EQ(level_of(gateway::BusLost{kAxes}), Level::warning);
  EXPECT_EQ(level_of_device(bus::DeviceNotice::Kind::lost), Level::warning);
  EXPECT_EQ(level_of_line(bus::LineFault::echo_differed), Level::warning);
  EXPECT_EQ(level_of_quality(bus::Quality::bad_crc), Level::warning);
}

TEST(EventLevel, IsANoticeForARecovery) {
  EXPECT_EQ(level_of(gateway::BusOpened{kAxes}), Level::notice);
  EXPECT_EQ(level_of_device(bus::DeviceNotice::Kind::back), Level::notice);
  EXPECT_EQ(level_of_line(bus::LineFault::echo_found), Level::notice);
  EXPECT_EQ(level_of_line(bus::LineFault::echo_gone), Level::notice);
  EXPECT_EQ(level_of_quality(bus::Quality::good), Level::notice);
}

}  // namespace
}  // namespace mbgate::app::event_line_test
