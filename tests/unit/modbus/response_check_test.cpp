// SPDX-License-Identifier: Apache-2.0
// Which responses are taken for which request: the last door before a wrong answer reaches a
// client.
#include <gtest/gtest.h>

#include "modbus/response.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using enum ResponseFit;

ResponseFit check(std::string_view request, std::string_view response) {
  return check_response(*Request::parse(pdu_of(request)), bytes_of(response));
}

TEST(CheckResponse, TakesTheByteCountThatWasAskedFor) {
  EXPECT_EQ(check("01 00 13 00 25", "01 05 CD 6B B2 0E 1B"), normal);
  EXPECT_EQ(check("02 00 C4 00 16", "02 03 AC DB 35"), normal);
  EXPECT_EQ(check("03 00 1E 00 02", "03 04 00 03 0D 40"), normal);
  EXPECT_EQ(check("04 00 08 00 01", "04 02 00 0A"), normal);
  EXPECT_EQ(check("17 00 03 00 01 00 0E 00 01 02 00 FF", "17 02 00 FE"), normal);
}

TEST(CheckResponse, RefusesAnotherByteCount) {
  EXPECT_EQ(check("01 00 13 00 25", "01 04 CD 6B B2 0E"), wrong_length);
  EXPECT_EQ(check("01 00 13 00 25", "01 06 CD 6B B2 0E 1B 00"), wrong_length);
  EXPECT_EQ(check("03 00 1E 00 02", "03 02 00 03"), wrong_length);
  EXPECT_EQ(check("03 00 1E 00 02", "03 06 00 03 0D 40 00 00"), wrong_length);
  EXPECT_EQ(check("17 00 03 00 01 00 0E 00 01 02 00 FF", "17 04 00 FE 00 00"), wrong_length);
}

TEST(CheckResponse, RefusesAByteCountThatLiesWithinTheRightLength) {
  EXPECT_EQ(check("03 00 1E 00 02", "03 02 00 03 0D 40"), wrong_length);
  EXPECT_EQ(check("03 00 1E 00 02", "03 FF 00 03 0D 40"), wrong_length);
  EXPECT_EQ(check("01 00 13 00 08", "01 00 CD"), wrong_length);
}

TEST(CheckResponse, RefusesAnotherFunction) {
  EXPECT_EQ(check("03 00 1E 00 02", "04 04 00 03 0D 40"), wrong_function);
  EXPECT_EQ(check("06 00 7C 00 E1", "10 00 7C 00 E1"), wrong_function);
  EXPECT_EQ(check("03 00 1E 00 02", "84 02"), wrong_function);
  EXPECT_EQ(check("03 00 1E 00 02", "00 04 00 03 0D 40"), wrong_function);
}

TEST(CheckResponse, TakesTheExceptionOfItsFunction) {
  EXPECT_EQ(check("03 00 1E 00 02", "83 02"), exception);
  EXPECT_EQ(check("10 00 7C 00 01 02 00 E1", "90 13"), exception);
  EXPECT_EQ(check("46 01", "C6 05"), exception);
  EXPECT_EQ(check("03 00 1E 00 02", "83"), wrong_length);
  EXPECT_EQ(check("03 00 1E 00 02", "83 02 00"), wrong_length);
}

TEST(CheckResponse, SingleWritesEchoAddressAndValue) {
  EXPECT_EQ(check("06 00 7C 00 E1", "06 00 7C 00 E1"), normal);
  EXPECT_EQ(check("06 00 7C 00 E1", "06 00 7D 00 E1"), wrong_echo);
  EXPECT_EQ(check("06 00 7C 00 E1", "06 01 7C 00 E1"), wrong_echo);
  EXPECT_EQ(check("06 00 7C 00 E1", "06 00 7C 00 E2"), wrong_echo);
  EXPECT_EQ(check("06 00 7C 00 E1", "06 00 7C 00"), wrong_length);
  EXPECT_EQ(check("05 00 0B FF 00", "05 00 0B FF 00"), normal);
  EXPECT_EQ(check("05 00 0B FF 00", "05 00 0B 00 00"), wrong_echo);
}

TEST(CheckResponse, MultipleWritesEchoAddressAndQuantity) {
  EXPECT_EQ(check("10 00 7C 00 02 04 00 DB 00 01", "10 00 7C 00 02"), normal);
  EXPECT_EQ(check("10 00 7C 00 02 04 00 DB 00 01", "10 00 7C 00 01"), wrong_echo);
  EXPECT_EQ(check("10 00 7C 00 02 04 00 DB 00 01", "10 00 7E 00 02"), wrong_echo);
  EXPECT_EQ(check("10 00 7C 00 02 04 00 DB 00 01", "10 00 7C 00 02 04"), wrong_length);
  EXPECT_EQ(check("0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0A"), normal);
  EXPECT_EQ(check("0F 00 13 00 0A 02 CD 01", "0F 00 13 00 0B"), wrong_echo);
}

