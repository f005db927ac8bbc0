// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "modbus/request.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using Kind = modbus::PduLength::Kind;

TEST(RequestLength, IsThatOfTheSpecificationsExamples) {
  for (const auto* request :
       {"01 0013 0013", "02 00C4 0016", "03 006B 0003", "04 0008 0001", "05 00AC FF00",
        "06 0001 0003", "07", "0B", "0C", "0F 0013 000A 02 CD01", "10 0001 0002 04 000A 0102", "11",
        "14 0E 06 0004 0001 0002 06 0003 0009 0002", "16 0004 00F2 0025",
        "17 0003 0006 000E 0003 06 00FF 00FF 00FF", "18 04DE"}) {
    const auto bytes = unhex(request);
    const auto length = modbus::request_length(bytes);
    EXPECT_EQ(length.kind, Kind::known) << request;
    EXPECT_EQ(length.bytes, bytes.size()) << request;
  }
}

TEST(RequestLength, WaitsForTheByteCount) {
  EXPECT_EQ(modbus::request_length(unhex("10 0001 0002")).kind, Kind::need_more);
  EXPECT_EQ(modbus::request_length(unhex("17 0003 0006 000E 0003")).kind, Kind::need_more);
}

TEST(RequestLength, IsNotKnownOfOtherFunctions) {
  for (const auto* request : {"08 0000 A537", "2B 0E 01 00", "46 01", "83 02"}) {
    EXPECT_EQ(modbus::request_length(unhex(request)).kind, Kind::opaque);
  }
}

}  // namespace
}  // namespace mbgate::test
