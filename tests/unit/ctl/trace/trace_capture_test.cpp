// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/trace_capture.hpp"

#include <gtest/gtest.h>

#include "trace_records.hpp"

namespace mbgate::ctl {
namespace {

std::size_t little_endian(modbus::Bytes bytes, std::size_t at, std::size_t size) {
  std::size_t number = 0;
  for (std::size_t byte = size; byte-- > 0;) {
    number = number * 0x100 + bytes[at + byte];
  }
  return number;
}

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

/// The comment of a packet's block, or "".
std::string comment_of(modbus::Bytes block) {
  constexpr std::size_t kPacketAt = 28;
  std::size_t at = kPacketAt + padded(little_endian(block, 20, 4));
  while (little_endian(block, at, 2) != 0) {
    const std::size_t size = little_endian(block, at + 2, 2);
    if (little_endian(block, at, 2) == 1) {
      const modbus::Bytes text = block.subspan(at + 4, size);
      return {text.begin(), text.end()};
    }
    at += 4 + padded(size);
  }
  return {};
}

using Packets = std::vector<std::string>;

/// Each packet as "interface: comment", in its order.
Packets packets_of(modbus::Bytes blocks) {
  constexpr std::size_t kPacket = 6;
  Packets packets;
  while (!blocks.empty()) {
    const std::size_t size = little_endian(blocks, 4, 4);
    if (little_endian(blocks, 0, 4) == kPacket) {
      packets.push_back(std::to_string(little_endian(blocks, 8, 4)) + ": " +
                        comment_of(blocks.first(size)));
    }
    blocks = blocks.subspan(size);
  }
  return packets;
}

std::string replaced(std::string text, const std::string& found, const std::string& wanted) {
  const auto at = text.find(found);
  EXPECT_NE(at, std::string::npos) << found;
  return at == std::string::npos ? text : text.replace(at, found.size(), wanted);
}

std::string shared_frame() {
  return replaced(good_frame(), R"("shared_by":1)", R"("shared_by":2)");
}

TEST(TraceCapture, SaysOfEachPacketItsOwnFailure) {
  TraceCapture capture;
  const std::string crc = "CRC FF FF, 0F 53 would be right";
  EXPECT_EQ(
      packets_of(capture.add(parse_trace(failed_record(silent_frame() + "," + damaged_frame())))),
      (Packets{"0: failed: exception 0x0B: no valid answer came",
               "1: failed: nothing within 300.0 ms", "1: failed: " + crc, "1: " + crc,
               "0: failed: exception 0x0B: no valid answer came"}));
}

TEST(TraceCapture, SaysNothingOfOtherTriesOfARequestThatWasAnswered) {
  TraceCapture capture;
  const std::string second = replaced(good_frame(), "00.123556Z", "00.124000Z");
  EXPECT_EQ(packets_of(capture.add(parse_trace(replaced(read_record(silent_frame() + "," + second),
                                                        R"("failed":false)", R"("failed":true)")))),
            (Packets{"0: ", "1: failed: nothing within 300.0 ms", "1: ", "1: ", "0: "}));
}

TEST(TraceCapture, SaysWhatAFrameMeansThatWiresharkDoesNotKnowAndThatItFailed) {
  TraceCapture capture;
  const std::string frame = replaced(silent_frame(), R"("rtu")", R"("ascii")");
  EXPECT_EQ(
      packets_of(capture.add(parse_trace(read_record(frame)))),
      (Packets{"0: ", "1: unit 1: read holding registers 30..31\nfailed: nothing within 300.0 ms",
               "0: "}));
}

TEST(TraceCapture, HasASharedFrameOnce) {
  TraceCapture capture;
  EXPECT_EQ(packets_of(capture.add(parse_trace(read_record(shared_frame())))).size(), 4U);
  const std::string again = replaced(shared_frame(), "00.123556Z", "00.123559Z");
  EXPECT_EQ(packets_of(capture.add(parse_trace(read_record(again)))).size(), 2U)
      << "the clocks of two batches differ by some microseconds";
  const std::string later = replaced(shared_frame(), "00.123556Z", "00.126556Z");
  EXPECT_EQ(packets_of(capture.add(parse_trace(read_record(later)))).size(), 4U)
      << "the same was sent again";
}

TEST(TraceCapture, HasSharedFramesThatWereSentAtOneInstant) {
  TraceCapture capture;
  const std::string other =
      replaced(shared_frame(), "01 03 00 1E 00 02 A4 0D", "01 03 00 20 00 02 C5 C1");
  EXPECT_EQ(packets_of(capture.add(parse_trace(read_record(shared_frame() + "," + other)))).size(),
            6U);
}

TEST(TraceCapture, SaysWhatWasNotKept) {
  TraceCapture capture;
  const std::string frame =
      replaced(good_frame(), R"("heard_not_kept":0)", R"("heard_not_kept":1)");
  const std::string record =
      replaced(read_record(frame), R"("wire_not_kept":0)", R"("wire_not_kept":2)");
  EXPECT_EQ(packets_of(capture.add(parse_trace(record))),
            (Packets{"0: ", "1: ", "1: and 1 byte more", "0: and 2 frames more"}));
}

TEST(TraceCapture, SaysWhatIsMissingBefore) {
  TraceCapture capture;
  capture.note_lost(3);
  const std::string missing = "3 records are missing here: they came faster than they were read";
  EXPECT_EQ(packets_of(capture.add(parse_trace(failed_record("")))),
            (Packets{"0: " + missing + "\nfailed: exception 0x0B: no valid answer came",
                     "0: failed: exception 0x0B: no valid answer came"}));
}

}  // namespace
}  // namespace mbgate::ctl
