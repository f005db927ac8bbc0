// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "modbus/frames.hpp"
#include "report/text.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using gateway::WireTrace;

std::string heard(std::string_view bytes, bus::Framing framing = bus::Framing::rtu) {
  WireTrace wire;
  wire.framing = framing;
  wire.frame = unhex("01 03 00 00 00 01 84 0A");
  wire.heard.push_back({{}, unhex(bytes)});
  return report::heard_text(wire);
}

TEST(TraceText, SaysWhatWasSent) {
  WireTrace wire;
  wire.frame = unhex("01 03 00 1E 00 02 A4 0D");
  EXPECT_EQ(report::sent_text(wire), "unit 1: read holding registers 30..31");
}

TEST(TraceText, SaysWhatIsWrongWithAnRtuFrame) {
  EXPECT_EQ(heard("01 03 02 12 34 FF FF"), "CRC FF FF, B5 33 would be right");
  EXPECT_EQ(heard("01 03 02 12 34"), "5 bytes of 7: the frame is incomplete");
  EXPECT_EQ(heard("01 03 02 12 34 B5 33 FF"), "8 bytes, not exactly one frame");
  EXPECT_EQ(heard("01"), "1 byte, too few for a frame");
  EXPECT_EQ(heard(""), "nothing");
}

TEST(TraceText, SaysWhoseFrameItIs) {
  EXPECT_EQ(heard("02 03 02 12 34 F1 33"), "unit 2: 1 register: 0x1234");
}

TEST(TraceText, CallsACrcWrongOnlyWhereItIsKnownToBeOne) {
  EXPECT_EQ(heard("99 64 12 34 56 78 9A BC"), "8 bytes, no frame");
}

TEST(TraceText, ARequestThatNobodyHereHasSentIsOne) {
  WireTrace wire;
  wire.outcome = WireTrace::Outcome::unasked;
  wire.heard.push_back({{}, unhex("01 03 00 1E 00 02 A4 0D")});
  EXPECT_EQ(report::heard_text(wire), "unit 1: read holding registers 30..31");
  wire.heard = {{{}, unhex("02 03 02 12 34 F1 33")}};
  EXPECT_EQ(report::heard_text(wire), "unit 2: 1 register: 0x1234");
}

TEST(TraceText, SaysWhetherSomethingWasSentOfWhatWasCancelled) {
  EXPECT_STREQ(report::to_text(bus::Ending::cancelled, false), "cancelled before it was sent");
  EXPECT_STREQ(report::to_text(bus::Ending::cancelled, true), "cancelled before it was done");
}

TEST(TraceText, TellsWhatWasSentFromWhatCameThen) {
  EXPECT_EQ(heard("01 03 00 00 00 01 84 0A"), "the same bytes as sent, then nothing");
  EXPECT_EQ(heard("01 03 00 00 00 01 84 0A 01"),
            "the same bytes as sent, then 1 byte, too few for a frame");
}

TEST(TraceText, AResponseThatWasTakenIsNoEcho) {
  WireTrace wire;
  wire.frame = unhex("01 06 00 00 00 01 48 0A");
  wire.heard.push_back({{}, wire.frame});
  wire.response = unhex("06 00 00 00 01");
  EXPECT_EQ(report::heard_text(wire), "write single register 0 done");
}

/// What is said of a write that was answered, with these bytes heard.
std::string heard_of_write(const std::vector<std::uint8_t>& bytes, bus::Framing framing) {
  const auto pdu = *modbus::Pdu::from(unhex("06 00 00 00 01"));
  const auto rtu = modbus::encode_rtu(1, pdu);
  const auto ascii = modbus::encode_ascii(1, pdu);
  WireTrace wire;
  wire.address = 1;
  wire.framing = framing;
  wire.frame.assign(rtu.begin(), rtu.end());
  if (framing == bus::Framing::ascii) {
    wire.frame.assign(ascii.begin(), ascii.end());
  }
  wire.heard.push_back({{}, wire.frame});
  wire.heard.push_back({{}, bytes});
  wire.response = unhex("06 00 00 00 01");
  return report::heard_text(wire);
}

TEST(TraceText, AnEchoHasTheResponseBehindIt) {
  EXPECT_EQ(heard_of_write(unhex("00"), bus::Framing::rtu), "write single register 0 done");
  EXPECT_EQ(heard_of_write(unhex("00 01 06 00 00 00 01 48 0A"), bus::Framing::rtu),
            "the same bytes as sent, then write single register 0 done");
  EXPECT_EQ(heard_of_write(unhex("00"), bus::Framing::ascii), "write single register 0 done");
  EXPECT_EQ(heard_of_write(unhex("3A 30 31 30 36 30 30 30 30 30 30 30 31 46 38 0D 0A"),
                           bus::Framing::ascii),
            "the same bytes as sent, then write single register 0 done");
}

// ':', 01 03 02 12 34, its LRC, CR LF
TEST(TraceText, ReadsAscii) {
  EXPECT_EQ(heard("3A 30 31 30 33 30 32 31 32 33 34 42 34 0D 0A", bus::Framing::ascii),
            "unit 1: 1 register: 0x1234");
  EXPECT_EQ(heard("3A 30 31 30 33 30 32 31 32 33 34 42 35 0D 0A", bus::Framing::ascii),
            "its LRC is wrong");
  EXPECT_EQ(heard("3A 30 31", bus::Framing::ascii), "no complete ASCII frame");
}

}  // namespace
}  // namespace mbgate::test
