// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

#include "ctl/trace/trace_event.hpp"
#include "trace_records.hpp"

namespace mbgate::ctl {
namespace {

/// The time zone is one that has no summer time and that no machine has by chance.
class TraceLines : public testing::Test {
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

TEST_F(TraceLines, FollowARequestToTheWireAndBack) {
  EXPECT_EQ(trace_lines(parse_trace(read_record(good_frame()))),
            "03:55:00.123456 192.0.2.7 plant unit 1: read holding registers 30..31\n"
            "  line-a axis-x > 01 03 00 1E 00 02 A4 0D  (+0.1 ms after the request came)\n"
            "  line-a axis-x < 01 03 04 00 03 0D 40 0F 53  5.1 ms\n"
            "  = 2 registers: 0x0003 0x0D40  6.0 ms in all\n");
}

TEST_F(TraceLines, SayWhatFailed) {
  EXPECT_EQ(trace_lines(parse_trace(failed_record(silent_frame() + "," + damaged_frame()))),
            "03:55:00.123456 FAILED 192.0.2.7 plant unit 1: read holding registers 30..31\n"
            "  line-a axis-x > 01 03 00 1E 00 02 A4 0D  (+0.1 ms after the request came)\n"
            "  line-a axis-x < FAILED: nothing within 300.0 ms\n"
            "  line-a axis-x > 01 03 00 1E 00 02 A4 0D  (+0.1 ms after the request came; 2nd try; "
            "shared by 3 requests)\n"
            "  line-a axis-x < 01 03 04 00 03 0D 40 FF FF  5.1 ms  FAILED: CRC FF FF, 0F 53 would "
            "be right\n"
            "  = FAILED: exception 0x0B: no valid answer came  301.0 ms in all\n");
}

TEST_F(TraceLines, SayWhenNothingWasSent) {
  EXPECT_EQ(trace_lines(parse_trace(read_record(""))),
            "03:55:00.123456 192.0.2.7 plant unit 1: read holding registers 30..31\n"
            "  = 2 registers: 0x0003 0x0D40  (nothing was sent for it)  6.0 ms in all\n");
}

/// A broadcast that nobody answers. `rest`: whether it failed, how it ended.
std::string broadcast_record(const std::string& rest) {
  return R"({"client":{"address":"192.0.2.7","connection":3,"listener":"plant"},)"
         R"("request":{"at":"2026-11-24T22:10:00.123456Z","bytes":"00 07 00 00 00 06 00 06 00 00 00 01",)"
         R"("text":"transaction 7 unit 0: write single register 0: 0x0001"},"answer":null,)"
         R"("refused":false,)" +
         rest +
         R"(,"wire":[{"bus":"line-a","device":null,"address":0,"framing":"rtu",)"
         R"("sent":{"at":"2026-11-24T22:10:00.123556Z","bytes":"00 06 00 00 00 01 49 DB",)"
         R"("text":"unit 0: write single register 0: 0x0001"},"try":1,"shared_by":1,)"
         R"("outcome":"sent","ended_at":"2026-11-24T22:10:00.129400Z","response":null,"heard":[],)"
         R"("heard_not_kept":0,"heard_text":"nothing"}],"wire_not_kept":0})";
}

const char* const kBroadcast =
    " 192.0.2.7 plant unit 0: write single register 0: 0x0001\n"
    "  line-a address 0 > 00 06 00 00 00 01 49 DB  (+0.1 ms after the request came; "
    "no device answers this)\n";

TEST_F(TraceLines, ABroadcastThatHasNoAnswerHasNotFailed) {
  EXPECT_EQ(trace_lines(parse_trace(broadcast_record(R"("failed":false,"ended":"transmitted")"))),
            "03:55:00.123456" + std::string(kBroadcast) +
                "  = no answer (the client has disconnected or gets none)\n");
}

TEST_F(TraceLines, ARequestThatHasNoAnswerHasFailed) {
  EXPECT_EQ(
      trace_lines(parse_trace(broadcast_record(R"("failed":true,"ended":"the line is not open")"))),
      "03:55:00.123456 FAILED" + std::string(kBroadcast) +
          "  = FAILED: no answer (the client has disconnected or gets none): the line is not "
          "open\n");
}

TEST_F(TraceLines, SayWhatWasHeardWithoutBeingAsked) {
  EXPECT_EQ(
      trace_lines(parse_trace(
          R"({"failed":true,"wire":[{"bus":"line-a","device":null,"address":17,"framing":"rtu",)"
          R"("sent":null,"outcome":"unasked","ended_at":"2026-11-24T22:10:00.200000Z",)"
          R"("response":null,"heard":[{"at":"2026-11-24T22:10:00.200000Z","bytes":"11"}],)"
          R"("heard_not_kept":2,"heard_text":"1 byte, too few for a frame"}],"wire_not_kept":0})")),
      "03:55:00.200000 heard without a request\n"
      "  line-a < 11 and 2 bytes more  1 byte, too few for a frame\n");
}

TEST_F(TraceLines, SayHowManyAreMissing) {
  EXPECT_EQ(missing_records(1), "1 record is missing here: they came faster than they were read");
  EXPECT_EQ(missing_records(2), "2 records are missing here: they came faster than they were read");
}

TEST_F(TraceLines, AreNotMadeOfWhatMbgatedDoesNotSay) {
  EXPECT_ANY_THROW(parse_trace("no JSON"));
  EXPECT_ANY_THROW(parse_trace(R"({"failed":false,"wire":[],"wire_not_kept":0})"));
  std::string record = read_record(good_frame());
  record.replace(record.find("answered"), 8, "answerad");
  EXPECT_NO_THROW(parse_trace(record)) << "how a request ended is only shown";
  record.replace(record.find("answered"), 8, "answerad");
  EXPECT_ANY_THROW(parse_trace(record)) << "an unknown outcome";
}

}  // namespace
}  // namespace mbgate::ctl
