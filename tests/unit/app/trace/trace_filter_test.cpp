// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/trace/trace_json.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using app::TraceFilter;
using gateway::TraceRecord;
using gateway::WireTrace;

TraceRecord read_of_axis() {
  TraceRecord record;
  auto& asked = record.asked.emplace();
  asked.client = *routing::ClientAddress::parse("192.0.2.7");
  asked.request = unhex("00 07 00 00 00 06 01 03 00 00 00 01");
  asked.answer = unhex("00 07 00 00 00 05 01 03 02 12 34");
  WireTrace& wire = record.wire.emplace_back();
  wire.bus = "line a";
  wire.device = "axis-x";
  wire.outcome = WireTrace::Outcome::answered;
  return record;
}

bool matches(std::string_view query, const TraceRecord& record) {
  return TraceFilter::parse(query)->matches(record);
}

std::string error(std::string_view query) { return TraceFilter::parse(query).error(); }

TEST(TraceFilter, AllIsShownWhereNothingIsAskedFor) { EXPECT_TRUE(matches("", read_of_axis())); }

TEST(TraceFilter, HasTheJournalBesideForWhoeverAsks) {
  EXPECT_FALSE(TraceFilter::parse("only=failed")->with_journal);
  EXPECT_TRUE(TraceFilter::parse("events=1")->with_journal);
  EXPECT_TRUE(matches("events=1", read_of_axis()));
}

TEST(TraceFilter, LooksAtEachWord) {
  const TraceRecord record = read_of_axis();
  EXPECT_TRUE(matches("bus=line%20a&device=axis-x&client=192.0.2.7&function=3", record));
  EXPECT_TRUE(matches("bus=line+a", record));
  EXPECT_FALSE(matches("bus=line-b", record));
  EXPECT_FALSE(matches("device=axis-y", record));
  EXPECT_FALSE(matches("client=192.0.2.8", record));
  EXPECT_FALSE(matches("function=6", record));
  EXPECT_FALSE(matches("bus=line+a&function=6", record));
}

TEST(TraceFilter, AnExceptionNoAnswerOrATroubleOnTheWireIsAFailure) {
  TraceRecord record = read_of_axis();
  EXPECT_FALSE(matches("only=failed", record));
  record.asked->answer = unhex("00 07 00 00 00 03 01 83 02");
  EXPECT_TRUE(matches("only=failed", record));
  record.asked->answer.reset();
  EXPECT_TRUE(matches("only=failed", record));
  record = read_of_axis();
  record.wire.insert(record.wire.begin(), record.wire.front());
  record.wire.front().outcome = WireTrace::Outcome::damaged;
  EXPECT_TRUE(matches("only=failed", record));
}

TEST(TraceFilter, ARequestOfWhichNothingWasSentWasToGoSomewhere) {
  TraceRecord record = read_of_axis();
  record.asked->targets = {{"line a", "axis-x"}};
  record.wire.clear();
  EXPECT_TRUE(matches("bus=line+a&device=axis-x", record));
  EXPECT_FALSE(matches("device=axis-y", record));
}

TEST(TraceFilter, BytesThatNobodyAskedForHaveNoClient) {
  TraceRecord record;
  record.wire.emplace_back().bus = "line-a";
  EXPECT_TRUE(matches("bus=line-a", record));
  EXPECT_FALSE(matches("client=192.0.2.7", record));
  EXPECT_FALSE(matches("function=3", record));
}

TEST(TraceFilter, SaysWhatIsExpected) {
  EXPECT_EQ(error("function=300"), "function=300: expected a number, 0 to 255");
  EXPECT_EQ(error("function="), "function=: expected a number, 0 to 255");
  EXPECT_EQ(error("client=plc"), "client=plc: expected an IP address");
  const std::string expected =
      ": expected bus=, device=, client=, function=, only=failed or events=1";
  EXPECT_EQ(error("only=good"), "only=good" + expected);
  EXPECT_EQ(error("unit=1"), "unit=1" + expected);
  EXPECT_EQ(error("events=2"), "events=2" + expected);
  EXPECT_EQ(error("bus=%2"), "bus: expected two hexadecimal digits after %");
  EXPECT_EQ(error("bus=%zz"), "bus: expected two hexadecimal digits after %");
}

}  // namespace
}  // namespace mbgate::test
