// SPDX-License-Identifier: Apache-2.0
#include "app/trace/trace_json.hpp"

#include <gtest/gtest.h>

#include <boost/json/serialize.hpp>

#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using gateway::Instant;
using gateway::TraceRecord;
using gateway::WireTrace;

// 2026-11-25 00:00:00 UTC
constexpr std::chrono::system_clock::time_point kMidnight{1795564800s};

WireTrace answered() {
  WireTrace wire;
  wire.bus = "line-a";
  wire.device = "axis-x";
  wire.address = 1;
  wire.tries = 1;
  wire.sent_at = Instant{1s + 250us};
  wire.frame = unhex("01 03 00 00 00 01 84 0A");
  wire.heard.push_back({Instant{1s + 9ms}, unhex("01 03 02 12 34 B5 33")});
  wire.response = unhex("03 02 12 34");
  wire.outcome = WireTrace::Outcome::answered;
  wire.ended_at = Instant{1s + 9ms};
  wire.silent_since = Instant{990ms};
  wire.left_at = Instant{1s + 945us};
  return wire;
}

TEST(TraceJson, HasBothSides) {
  TraceRecord record;
  auto& asked = record.asked.emplace();
  asked.connection = gateway::ClientId{12};
  asked.client = *routing::ClientAddress::parse("192.0.2.7");
  asked.listener = "plant";
  asked.targets = {{"line-a", "axis-x"}};
  asked.asked_at = Instant{1s};
  asked.request = unhex("00 07 00 00 00 06 01 03 00 00 00 01");
  asked.answered_at = Instant{1s + 9ms + 1us};
  asked.answer = unhex("00 07 00 00 00 05 01 03 02 12 34");
  record.wire.push_back(answered());
  record.ended_as = bus::Ending::answered;
  EXPECT_STREQ(app::trace_kind(record), "transaction");
  EXPECT_EQ(
      boost::json::serialize(app::trace_json(record, kMidnight)),
      R"({"failed":false,)"
      R"("client":{"address":"192.0.2.7","connection":12,"listener":"plant"},)"
      R"("request":{"at":"2026-11-25T00:00:01.000000Z","bytes":"00 07 00 00 00 06 01 03 00 00 00 01",)"
      R"("text":"transaction 7 unit 1: read holding registers 0"},)"
      R"("answer":{"at":"2026-11-25T00:00:01.009001Z","bytes":"00 07 00 00 00 05 01 03 02 12 34",)"
      R"("text":"transaction 7 unit 1: 1 register: 0x1234"},"refused":false,)"
      R"("targets":[{"bus":"line-a","device":"axis-x"}],"ended":"answered",)"
      R"("wire":[{"bus":"line-a","device":"axis-x","address":1,"framing":"rtu",)"
      R"("sent":{"at":"2026-11-25T00:00:01.000250Z","bytes":"01 03 00 00 00 01 84 0A",)"
      R"("text":"unit 1: read holding registers 0"},"outcome":"answered",)"
      R"("ended_at":"2026-11-25T00:00:01.009000Z","response":"03 02 12 34","try":1,"shared_by":1,)"
      R"("silence_ms":1.025E1,"left_at":"2026-11-25T00:00:01.000945Z","held_until":null,)"
      R"("heard":[{"at":"2026-11-25T00:00:01.009000Z","bytes":"01 03 02 12 34 B5 33"}],)"
      R"("heard_not_kept":0,"heard_text":"1 register: 0x1234"}],"wire_not_kept":0})");
}

TEST(TraceJson, TellsFramesFromWhatWasHeard) {
  TraceRecord record;
  record.wire.push_back(answered());
  EXPECT_STREQ(app::trace_kind(record), "frame");
  record.wire[0].outcome = WireTrace::Outcome::unasked;
  EXPECT_STREQ(app::trace_kind(record), "heard");
  const auto json = app::trace_json(record, kMidnight);
  EXPECT_FALSE(json.contains("client"));
  EXPECT_TRUE(json.at("wire").at(0).at("sent").is_null());
}

}  // namespace
}  // namespace mbgate::test
