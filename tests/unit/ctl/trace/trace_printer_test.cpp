// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_printer.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "trace_records.hpp"

namespace mbgate::ctl {
namespace {

TEST(TracePrinter, PrintsOneJsonObjectALine) {
  std::ostringstream out;
  TracePrinter printer({nullptr, &out, nullptr, 1});
  EXPECT_TRUE(printer.start());
  EXPECT_TRUE(printer.take({"lost", R"({"lost":2})"}));
  EXPECT_FALSE(printer.is_done());
  EXPECT_FALSE(printer.take({"transaction", read_record("")}));
  EXPECT_TRUE(printer.is_done());
  EXPECT_EQ(out.str(), "{\"event\":\"lost\",\"lost\":2}\n{\"event\":\"transaction\"," +
                           read_record("").substr(1) + "\n");
}

TEST(TracePrinter, LooksIntoNothingThatItOnlyPassesOn) {
  std::ostringstream out;
  TracePrinter printer({nullptr, &out, nullptr, 1});
  EXPECT_TRUE(printer.take({"lost", R"({"dropped":2})"}));
  EXPECT_FALSE(printer.take({"transaction", R"({"of":"another version"})"}));
  EXPECT_EQ(out.str(),
            "{\"event\":\"lost\",\"dropped\":2}\n"
            "{\"event\":\"transaction\",\"of\":\"another version\"}\n");
  std::ostringstream capture;
  TracePrinter both({nullptr, &out, &capture, 1});
  EXPECT_ANY_THROW(both.take({"transaction", R"({"of":"another version"})"}));
}

TEST(TracePrinter, WritesTheCaptureFromTheFirstByteOn) {
  std::ostringstream capture;
  TracePrinter printer({nullptr, nullptr, &capture, {}});
  EXPECT_TRUE(printer.start());
  const std::string start = capture.str();
  EXPECT_TRUE(start.starts_with("\n\r\r\n"));
  EXPECT_TRUE(printer.take({"transaction", read_record(good_frame())}));
  EXPECT_GT(capture.str().size(), start.size());
}

}  // namespace
}  // namespace mbgate::ctl
