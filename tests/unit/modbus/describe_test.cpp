// SPDX-License-Identifier: Apache-2.0
#include "modbus/describe.hpp"

#include <gtest/gtest.h>

#include "modbus/frames.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

std::string request(std::string_view hex) { return describe_request(bytes_of(hex)); }
std::string response(std::string_view hex) { return describe_response(bytes_of(hex)); }

std::string rtu(std::string_view hex, Direction direction) {
  return describe_rtu(bytes_of(hex), direction);
}

std::string mbap(std::string_view hex, Direction direction) {
  return describe_mbap(bytes_of(hex), direction);
}

TEST(Describe, HexIsUpperCaseWithSpaces) {
  EXPECT_EQ(hex(bytes_of("01 03 00 1E")), "01 03 00 1E");
  EXPECT_EQ(hex(bytes_of("ff")), "FF");
  EXPECT_EQ(hex({}), "");
}

TEST(Describe, RequestsSayWhatTheyWant) {
  EXPECT_EQ(request("03 00 1E 00 02"), "read holding registers 30..31");
  EXPECT_EQ(request("04 03 E8 00 01"), "read input registers 1000");
  EXPECT_EQ(request("01 00 00 00 0A"), "read coils 0..9");
  EXPECT_EQ(request("02 FF FF 00 01"), "read discrete inputs 65535");
  EXPECT_EQ(request("03 FF 83 00 7D"), "read holding registers 65411..65535");
  EXPECT_EQ(request("05 00 0B FF 00"), "write single coil 11 = 0xFF00");
  EXPECT_EQ(request("06 00 7C 00 E1"), "write single register 124 = 0x00E1");
  EXPECT_EQ(request("0F 00 13 00 0A 02 CD 01"), "write multiple coils 19..28");
  EXPECT_EQ(request("10 00 7C 00 02 04 00 DB 00 01"),
            "write multiple registers 124..125 = 2 registers: 0x00DB 0x0001");
  EXPECT_EQ(request("16 00 04 00 F2 00 25"), "mask write register 4");
  EXPECT_EQ(request("17 00 03 00 06 00 0E 00 01 02 00 FF"),
            "read/write multiple registers, reads 3..8, writes 14");
  EXPECT_EQ(request("18 04 DE"), "read fifo queue 1246");
  EXPECT_EQ(request("07"), "read exception status, 0 bytes");
  EXPECT_EQ(request("08 00 00 A5 37"), "diagnostics, 4 bytes");
  EXPECT_EQ(request("46 01 02 03 04"), "function 70, 4 bytes");
}

TEST(Describe, MalformedRequestsAreShownWhole) {
  EXPECT_EQ(request("03 00 1E 00"), "read holding registers, malformed: 03 00 1E 00");
  EXPECT_EQ(request("03 00 1E 00 00"), "read holding registers, malformed: 03 00 1E 00 00");
  EXPECT_EQ(request("00"), "function 0, malformed: 00");
  EXPECT_EQ(request("83 02"), "function 131, malformed: 83 02");
  EXPECT_EQ(describe_request({}), "no PDU: 0 bytes");
  EXPECT_EQ(describe_request(bytes_of("41", 253, 0)), "no PDU: 254 bytes");
}

TEST(Describe, ResponsesSayWhatCame) {
  EXPECT_EQ(response("03 04 00 03 0D 40"), "2 registers: 0x0003 0x0D40");
  EXPECT_EQ(response("04 04 00 0A 00 14"), "2 registers: 0x000A 0x0014");
  EXPECT_EQ(response("17 04 00 FE 0A CD"), "2 registers: 0x00FE 0x0ACD");
  EXPECT_EQ(response("01 02 CD 01"), "bits: CD 01");
  EXPECT_EQ(response("06 00 7C 00 E1"), "write single register 124 done");
  EXPECT_EQ(response("10 00 7C 00 02"), "write multiple registers 124: 2 done");
  EXPECT_EQ(response("0F 00 13 00 0A"), "write multiple coils 19: 10 done");
  EXPECT_EQ(response("46 01 02"), "function 70, 2 bytes");
}

TEST(Describe, ExceptionsHaveTheirNames) {
  EXPECT_EQ(response("83 02"), "exception 0x02 (illegal data address)");
  EXPECT_EQ(response("86 13"), "exception 0x13");
  EXPECT_EQ(response("90 0B"), "exception 0x0B (gateway target device failed to respond)");
  EXPECT_EQ(response("83"), "exception, malformed: 83");
  EXPECT_EQ(response("83 02 00"), "exception, malformed: 83 02 00");
}