TEST(CheckResponse, MaskWriteEchoesAllFields) {
  EXPECT_EQ(check("16 00 04 00 F2 00 25", "16 00 04 00 F2 00 25"), normal);
  for (const auto* response :
       {"16 00 05 00 F2 00 25", "16 00 04 00 F3 00 25", "16 00 04 00 F2 00 24"}) {
    EXPECT_EQ(check("16 00 04 00 F2 00 25", response), wrong_echo) << response;
  }
}

TEST(CheckResponse, DiagnosticsEchoTheSubFunctionAndLoopbackItsData) {
  EXPECT_EQ(check("08 00 00 A5 37", "08 00 00 A5 37"), normal);
  EXPECT_EQ(check("08 00 00 A5 37", "08 00 00 A5 38"), wrong_echo);
  EXPECT_EQ(check("08 00 0B 00 00", "08 00 0B 00 2A"), normal);
  EXPECT_EQ(check("08 00 0B 00 00", "08 00 0B 12 2A"), normal);
  EXPECT_EQ(check("08 00 0B 00 00", "08 00 0C 00 2A"), wrong_echo);
  EXPECT_EQ(check("08 00 00 A5 37", "08 00 00 A5 37 00 00"), wrong_length);
}

TEST(CheckResponse, WriteFileRecordEchoesAllFields) {
  const auto* request = "15 09 06 00 04 00 07 00 01 06 AF";
  EXPECT_EQ(check(request, request), normal);
  EXPECT_EQ(check(request, "15 09 06 00 04 00 07 00 01 06 AE"), wrong_echo);
}

TEST(CheckResponse, CountedAnswersMustBeWhole) {
  EXPECT_EQ(check("11", "11 03 00 FF 41"), normal);
  EXPECT_EQ(check("11", "11 03 00 FF"), wrong_length);
  EXPECT_EQ(check("11", "11"), wrong_length);
  EXPECT_EQ(check("0C", "0C 08 00 00 01 08 01 21 20 00"), normal);
  EXPECT_EQ(check("14 07 06 00 04 00 01 00 02", "14 06 05 06 0D FE 00 20"), normal);
  EXPECT_EQ(check("18 04 DE", "18 00 06 00 02 01 B8 12 84"), normal);
  EXPECT_EQ(check("18 04 DE", "18 00 06 00 02 01 B8 12"), wrong_length);
  EXPECT_EQ(check("07", "07 6D"), normal);
  EXPECT_EQ(check("0B", "0B FF FF 01 08"), normal);
}

// An echo of the request has the right length, but is no answer to it.
TEST(CheckResponse, FileRecordsAreThoseThatWereAskedFor) {
  const auto* request = "14 07 06 00 04 00 01 00 02";
  EXPECT_EQ(check(request, "14 06 05 06 0D FE 00 20"), normal);
  EXPECT_EQ(check(request, request), wrong_echo);
  EXPECT_EQ(check(request, "14 04 03 06 0D FE"), wrong_echo);
  EXPECT_EQ(check(request, "14 06 05 07 0D FE 00 20"), wrong_echo);
  EXPECT_EQ(check("14 0E 06 00 04 00 01 00 01 06 00 03 00 09 00 02",
                  "14 0A 03 06 0D FE 05 06 33 CD 00 40"),
            normal);
  EXPECT_EQ(check("14 0E 06 00 04 00 01 00 01 06 00 03 00 09 00 02",
                  "14 0A 05 06 0D FE 00 20 03 06 33 CD"),
            wrong_echo);
}

TEST(CheckResponse, TheByteCountOfAQueueFitsItsCount) {
  EXPECT_EQ(check("18 00 00", "18 00 02 00 00"), normal);
  EXPECT_EQ(check("18 00 00", "18 00 00"), wrong_echo);
  EXPECT_EQ(check("18 04 DE", "18 00 04 00 02 01 B8"), wrong_echo);
}

TEST(CheckResponse, DeviceIdentificationMustBeWholeAndOfItsType) {
  EXPECT_EQ(check("2B 0E 01 00", "2B 0E 01 01 00 00 01 00 02 41 42"), normal);
  EXPECT_EQ(check("2B 0E 01 00", "2B 0E 01 01 00 00 01 00 02 41"), wrong_length);
  EXPECT_EQ(check("2B 0E 01 00", "2B 0E 01 01 00 00 02 00 02 41 42"), wrong_length);
  EXPECT_EQ(check("2B 0E 01 00", "2B 0D 01 01"), wrong_echo);
  EXPECT_EQ(check("2B 0E 01 00", "2B"), wrong_length);
}

TEST(CheckResponse, UnknownFunctionsMayAnswerAnything) {
  EXPECT_EQ(check("46 01", "46"), normal);
  EXPECT_EQ(check("46 01", "46 01 02 03 04 05"), normal);
  EXPECT_EQ(check("46 01", "47 01"), wrong_function);
}

}  // namespace
}  // namespace mbgate::modbus
