// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/command.hpp"

#include <gtest/gtest.h>

namespace mbgate::ctl {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <typename AnyCommand>
Bytes request_bytes(const AnyCommand& command) {
  const auto request = make_request(command);
  if (!request) {
    ADD_FAILURE() << request.error();
    return {};
  }
  const auto bytes = request->pdu().bytes();
  return {bytes.begin(), bytes.end()};
}

ReadCommand read(Table table, std::uint16_t address, ValueType type, std::size_t count) {
  ReadCommand command;
  command.place = {table, address, type, drive::WordOrder::big};
  command.count = count;
  return command;
}

WriteCommand write(Table table, std::uint16_t address, ValueType type,
                   std::vector<std::uint64_t> values) {
  WriteCommand command;
  command.place = {table, address, type, drive::WordOrder::big};
  command.values = std::move(values);
  return command;
}

TEST(ReadCommand, UsesTheFunctionOfItsTable) {
  // function, address, quantity
  EXPECT_EQ(request_bytes(read(Table::coils, 5, ValueType::bit, 4)),
            (Bytes{0x01, 0x00, 0x05, 0x00, 0x04}));
  EXPECT_EQ(request_bytes(read(Table::discrete_inputs, 5, ValueType::bit, 4)),
            (Bytes{0x02, 0x00, 0x05, 0x00, 0x04}));
  EXPECT_EQ(request_bytes(read(Table::holding_registers, 0x1E, ValueType::i32, 2)),
            (Bytes{0x03, 0x00, 0x1E, 0x00, 0x04}));
  EXPECT_EQ(request_bytes(read(Table::input_registers, 0x68, ValueType::u16, 1)),
            (Bytes{0x04, 0x00, 0x68, 0x00, 0x01}));
}

TEST(ReadCommand, MustFitIntoOneRequest) {
  EXPECT_TRUE(make_request(read(Table::holding_registers, 0, ValueType::u16, 125)));
  EXPECT_TRUE(make_request(read(Table::coils, 0, ValueType::bit, 2000)));
  EXPECT_EQ(make_request(read(Table::holding_registers, 0, ValueType::u16, 126)).error(),
            "126 values do not fit into one request: 1 to 125");
  EXPECT_EQ(make_request(read(Table::holding_registers, 0, ValueType::i32, 63)).error(),
            "63 values do not fit into one request: 1 to 62");
  EXPECT_TRUE(make_request(read(Table::holding_registers, 0, ValueType::f64, 31)));
  EXPECT_EQ(make_request(read(Table::holding_registers, 0, ValueType::f64, 32)).error(),
            "32 values do not fit into one request: 1 to 31");
  EXPECT_TRUE(make_request(read(Table::holding_registers, 0, ValueType::text, 125)));
  EXPECT_EQ(make_request(read(Table::holding_registers, 0, ValueType::text, 126)).error(),
            "126 registers do not fit into one request: 1 to 125, two characters each");
  EXPECT_EQ(make_request(read(Table::coils, 0, ValueType::bit, 2001)).error(),
            "2001 values do not fit into one request: 1 to 2000");
  EXPECT_EQ(make_request(read(Table::holding_registers, 0, ValueType::u16, 0)).error(),
            "0 values do not fit into one request: 1 to 125");
}

TEST(ReadCommand, MustEndWithinTheTable) {
  EXPECT_TRUE(make_request(read(Table::holding_registers, 65534, ValueType::u32, 1)));
  EXPECT_TRUE(make_request(read(Table::holding_registers, 65532, ValueType::u64, 1)));
  EXPECT_EQ(make_request(read(Table::holding_registers, 65533, ValueType::u64, 1)).error(),
            "the last value would end at address 65536, beyond 65535");
  EXPECT_EQ(make_request(read(Table::holding_registers, 65535, ValueType::u32, 1)).error(),
            "the last value would end at address 65536, beyond 65535");
}

TEST(ReadCommand, TakesItsValuesOutOfTheResponse) {
  const auto pdu = [](Bytes bytes) { return *modbus::Pdu::from(bytes); };
  auto command = read(Table::holding_registers, 0, ValueType::i32, 2);
  // function, byte count, two values
  const auto response = pdu({0x03, 0x08, 0x00, 0x03, 0x0D, 0x40, 0xFF, 0xFF, 0xFF, 0xFB});
  EXPECT_EQ(response_values(command, response), (std::vector<std::uint64_t>{200000, 0xFFFFFFFB}));
  command.place.order = drive::WordOrder::little;
  EXPECT_EQ(response_values(command, response),
            (std::vector<std::uint64_t>{0x0D400003, 0xFFFBFFFF}));
  EXPECT_EQ(
      response_values(read(Table::coils, 0, ValueType::bit, 10), pdu({0x01, 0x02, 0x05, 0x02})),
      (std::vector<std::uint64_t>{1, 0, 1, 0, 0, 0, 0, 0, 0, 1}));
}

TEST(WriteCommand, OfOneRegisterUsesFunction06) {
  auto command = write(Table::holding_registers, 0x7C, ValueType::u16, {0xD8});
  EXPECT_EQ(request_bytes(command), (Bytes{0x06, 0x00, 0x7C, 0x00, 0xD8}));
  command.multiple = true;
  EXPECT_EQ(request_bytes(command), (Bytes{0x10, 0x00, 0x7C, 0x00, 0x01, 0x02, 0x00, 0xD8}));
}

TEST(WriteCommand, NeverTearsAValue) {
  auto command = write(Table::holding_registers, 0x1E, ValueType::i32, {0x00030D40});
  EXPECT_EQ(request_bytes(command),
            (Bytes{0x10, 0x00, 0x1E, 0x00, 0x02, 0x04, 0x00, 0x03, 0x0D, 0x40}));
  command.place.order = drive::WordOrder::little;
  EXPECT_EQ(request_bytes(command),
            (Bytes{0x10, 0x00, 0x1E, 0x00, 0x02, 0x04, 0x0D, 0x40, 0x00, 0x03}));
}

TEST(WriteCommand, MirrorsAValueOf64BitsWordByWord) {
  auto command = write(Table::holding_registers, 0, ValueType::u64, {0x0123'4567'89AB'CDEF});
  EXPECT_EQ(request_bytes(command), (Bytes{0x10, 0x00, 0x00, 0x00, 0x04, 0x08, 0x01, 0x23, 0x45,
                                           0x67, 0x89, 0xAB, 0xCD, 0xEF}));
  command.place.order = drive::WordOrder::little;
  EXPECT_EQ(request_bytes(command), (Bytes{0x10, 0x00, 0x00, 0x00, 0x04, 0x08, 0xCD, 0xEF, 0x89,
                                           0xAB, 0x45, 0x67, 0x01, 0x23}));
}

TEST(WriteCommand, OfCoilsUsesFunctions05And15) {
  EXPECT_EQ(request_bytes(write(Table::coils, 11, ValueType::bit, {1})),
            (Bytes{0x05, 0x00, 0x0B, 0xFF, 0x00}));
  EXPECT_EQ(request_bytes(write(Table::coils, 11, ValueType::bit, {0})),
            (Bytes{0x05, 0x00, 0x0B, 0x00, 0x00}));
  EXPECT_EQ(request_bytes(write(Table::coils, 11, ValueType::bit, {1, 0, 1, 0, 0, 0, 0, 0, 1})),
            (Bytes{0x0F, 0x00, 0x0B, 0x00, 0x09, 0x02, 0x05, 0x01}));
}

TEST(WriteCommand, MustFitIntoOneRequest) {
  EXPECT_EQ(make_request(
                write(Table::holding_registers, 0, ValueType::u16, std::vector<std::uint64_t>(124)))
                .error(),
            "124 values do not fit into one request: 1 to 123");
  EXPECT_TRUE(make_request(
      write(Table::holding_registers, 0, ValueType::i64, std::vector<std::uint64_t>(30))));
  EXPECT_EQ(make_request(
                write(Table::holding_registers, 0, ValueType::i64, std::vector<std::uint64_t>(31)))
                .error(),
            "31 values do not fit into one request: 1 to 30");
  EXPECT_EQ(make_request(write(Table::holding_registers, 0, ValueType::text,
                               std::vector<std::uint64_t>(124)))
                .error(),
            "124 registers do not fit into one request: 1 to 123, two characters each");
  EXPECT_EQ(make_request(write(Table::coils, 0, ValueType::bit, std::vector<std::uint64_t>(1969)))
                .error(),
            "1969 values do not fit into one request: 1 to 1968");
  EXPECT_EQ(make_request(write(Table::holding_registers, 65535, ValueType::u16, {1, 2})).error(),
            "the last value would end at address 65536, beyond 65535");
}

}  // namespace
}  // namespace mbgate::ctl
