// SPDX-License-Identifier: Apache-2.0
#include "ctl/trace/pcapng.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "ctl/trace/trace_capture.hpp"
#include "trace_records.hpp"

namespace mbgate::ctl {
namespace {

TEST(Pcapng, PacketHasItsInstantBytesAndComment) {
  const CapturedPacket packet{TraceInstant(std::chrono::microseconds(0x0006'0102'0304'0506)),
                              Heading::outbound,
                              {0xAA, 0xBB, 0xCC},
                              "bad"};
  const ByteString expected{6,    0,    0,    0,                       // Enhanced Packet Block
                            56,   0,    0,    0,                       // its length
                            2,    0,    0,    0,                       // interface
                            0x02, 0x01, 0x06, 0x00,                    // instant, high half
                            0x06, 0x05, 0x04, 0x03,                    // instant, low half
                            3,    0,    0,    0,                       // captured
                            3,    0,    0,    0,                       // original
                            0xAA, 0xBB, 0xCC, 0,                       // bytes, padded
                            1,    0,    3,    0,    'b', 'a', 'd', 0,  // opt_comment
                            2,    0,    4,    0,    2,   0,   0,   0,  // epb_flags: outbound
                            0,    0,    0,    0,                       // opt_endofopt
                            56,   0,    0,    0};
  EXPECT_EQ(packet_block(2, packet), expected);
}

TEST(Pcapng, SectionAndInterfaceComeFirst) {
  const ByteString section = section_block("x");
  EXPECT_EQ(section.size(), 40U);
  EXPECT_EQ(ByteString(section.begin(), section.begin() + 12),
            (ByteString{0x0A, 0x0D, 0x0D, 0x0A, 40, 0, 0, 0, 0x4D, 0x3C, 0x2B, 0x1A}));
  const ByteString expected{1,   0, 0, 0, 48,  0, 0, 0,  // Interface Description Block
                            252, 0, 0, 0, 0,   0, 0, 0,  // link type, no limit of a packet
                            2,   0, 1, 0, 'a', 0, 0, 0,  // if_name
                            3,   0, 1, 0, 'b', 0, 0, 0,  // if_description
                            9,   0, 1, 0, 6,   0, 0, 0,  // if_tsresol: microseconds
                            0,   0, 0, 0, 48,  0, 0, 0};
  EXPECT_EQ(interface_block(LinkType::upper_pdu, "a", "b"), expected);
}

std::uint32_t sum_of(modbus::Bytes bytes) {
  std::uint32_t sum = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    sum += at % 2 == 0 ? bytes[at] * 0x100U : bytes[at];
  }
  return sum % 0xFFFF;
}

TEST(Segment, HasChecksumsThatAreRight) {
  for (const auto& [client, gateway, header] :
       {std::tuple("192.0.2.7", "192.0.2.1", 20), std::tuple("fd00::7", "2001:db8::1", 40)}) {
    const TcpEndpoint from{*ip_octets(client), 1027};
    const TcpEndpoint to{*ip_octets(gateway), 502};
    const ByteString data{1, 2, 3};
    const ByteString packet = tcp_segment(from, to, {5, 9}, data);
    ASSERT_EQ(packet.size(), static_cast<std::size_t>(header) + 20 + data.size());
    if (header == 20) {
      EXPECT_EQ(sum_of(modbus::Bytes(packet).first(20)), 0U) << client;
    }
    ByteString covered = from.address;
    covered.insert(covered.end(), to.address.begin(), to.address.end());
    covered.insert(covered.end(), {0, 23, 0, 6});
    covered.insert(covered.end(), packet.begin() + header, packet.end());
    EXPECT_EQ(sum_of(covered), 0U) << client;
  }
  EXPECT_EQ(ip_octets("plc"), std::nullopt);
}

/// The name of the dissector that Wireshark is told.
std::string dissector_of(const CapturedPacket& packet) {
  return {packet.bytes.begin() + 4, packet.bytes.begin() + 4 + packet.bytes.at(3)};
}

TEST(BusPackets, GiveGoodFramesToTheirDissector) {
  const auto packets = bus_packets(parse_trace(read_record(good_frame())).wire.at(0));
  ASSERT_EQ(packets.size(), 2U);
  EXPECT_EQ(dissector_of(packets[0]), std::string("mbrtu\0\0\0", 8));
  EXPECT_EQ(packets[0].heading, Heading::outbound);
  EXPECT_EQ(dissector_of(packets[1]), std::string("mbrtu\0\0\0", 8));
  EXPECT_EQ(packets[1].heading, Heading::inbound);
  EXPECT_EQ(packets[1].comment, "");
}

TEST(BusPackets, GiveBadBytesToNobodyWhoWouldCallThemMalformed) {
  const auto packets = bus_packets(parse_trace(failed_record(damaged_frame())).wire.at(0));
  ASSERT_EQ(packets.size(), 2U);
  EXPECT_EQ(dissector_of(packets[1]), "data");
  EXPECT_TRUE(packets[1].comment.starts_with("CRC FF FF, ")) << packets[1].comment;
}

TEST(BusPackets, FindTheResponseBehindAnEchoAndNoise) {
  TracedFrame frame = parse_trace(read_record(good_frame())).wire.at(0);
  const ByteString response = frame.heard.at(0).bytes;
  ByteString heard = frame.sent->raw.bytes;
  heard.push_back(0);
  heard.insert(heard.end(), response.begin(), response.end());
  frame.heard.at(0).bytes = heard;
  const auto packets = bus_packets(frame);
  ASSERT_EQ(packets.size(), 4U);
  EXPECT_EQ(packets[1].comment, "the same bytes as sent: the adapter receives what it sends");
  EXPECT_EQ(packets[2].comment, "no part of the response");
  EXPECT_EQ(ByteString(packets[3].bytes.end() - 9, packets[3].bytes.end()), response);
}

}  // namespace
}  // namespace mbgate::ctl
