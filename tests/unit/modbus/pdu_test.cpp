// SPDX-License-Identifier: Apache-2.0
#include "modbus/pdu.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

TEST(Pdu, HasOneTo253Bytes) {
  EXPECT_FALSE(Pdu::from({}).has_value());
  EXPECT_TRUE(Pdu::from(bytes_of("07")).has_value());
  EXPECT_EQ(pdu_of(bytes_of("41", 252, 0)).size(), 253U);
  EXPECT_FALSE(Pdu::from(bytes_of("41", 253, 0)).has_value());
}

TEST(Pdu, KeepsItsBytes) {
  const auto bytes = bytes_of("10 00 7C 00 02 04 00 DB 00 01");
  const Pdu pdu = pdu_of(bytes);
  EXPECT_EQ(pdu.function(), 0x10);
  EXPECT_FALSE(pdu.is_exception());
  EXPECT_THAT(pdu.bytes(), ElementsAreArray(bytes));
}

TEST(Pdu, IsACopy) {
  auto bytes = bytes_of("06 00 7C 00 E1");
  const Pdu pdu = pdu_of(bytes);
  bytes[0] = 0x10;
  EXPECT_EQ(pdu.function(), 0x06);
}

TEST(Pdu, ExceptionIsTheFunctionWithItsHighBitAndTheCode) {
  const Pdu pdu = Pdu::exception(0x03, ExceptionCode::gateway_target_failed_to_respond);
  EXPECT_TRUE(pdu.is_exception());
  EXPECT_THAT(pdu.bytes(), ElementsAre(0x83, 0x0B));
  EXPECT_THAT(Pdu::exception(0x10, ExceptionCode::illegal_data_value).bytes(),
              ElementsAre(0x90, 0x03));
}

TEST(Pdu, ExceptionToAnIllegalFunctionStaysAnException) {
  EXPECT_THAT(Pdu::exception(0x00, ExceptionCode::illegal_function).bytes(),
              ElementsAre(0x80, 0x01));
  EXPECT_THAT(Pdu::exception(0xFF, ExceptionCode::illegal_function).bytes(),
              ElementsAre(0xFF, 0x01));
}

TEST(Pdu, FieldsAreWrittenBigEndian) {
  Pdu pdu = pdu_of("03 00 1E 00 02");
  pdu.set_be16(1, 0x1453);
  EXPECT_THAT(pdu.bytes(), ElementsAre(0x03, 0x14, 0x53, 0x00, 0x02));
}

TEST(Pdu, EqualityIsThatOfTheBytes) {
  EXPECT_EQ(pdu_of("03 00 1E 00 02"), pdu_of("03 00 1E 00 02"));
  EXPECT_NE(pdu_of("03 00 1E 00 02"), pdu_of("03 00 1E 00 03"));
  EXPECT_NE(pdu_of("03 00"), pdu_of("03"));
}

TEST(Bytes, LoadAndStoreAreBigEndian) {
  std::vector<std::uint8_t> bytes = bytes_of("00 12 34 FF");
  EXPECT_EQ(load_be16(bytes, 1), 0x1234);
  store_be16(bytes, 2, 0xABCD);
  EXPECT_THAT(bytes, ElementsAre(0x00, 0x12, 0xAB, 0xCD));
}

}  // namespace
}  // namespace mbgate::modbus
