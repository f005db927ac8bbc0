// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/control/event_streams.hpp"

namespace mbgate::app {
namespace {

constexpr std::chrono::seconds kNoonOfTheFirstDay{std::chrono::hours(12)};

TEST(EventText, HasTheNumberTheTimeTheLevelAndTheText) {
  const JournalEvent event{7, std::chrono::system_clock::time_point(kNoonOfTheFirstDay),
                           Level::warning, "device axis-x: does not answer any more"};
  EXPECT_EQ(
      event_text(event),
      "id: 7\nevent: journal\ndata: {\"at\":\"1970-01-01T12:00:00.000Z\",\"level\":\"warning\","
      "\"text\":\"device axis-x: does not answer any more\"}\n\n");
}

TEST(EventText, HasMillisecondsThatAreNotRoundedUp) {
  const auto at =
      std::chrono::system_clock::time_point(kNoonOfTheFirstDay) + std::chrono::microseconds(7999);
  EXPECT_NE(event_text({1, at, Level::info, ""}).find("T12:00:00.007Z"), std::string::npos);
}

TEST(EventText, IsOneLineOfDataWhateverTheTextIs) {
  const std::string text = event_text({1, {}, Level::error, "first\n\nevent: \"second\""});
  EXPECT_NE(text.find("\"text\":\"first\\n\\nevent: \\\"second\\\"\"}\n\n"), std::string::npos);
}

TEST(EventText, SaysHowManyAreMissing) {
  EXPECT_EQ(lost_text(12), "event: lost\ndata: {\"lost\":12}\n\n");
}

}  // namespace
}  // namespace mbgate::app
