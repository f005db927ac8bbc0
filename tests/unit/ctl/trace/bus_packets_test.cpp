// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/trace/trace_capture.hpp"
#include "modbus/describe.hpp"
#include "modbus/frames.hpp"
#include "support/hex.hpp"
#include "trace_records.hpp"

namespace mbgate::ctl::bus_packets_test {
namespace {

/// A frame with its CRC: address and PDU in hexadecimal.
ByteString with_crc(std::string_view address_and_pdu) {
  const auto bytes = test::unhex(address_and_pdu);
  const auto frame =
      modbus::encode_rtu(bytes[0], *modbus::Pdu::from(modbus::Bytes(bytes).subspan(1)));
  return {frame.begin(), frame.end()};
}

TracedFrame answered(const ByteString& sent, std::string_view response) {
  TracedFrame frame;
  frame.address = 1;
  frame.sent = TracedAdu{{{}, sent}, ""};
  frame.response = test::unhex(response);
  frame.outcome = TracedOutcome::answered;
  frame.heard_text = "what was heard";
  return frame;
}

/// "mbrtu 50000: 01 06 ... # comment": the dissector, the source port if there is one, the bytes.
std::string shown(const CapturedPacket& packet) {
  constexpr std::size_t kHead = 4;
  constexpr std::uint16_t kDissector = 12;
  constexpr std::uint16_t kSourcePort = 25;
  const modbus::Bytes bytes = packet.bytes;
  std::string text;
  std::size_t at = 0;
  while (modbus::load_be16(bytes, at) != 0) {
    const std::uint16_t tag = modbus::load_be16(bytes, at);
    const modbus::Bytes value = bytes.subspan(at + kHead, modbus::load_be16(bytes, at + 2));
    if (tag == kDissector) {
      text = std::string(value.begin(), std::find(value.begin(), value.end(), 0));
    } else if (tag == kSourcePort) {
      text += " " + std::to_string(modbus::load_be16(value, 2));
    }
    at += kHead + value.size();
  }
  text += ": " + modbus::hex(bytes.subspan(at + kHead));
  return packet.comment.empty() ? text : text + " # " + packet.comment;
}

using Shown = std::vector<std::string>;

Shown shown(const TracedFrame& frame) {
  Shown all;
  for (const CapturedPacket& packet : bus_packets(frame)) {
    all.push_back(shown(packet));
  }
  return all;
}

// Another client reads from unit 2 within our transaction, and its drive answers.
TEST(HeardFrames, OfOthersAreFromTheSideThatTheirLengthSays) {
  TracedFrame frame = answered(with_crc("01 03 00 00 00 01"), "03 02 12 34");
  frame.heard = {{{}, with_crc("02 03 00 00 00 01")},
                 {{}, with_crc("02 03 02 00 07")},
                 {{}, with_crc("02 06 00 00 00 01")},  // or the answer to it
                 {{}, with_crc("01 03 02 12 34")}};
  EXPECT_EQ(shown(frame), (Shown{"mbrtu 50000: 01 03 00 00 00 01 84 0A",
                                 "mbrtu 50000: 02 03 00 00 00 01 84 39 # not the response",
                                 "mbrtu 20502: 02 03 02 00 07 BD 86 # not the response",
                                 "mbrtu: 02 06 00 00 00 01 48 39 # not the response",
                                 "mbrtu 20502: 01 03 02 12 34 B5 33"}));
}

TEST(HeardFrames, ThatNobodyAskedForHaveASideToo) {
  TracedFrame frame;
  frame.outcome = TracedOutcome::unasked;
  frame.heard = {{{}, with_crc("02 03 00 00 00 01")}, {{}, with_crc("02 03 02 00 07")}};
  EXPECT_EQ(shown(frame),
            (Shown{"mbrtu 50000: 02 03 00 00 00 01 84 39", "mbrtu 20502: 02 03 02 00 07 BD 86"}));
}

TEST(HeardEcho, IsNoneWhereTheResponseIsNotBehindIt) {
  const ByteString write = with_crc("01 06 00 00 00 01");
  TracedFrame frame = answered(write, "06 00 00 00 01");
  ByteString heard = write;
  heard.push_back(0);
  frame.heard = {{{}, heard}};
  EXPECT_EQ(shown(frame),
            (Shown{"mbrtu 50000: 01 06 00 00 00 01 48 0A", "mbrtu 20502: 01 06 00 00 00 01 48 0A",
                   "data: 00 # no part of the response"}));
  frame.heard.push_back({{}, write});
  EXPECT_EQ(shown(frame),
            (Shown{"mbrtu 50000: 01 06 00 00 00 01 48 0A",
                   "data: 01 06 00 00 00 01 48 0A # the same bytes as sent: the adapter receives "
                   "what it sends",
                   "data: 00 # no part of the response", "mbrtu 20502: 01 06 00 00 00 01 48 0A"}));
}

// Wireshark has no dissector for ASCII.
TEST(HeardEcho, IsToldFromTheResponseInAsciiToo) {
  const auto pdu = *modbus::Pdu::from(test::unhex("06 00 00 00 01"));
  const auto characters = modbus::encode_ascii(1, pdu);
  const ByteString write(characters.begin(), characters.end());
  TracedFrame frame = answered(write, "06 00 00 00 01");
  frame.framing = TracedFraming::ascii;
  frame.heard = {{{}, write}};
  const std::string bytes = "data: " + modbus::hex(write);
  EXPECT_EQ(shown(frame), (Shown{bytes, bytes + " # what was heard"}));
  frame.heard.push_back({{}, write});
  EXPECT_EQ(shown(frame),
            (Shown{bytes, bytes + " # the same bytes as sent: the adapter receives what it sends",
                   bytes + " # what was heard"}));
}

}  // namespace
}  // namespace mbgate::ctl::bus_packets_test