TEST(Describe, MalformedResponsesAreShownWhole) {
  EXPECT_EQ(describe_response({}), "no PDU: 0 bytes");
  EXPECT_EQ(response("03"), "read holding registers, malformed: 03");
  EXPECT_EQ(response("03 04 00 03"), "read holding registers, malformed: 03 04 00 03");
  EXPECT_EQ(response("06 00 7C 00"), "write single register, malformed: 06 00 7C 00");
}

// A register has two bytes: with an odd byte count no whole registers came.
TEST(Describe, RegistersWithAnOddByteCountAreMalformed) {
  EXPECT_EQ(response("03 03 00 03 0D"), "read holding registers, malformed: 03 03 00 03 0D");
  EXPECT_EQ(response("04 01 FF"), "read input registers, malformed: 04 01 FF");
}

TEST(Describe, RtuFramesNameTheirUnit) {
  EXPECT_EQ(rtu("01 03 00 1E 00 02 A4 0D", Direction::request),
            "unit 1: read holding registers 30..31");
  EXPECT_EQ(rtu("02 81 02 31 91", Direction::response),
            "unit 2: exception 0x02 (illegal data address)");
  EXPECT_EQ(rtu("01 03 00 1E 00 02 A4 0C", Direction::request),
            "not an RTU frame (size or CRC): 01 03 00 1E 00 02 A4 0C");
  EXPECT_EQ(describe_rtu({}, Direction::request), "not an RTU frame (size or CRC): ");
}

TEST(Describe, MbapAdusNameTransactionAndUnit) {
  EXPECT_EQ(mbap("00 07 00 00 00 06 01 03 00 1E 00 02", Direction::request),
            "transaction 7 unit 1: read holding registers 30..31");
  EXPECT_EQ(mbap("FF FF 00 00 00 03 FF 83 0A", Direction::response),
            "transaction 65535 unit 255: exception 0x0A (gateway path unavailable)");
}

TEST(Describe, MbapSaysWhatIsWrong) {
  EXPECT_EQ(mbap("00 01 00 05 00 02 01 07", Direction::request),
            "protocol identifier 5 instead of 0: 00 01 00 05 00 02 01 07");
  EXPECT_EQ(mbap("00 01 00 00 FF FF", Direction::request),
            "length 65535, not 2 to 254: 00 01 00 00 FF FF");
  EXPECT_EQ(mbap("00 01 00 00 00 06 01", Direction::request), "incomplete: 00 01 00 00 00 06 01");
}

// Every function with every length up to 12 and several fillings, in every role: a line comes out.
TEST(Describe, NeverFailsWhateverTheBytes) {
  for (unsigned function = 0; function < 256; ++function) {
    for (std::size_t size = 1; size <= 12; ++size) {
      for (const unsigned fill : {0x00U, 0x01U, 0x02U, 0x0EU, 0x7FU, 0xFFU}) {
        std::vector<std::uint8_t> bytes(size, static_cast<std::uint8_t>(fill));
        bytes[0] = static_cast<std::uint8_t>(function);
        ASSERT_FALSE(describe_request(bytes).empty());
        ASSERT_FALSE(describe_response(bytes).empty());
        const RtuBytes frame = encode_rtu(1, pdu_of(bytes));
        for (const Direction direction : {Direction::request, Direction::response}) {
          ASSERT_FALSE(describe_mbap(bytes, direction).empty());
          ASSERT_EQ(describe_rtu({frame.data(), frame.size()}, direction).rfind("unit 1: ", 0), 0U);
        }
      }
    }
  }
}

TEST(Describe, NeverFailsWithLongBytes) {
  for (const std::size_t size : {13U, 252U, 253U, 254U, 256U, 260U, 300U}) {
    for (unsigned function = 0; function < 256; ++function) {
      std::vector<std::uint8_t> bytes(size);
      for (std::size_t at = 0; at < size; ++at) {
        bytes[at] = static_cast<std::uint8_t>(at * 31 + function);
      }
      ASSERT_FALSE(describe_request(bytes).empty());
      ASSERT_FALSE(describe_response(bytes).empty());
      ASSERT_FALSE(describe_rtu(bytes, Direction::request).empty());
      ASSERT_FALSE(describe_mbap(bytes, Direction::response).empty());
    }
  }
}

}  // namespace
}  // namespace mbgate::modbus
