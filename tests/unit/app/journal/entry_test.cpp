// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/journal/journal.hpp"

namespace mbgate::app {
namespace {

TEST(JournalEntry, HasWhatItIsAbout) {
  const Topic topic{.id = {"00112233445566778899aabbccddeeff"},
                    .bus = "axes",
                    .device = "axis-x",
                    .address = "1",
                    .client = "192.168.10.5",
                    .listener = "plant"};
  EXPECT_EQ(journal_fields(Level::warning, "device axis-x: a text\nof two lines", topic),
            (std::vector<std::string>{"MESSAGE=device axis-x: a text\nof two lines", "PRIORITY=4",
                                      "SYSLOG_IDENTIFIER=mbgated", "SYSLOG_FACILITY=3",
                                      "MESSAGE_ID=00112233445566778899aabbccddeeff",
                                      "MBGATE_BUS=axes", "MBGATE_DEVICE=axis-x", "MBGATE_ADDRESS=1",
                                      "MBGATE_CLIENT=192.168.10.5", "MBGATE_LISTENER=plant"}));
}

TEST(JournalEntry, LeavesOutWhatItIsNotAbout) {
  EXPECT_EQ(journal_fields(Level::info, "text", {}),
            (std::vector<std::string>{"MESSAGE=text", "PRIORITY=6", "SYSLOG_IDENTIFIER=mbgated",
                                      "SYSLOG_FACILITY=3"}));
  EXPECT_EQ(journal_fields(Level::notice, "text", {.bus = "axes"}),
            (std::vector<std::string>{"MESSAGE=text", "PRIORITY=5", "SYSLOG_IDENTIFIER=mbgated",
                                      "SYSLOG_FACILITY=3", "MBGATE_BUS=axes"}));
}

}  // namespace
}  // namespace mbgate::app
