// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/event_reader.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace mbgate::ctl {
namespace {

constexpr const char* kTwoEvents =
    ":\n"
    "\n"
    "event: lost\n"
    "data: {\"lost\":2}\n"
    "\n"
    "id: 7\n"
    "event: journal\n"
    "data: {\"at\":\"2026-11-24T22:10:00.123Z\",\"level\":\"warning\",\"text\":\"bus a: lost\"}\n"
    "\n";

TEST(EventReader, TakesEventsWhereverTheirBytesAreCut) {
  const std::string bytes = kTwoEvents;
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    EventReader reader;
    auto events = reader.take(bytes.substr(0, cut));
    const auto rest = reader.take(bytes.substr(cut));
    events.insert(events.end(), rest.begin(), rest.end());
    ASSERT_EQ(events.size(), 2U) << cut;
    EXPECT_EQ(events[0].name, "lost");
    EXPECT_EQ(events[0].data, "{\"lost\":2}");
    EXPECT_EQ(events[1].name, "journal");
  }
}

TEST(EventReader, TakesNoEventThatHasNotEnded) {
  EventReader reader;
  EXPECT_TRUE(reader.take("event: journal\ndata: {}\n").empty());
}

TEST(EventReader, TakesNoLineWithoutEnd) {
  EventReader reader;
  reader.take(std::string(1 << 20, 'x'));
  EXPECT_ANY_THROW(reader.take("x"));
}

/// The time zone is one that has no summer time and that no machine has by chance.
class EventLine : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("TZ", "PLANT-5:45", 1);
    ::tzset();
  }
  void TearDown() override {
    ::unsetenv("TZ");
    ::tzset();
  }
};

TEST_F(EventLine, HasTheLocalTime) {
  const auto events = EventReader().take(kTwoEvents);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(event_line(events[1]), "03:55:00 warning bus a: lost");
}

TEST_F(EventLine, SaysHowManyAreMissing) {
  EXPECT_EQ(event_line({"lost", "{\"lost\":2}"}),
            "2 lines are missing here: mbgated does not keep them any more");
  EXPECT_EQ(event_line({"lost", "{\"lost\":1}"}),
            "1 line is missing here: mbgated does not keep them any more");
}

TEST_F(EventLine, IsNotMadeOfWhatMbgatedDoesNotSay) {
  EXPECT_ANY_THROW(event_line({"journal", "{\"at\":\"now\",\"level\":\"info\",\"text\":\"\"}"}));
  EXPECT_ANY_THROW(event_line({"journal", "{}"}));
  EXPECT_ANY_THROW(event_line({"journal", "no JSON"}));
}

}  // namespace
}  // namespace mbgate::ctl
