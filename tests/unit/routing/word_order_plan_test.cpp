// SPDX-License-Identifier: Apache-2.0
// Word order on the way to a device: clients see big-endian values, the drive is low word first.
#include "device_rig.hpp"

namespace mbgate::test {
namespace {

TEST(WordOrderPlan, ExchangesTheWordsOfValuesOnly) {
  const auto device = small_drive();
  const Planned read(device, "03 0003 0004");
  EXPECT_EQ(read.requests(), Texts{"03 00 03 00 05"});  // 7 belongs to the value at 6
  EXPECT_EQ(read.answer({"03 0A 0333 0444 0555 0666 0777"}), "03 08 03 33 05 55 04 44 07 77");
  EXPECT_EQ(Planned(device, "10 0003 0004 08 0333 0444 0555 0888").requests(),
            Texts{kIllegalValue});
  EXPECT_EQ(Planned(device, "10 0003 0003 06 0333 0444 0555").requests(),
            Texts{"10 00 03 00 03 06 03 33 05 55 04 44"});
}

TEST(WordOrderPlan, LeavesEverythingAloneWhereTheOrdersAreTheSame) {
  const auto device = small_drive(WordOrder::big);
  const Planned half(device, "03 0005 0001");
  EXPECT_EQ(half.requests(), Texts{"03 00 05 00 01"});
  EXPECT_EQ(half.answer({"03 02 1234"}), "03 02 12 34");
  EXPECT_EQ(Planned(device, "10 0004 0002 04 0001 0002").requests(),
            Texts{"10 00 04 00 02 04 00 01 00 02"});
  EXPECT_EQ(Planned(device, "06 0004 0001").requests(), Texts{"06 00 04 00 01"});
  // The client sees the same whatever the drive speaks: a cut value is refused here too.
  EXPECT_EQ(Planned(device, "10 0004 0001 02 0001").requests(), Texts{kIllegalValue});
}

TEST(WordOrderPlan, ARouteWithoutAnOrderExchangesNothing) {
  const auto device = small_drive();
  EXPECT_EQ(Planned(device, "03 0005 0001", {}).requests(), Texts{"03 00 05 00 01"});
  EXPECT_EQ(Planned(device, "10 0004 0002 04 0001 0002", {}).requests(),
            Texts{"10 00 04 00 02 04 00 01 00 02"});
  EXPECT_EQ(Planned(device, "10 0005 0002 04 0001 0002", {}).requests(), Texts{kIllegalValue});
}

TEST(WordOrderPlan, AsksADriveForItsOrderBeforeValuesAreWrittenButNotBeforeAStop) {
  auto device = small_drive();
  device.verify_word_order = true;
  device.profile.word_order_register = drive::WordOrderRegister{5, {5}, {133}};
  device.profile.stops = {{Table::holding_registers, 9, 0xFFFF, 0xE1, false, 2}};
  EXPECT_EQ(Planned(device, "10 0009 0003 06 00E2 0001 0002").requests(),
            (Texts{"03 00 05 00 01", "10 00 09 00 03 06 00 E2 00 02 00 01"}));
  device.bus = drive::BusId{1};
  EXPECT_EQ(Planned(device, "10 0009 0003 06 00E2 0001 0002").plan->transactions()[0].bus,
            device.bus);
  EXPECT_EQ(Planned(device, "10 0009 0003 06 00E1 0001 0002").requests(),
            Texts{"10 00 09 00 03 06 00 E1 00 02 00 01"});
  EXPECT_EQ(Planned(device, "17 0004 0002 0001 0001 02 1234").requests(),
            Texts{"17 00 04 00 02 00 01 00 01 02 12 34"})
      << "it only reads a value";
}

TEST(WordOrderPlan, WidensAReadOfHalfAValueAndTrimsTheAnswer) {
  const auto device = small_drive();
  const Planned high(device, "03 0004 0001");
  EXPECT_EQ(high.requests(), Texts{"03 00 04 00 02"});
  EXPECT_EQ(high.answer({"03 04 5678 1234"}), "03 02 12 34");
  const Planned low(device, "03 0005 0002");  // the low word of one, the high word of the next
  EXPECT_EQ(low.requests(), Texts{"03 00 04 00 04"});
  EXPECT_EQ(low.answer({"03 08 5678 1234 DEF0 9ABC"}), "03 04 56 78 9A BC");
  const Planned quarter(device, "03 0020 0001");
  EXPECT_EQ(quarter.requests(), Texts{"03 00 1E 00 04"});
  EXPECT_EQ(quarter.answer({"03 08 0004 0003 0002 0001"}), "03 02 00 03");
}

TEST(WordOrderPlan, SingleWritesOfHalfAValueGoToItsPartner) {
  const auto device = small_drive();
  EXPECT_EQ(Planned(device, "06 0004 1234").requests(), Texts{"06 00 05 12 34"});
  EXPECT_EQ(Planned(device, "06 0005 1234").requests(), Texts{"06 00 04 12 34"});
  EXPECT_EQ(Planned(device, "16 0005 00F2 0025").requests(), Texts{"16 00 04 00 F2 00 25"});
  EXPECT_EQ(Planned(device, "06 001F 1234").requests(), Texts{"06 00 20 12 34"});
  EXPECT_EQ(Planned(device, "06 0003 1234").requests(), Texts{"06 00 03 12 34"});
  // The client gets its own address back.
  EXPECT_EQ(Planned(device, "06 0004 1234").answer({"06 0005 1234"}), "06 00 04 12 34");
  EXPECT_EQ(Planned(device, "16 0005 00F2 0025").answer({"16 0004 00F2 0025"}),
            "16 00 05 00 F2 00 25");
}

TEST(WordOrderPlan, AValueThatStartsMotionIsWrittenWhole) {
  const auto device = small_drive();
  for (const auto seen : {std::optional(WordOrder::big), std::optional<WordOrder>()}) {
    EXPECT_EQ(Planned(device, "06 0014 0001", seen).requests(), Texts{kIllegalValue});
    EXPECT_EQ(Planned(device, "16 0015 0001 0001", seen).requests(), Texts{kIllegalValue});
    EXPECT_EQ(Planned(device, "10 0013 0002 04 0001 0001", seen).requests(), Texts{kIllegalValue});
    EXPECT_EQ(Planned(device, "17 0000 0001 0015 0001 02 0001", seen).requests(),
              Texts{kIllegalValue});
  }
  EXPECT_EQ(Planned(device, "10 0014 0002 04 0000 2710").requests(),
            Texts{"10 00 14 00 02 04 27 10 00 00"});
  EXPECT_EQ(Planned(device, "03 0014 0001", {}).requests(), Texts{"03 00 14 00 01"});
}

TEST(WordOrderPlan, ReadWriteExchangesBothHalves) {
  const auto device = small_drive();
  const Planned both(device, "17 0005 0002 0006 0002 04 1111 2222");
  EXPECT_EQ(both.requests(), Texts{"17 00 04 00 04 00 06 00 02 04 22 22 11 11"});
  EXPECT_EQ(both.answer({"17 08 5678 1234 2222 1111"}), "17 04 56 78 11 11");
  EXPECT_EQ(both.answer({"97 02"}), "97 02");
}

TEST(WordOrderPlan, LongValuesAreTurnedRoundWhole) {
  const auto device = small_drive();
  EXPECT_EQ(Planned(device, "10 001E 0004 08 0001 0002 0003 0004").requests(),
            Texts{"10 00 1E 00 04 08 00 04 00 03 00 02 00 01"});
  EXPECT_EQ(Planned(device, "10 001E 0002 04 0001 0002").requests(), Texts{kIllegalValue});
}

TEST(WordOrderPlan, OtherTablesHaveTheirOwnValues) {
  auto device = small_drive();
  device.profile.values.add({Table::input_registers, 0});
  const Planned read(device, "04 0000 0004");
  EXPECT_EQ(read.requests(), Texts{"04 00 00 00 04"});
  EXPECT_EQ(read.answer({"04 08 0001 0002 0003 0004"}), "04 08 00 02 00 01 00 03 00 04");
}

// The RS-485 stepper: function 04 reads the same registers, one at a time.
TEST(WordOrderPlan, AReadThatOneFunctionCannotDoIsDoneByTheOther) {
  auto device = small_drive();
  device.profile.input_as_holding = true;
  device.profile.limits.read[3] = 1;
  EXPECT_EQ(Planned(device, "04 0003 0001").requests(), Texts{"04 00 03 00 01"});
  const Planned half(device, "04 0004 0001");
  EXPECT_EQ(half.requests(), Texts{"03 00 04 00 02"});
  EXPECT_EQ(half.answer({"03 04 5678 1234"}), "04 02 12 34");
  EXPECT_EQ(half.answer({"83 02"}), "84 02");
  EXPECT_EQ(Planned(device, "04 0003 0003").requests(), Texts{"03 00 03 00 03"});
}

drive::Device opcode_drive(std::optional<WordOrder> opcode_order) {
  auto device = small_drive();
  device.profile.position_opcodes = drive::PositionOpcodes{100, {0x98, 0xA5}, 101};
  device.opcode_order = opcode_order;
  return device;
}

TEST(WordOrderPlan, OpcodesWithAPositionOfUnstatedOrderAreRefused) {
  const auto device = opcode_drive({});
  EXPECT_EQ(Planned(device, "06 0064 0098").requests(), Texts{kIllegalValue});
  EXPECT_EQ(Planned(device, "10 0064 0003 06 00A5 0001 0002").requests(), Texts{kIllegalValue});
  EXPECT_EQ(Planned(device, "16 0064 0000 0098").requests(), Texts{kIllegalValue});
  EXPECT_EQ(Planned(device, "06 0064 0096").requests(), Texts{"06 00 64 00 96"});
  EXPECT_EQ(Planned(device, "10 0065 0002 04 0001 0002").requests(),
            Texts{"10 00 65 00 02 04 00 01 00 02"});
  EXPECT_EQ(Planned(device, "06 0064 0098", {}).requests(), Texts{"06 00 64 00 98"});
  EXPECT_EQ(Planned(device, "06 0064 0098", WordOrder::little).requests(), Texts{"06 00 64 00 98"});
}

TEST(WordOrderPlan, AStatedOpcodeOrderIsKept) {
  const auto big = opcode_drive(WordOrder::big);
  EXPECT_EQ(Planned(big, "06 0064 0098").requests(), Texts{"06 00 64 00 98"});
  EXPECT_EQ(Planned(big, "10 0064 0003 06 0098 0001 0002").requests(),
            Texts{"10 00 64 00 03 06 00 98 00 01 00 02"});
  const auto little = opcode_drive(WordOrder::little);
  EXPECT_EQ(Planned(little, "10 0064 0003 06 0098 0001 0002").requests(),
            Texts{"10 00 64 00 03 06 00 98 00 02 00 01"});
  // Written one after the other, the position cannot be exchanged any more.
  EXPECT_EQ(Planned(little, "06 0064 0098").requests(), Texts{kIllegalValue});
  EXPECT_EQ(Planned(little, "10 0064 0002 04 0098 0001").requests(), Texts{kIllegalValue});
}

}  // namespace
}  // namespace mbgate::test
