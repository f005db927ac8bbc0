// SPDX-License-Identifier: Apache-2.0
// Requests that become several: limits, parameter groups, preferred functions.
#include "device_rig.hpp"

namespace mbgate::test {
namespace {

drive::Device limited_drive() {
  auto device = small_drive();
  device.profile.limits.read[2] = 5;
  device.profile.limits.write_registers = 5;
  return device;
}

TEST(LimitsPlan, SplitsAReadButNeverThroughAValue) {
  const auto device = limited_drive();
  const Planned read(device, "03 0002 000C", {});
  // 2-6 would cut the value at 6, 6-10 the one at 10.
  EXPECT_EQ(read.requests(), (Texts{"03 00 02 00 04", "03 00 06 00 04", "03 00 0A 00 04"}));
  EXPECT_EQ(read.answer({"03 08 0002 0003 0004 0005", "03 08 0006 0007 0008 0009",
                         "03 08 000A 000B 000C 000D"}),
            "03 18 00 02 00 03 00 04 00 05 00 06 00 07 00 08 00 09 00 0A 00 0B 00 0C 00 0D");
}

TEST(LimitsPlan, ExchangesAndTrimsWhatWasJoined) {
  const auto device = limited_drive();
  const Planned read(device, "03 0005 0006");
  EXPECT_EQ(read.requests(), (Texts{"03 00 04 00 05", "03 00 09 00 03"}));
  EXPECT_EQ(read.answer({"03 0A 0004 0005 0006 0007 0008", "03 06 0009 000A 000B"}),
            "03 0C 00 04 00 07 00 06 00 08 00 09 00 0B");
}

TEST(LimitsPlan, AnExceptionOfAPartIsTheAnswer) {
  const auto device = limited_drive();
  const Planned read(device, "03 0000 000A");
  EXPECT_EQ(read.answer({"03 0A 0000 0001 0002 0003 0005", "83 11"}), "83 11");
}

TEST(LimitsPlan, TheEchoOfOneRegisterHasTheValueThatTheDriveTook) {
  auto device = small_drive();
  device.limits_values = true;
  const Planned write(device, "06 0002 1388");
  EXPECT_EQ(write.answer({"06 0002 03E8"}), "06 00 02 03 E8");
  EXPECT_EQ(Planned(device, "05 0002 FF00").answer({"05 0002 0000"}), "05 00 02 00 00");
  device.write_function = 16;
  EXPECT_EQ(Planned(device, "06 0002 1388").answer({"10 0002 0001"}), "06 00 02 13 88");
}

TEST(LimitsPlan, JoinsBits) {
  auto device = small_drive();
  device.profile.limits.read[0] = 3;
  const Planned read(device, "01 0000 000A");
  EXPECT_EQ(read.requests(),
            (Texts{"01 00 00 00 03", "01 00 03 00 03", "01 00 06 00 03", "01 00 09 00 01"}));
  EXPECT_EQ(read.answer({"01 01 05", "01 01 02", "01 01 07", "01 01 01"}), "01 02 D5 03");
  EXPECT_EQ(read.answer({"01 01 04", "01 01 02", "01 01 03", "01 01 01"}), "01 02 D4 02");
  device.profile.limits.read[0] = 10;
  EXPECT_EQ(Planned(device, "01 0000 0014").answer({"01 02 01 02", "01 02 FF 01"}),
            "01 03 01 FE 07");
}

TEST(LimitsPlan, NeverCrossesTheBorderOfAGroup) {
  drive::Device device;
  device.profile.groups = {{Table::holding_registers, 10, 5},
                           {Table::holding_registers, 15, 5},
                           {Table::holding_registers, 30, 5}};
  EXPECT_EQ(Planned(device, "03 0008 0019", {}).requests(),
            (Texts{"03 00 08 00 02", "03 00 0A 00 05", "03 00 0F 00 05", "03 00 14 00 0A",
                   "03 00 1E 00 03"}));
  EXPECT_EQ(Planned(device, "04 0008 0019", {}).requests(), Texts{"04 00 08 00 19"});
  EXPECT_EQ(Planned(device, "10 000E 0002 04 0001 0002", {}).requests(), Texts{kIllegalValue});
  device.split_writes = true;
  EXPECT_EQ(Planned(device, "10 000E 0002 04 0001 0002", {}).requests(),
            (Texts{"10 00 0E 00 01 02 00 01", "10 00 0F 00 01 02 00 02"}));
  EXPECT_EQ(Planned(device, "17 000E 0002 0000 0001 02 0001", {}).requests(), Texts{kIllegalValue});
}

TEST(LimitsPlan, SplitsWritesOnlyWhereTheUserAllowsIt) {
  auto device = limited_drive();
  const auto* const request = "10 0002 0006 0C 0002 0003 0004 0005 0006 0007";
  EXPECT_EQ(Planned(device, request).requests(), Texts{kIllegalValue});
  device.split_writes = true;
  EXPECT_EQ(Planned(device, request).requests(),
            (Texts{"10 00 02 00 04 08 00 02 00 03 00 05 00 04", "10 00 06 00 02 04 00 07 00 06"}));
  EXPECT_EQ(Planned(device, request).answer({"10 0002 0004", "10 0006 0002"}), "10 00 02 00 06");
  EXPECT_EQ(Planned(device, request).answer({"10 0002 0004", "90 13"}), "90 13");
  device.profile.limits.write_coils = 3;
  EXPECT_EQ(Planned(device, "0F 0001 0005 01 15").requests(),
            (Texts{"0F 00 01 00 03 01 05", "0F 00 04 00 02 01 02"}));
}

TEST(LimitsPlan, AWriteOfCoilsInPiecesIsAnsweredAsOne) {
  auto device = small_drive();
  device.split_writes = true;
  device.profile.limits.write_coils = 10;
  const Planned write(device, "0F 0001 000D 02 55 15");
  EXPECT_EQ(write.requests(), (Texts{"0F 00 01 00 0A 02 55 01", "0F 00 0B 00 03 01 05"}));
  EXPECT_EQ(write.answer({"0F 0001 000A", "0F 000B 0003"}), "0F 00 01 00 0D");
}

TEST(LimitsPlan, AnswersThroughAWindowToAnotherTableWithTheClientsFunction) {
  const drive::Device device;
  routing::ResolvedRoute resolved;
  resolved.device = &device;
  resolved.route.first_unit = resolved.route.last_unit = resolved.route.first_address = 1;
  resolved.route.buses = {device.bus};
  resolved.route.windows = {{Table::holding_registers, 0, 16, Table::input_registers, 1000},
                            {Table::coils, 0, 16, Table::discrete_inputs, 32}};
  const auto answer_to = [&](std::string_view request, std::string_view response) {
    const auto plan = routing::Plan::make(resolved, 1, {}, pdu(request));
    return hex(answer_of(*plan, std::array{pdu(response)}).bytes());
  };
  EXPECT_EQ(answer_to("03 0000 0002", "04 04 0001 0002"), "03 04 00 01 00 02");
  EXPECT_EQ(answer_to("01 0000 000A", "02 02 CD 01"), "01 02 CD 01");
}

TEST(LimitsPlan, NeverSplitsAWriteOfAnOpcode) {
  auto device = limited_drive();
  device.split_writes = true;
  device.profile.position_opcodes = drive::PositionOpcodes{0, {0x98}, 1};
  EXPECT_EQ(Planned(device, "10 0000 0006 0C 0001 0002 0003 0004 0005 0006").requests(),
            Texts{kIllegalValue});
  EXPECT_EQ(Planned(device, "10 0000 0003 06 0001 0002 0003").requests(),
            Texts{"10 00 00 00 03 06 00 01 00 02 00 03"});
}

TEST(LimitsPlan, TurnsOneWriteIntoARunOfSingles) {
  auto device = small_drive();
  device.write_function = 0x06;
  const auto* const request = "10 0003 0004 08 0333 0444 0555 0999";
  EXPECT_EQ(Planned(device, request).requests(), Texts{kIllegalValue});  // it cuts the value at 6
  EXPECT_EQ(Planned(device, "10 0003 0003 06 0333 0444 0555").requests(),
            (Texts{"06 00 03 03 33", "10 00 04 00 02 04 05 55 04 44"}));
  device.split_values = true;
  EXPECT_EQ(Planned(device, "10 0003 0003 06 0333 0444 0555").requests(),
            (Texts{"06 00 03 03 33", "06 00 04 05 55", "06 00 05 04 44"}));
  EXPECT_EQ(Planned(device, "10 0013 0003 06 0333 0444 0555").requests(),
            (Texts{"06 00 13 03 33", "10 00 14 00 02 04 05 55 04 44"}));  // it starts motion
  EXPECT_EQ(Planned(device, "10 0000 0001 02 0001").requests(), Texts{"06 00 00 00 01"});
  EXPECT_EQ(Planned(device, "10 0000 0001 02 0001").answer({"06 0000 0001"}), "10 00 00 00 01");
}

TEST(LimitsPlan, ADriveThatHasOnlySingleWritesGetsThese) {
  auto device = small_drive();
  device.write_function = 0x06;
  device.profile.functions.reset(0x0F).reset(0x10);
  EXPECT_EQ(Planned(device, "10 0000 0001 02 0001").requests(), Texts{"06 00 00 00 01"});
  EXPECT_EQ(Planned(device, "0F 0000 0001 01 01").requests(), Texts{kNotAllowed});
}

TEST(LimitsPlan, ARunOfSinglesKeepsTogetherWhatIsWrittenOfAValue) {
  drive::Device device;
  device.write_function = 0x06;
  device.profile.values.add({Table::holding_registers, 0, 4, false});
  device.profile.values.add({Table::holding_registers, 4, 4, false});
  const auto* const request = "10 0004 0005 0A 0444 0555 0666 0777 0888";
  EXPECT_EQ(Planned(device, request, {}).requests(),
            (Texts{"10 00 04 00 04 08 04 44 05 55 06 66 07 77", "06 00 08 08 88"}));
  device.split_values = true;
  EXPECT_EQ(Planned(device, request, {}).requests(),
            (Texts{"06 00 04 04 44", "06 00 05 05 55", "06 00 06 06 66", "06 00 07 07 77",
                   "06 00 08 08 88"}));
}

TEST(LimitsPlan, TurnsASingleWriteIntoAMultipleOne) {
  auto device = small_drive();
  device.write_function = 0x10;
  EXPECT_EQ(Planned(device, "06 0003 1234").requests(), Texts{"10 00 03 00 01 02 12 34"});
  EXPECT_EQ(Planned(device, "06 0004 1234").requests(), Texts{"10 00 05 00 01 02 12 34"});
  EXPECT_EQ(Planned(device, "06 0003 1234").answer({"10 0003 0001"}), "06 00 03 12 34");
  EXPECT_EQ(Planned(device, "06 0003 1234").answer({"90 12"}), "86 12");
}

TEST(LimitsPlan, FunctionsThatTheDriveDoesNotHaveAreNotAllowed) {
  auto device = small_drive();
  device.profile.functions.reset();
  for (const std::size_t function : {3U, 6U, 16U}) {
    device.profile.functions.set(function);
  }
  EXPECT_EQ(Planned(device, "04 0000 0001").requests(), Texts{kNotAllowed});
  EXPECT_EQ(Planned(device, "2B 0E 01 00").requests(), Texts{kNotAllowed});
  EXPECT_EQ(Planned(device, "46 0001").requests(), Texts{kNotAllowed});
  EXPECT_EQ(Planned(device, "16 0014 0001 0001").requests(),
            Texts{kNotAllowed});  // and cuts a value
  EXPECT_EQ(Planned(device, "03 0000 0001").requests(), Texts{"03 00 00 00 01"});
  device.write_function = 0x10;
  device.profile.functions.reset(6);
  EXPECT_EQ(Planned(device, "06 0000 0001").requests(), Texts{"10 00 00 00 01 02 00 01"});
  device.profile.input_as_holding = true;  // several of these are read by function 3
  device.profile.limits.read[3] = 1;
  EXPECT_EQ(Planned(device, "04 0000 0002").requests(), Texts{"03 00 00 00 02"});
  EXPECT_EQ(Planned(device, "04 0000 0001").requests(), Texts{"03 00 00 00 01"});
}

TEST(LimitsPlan, CommunicationRegistersAreWrittenOnlyWhereTheUserAllowsIt) {
  auto device = small_drive();
  device.profile.communication = {{Table::holding_registers, 50, 2}};
  for (const auto* const request : {"06 0032 0005", "10 0030 0003 06 0001 0002 0003",
                                    "16 0033 0001 0001", "17 0000 0001 0032 0001 02 0001"}) {
    EXPECT_EQ(Planned(device, request).requests(), Texts{kNotAllowed}) << request;
  }
  EXPECT_EQ(Planned(device, "03 0032 0001").requests(), Texts{"03 00 32 00 01"});
  device.allow_reconfigure = true;
  const Planned allowed(device, "06 0032 0005");
  EXPECT_EQ(allowed.requests(), Texts{"06 00 32 00 05"});
}

// One register of values that matter, one whose bits do, and a coil.
drive::Device guarded_drive() {
  auto device = small_drive();
  device.profile.guarded = {{{Table::holding_registers, 50, 1}, 0xFFFFFFFF, 0},
                            {{Table::holding_registers, 60, 1}, 0x0400, 0x0400},
                            {{Table::holding_registers, 61, 1}, 0xFFFC, 8, true},
                            {{Table::coils, 3, 1}, 0xFFFFFFFF, 0xFF00}};
  return device;
}

TEST(LimitsPlan, WritesOfGuardedValuesAreRefusedWhereverTheyStand) {
  auto device = guarded_drive();
  for (const auto* const request :
       {"06 0032 0000", "10 0031 0003 06 0001 0000 0003", "06 003C 0400", "06 003C FFFF",
        "16 003C FFFF 0001", "17 0000 0001 0032 0001 02 0000", "06 003D 0007", "06 003D 000C",
        "05 0003 FF00", "0F 0002 0003 01 02"}) {
    EXPECT_EQ(Planned(device, request).requests(), Texts{kNotAllowed}) << request;
  }
  device.allow_reconfigure = true;
  EXPECT_EQ(Planned(device, "06 0032 0000").requests(), Texts{"06 00 32 00 00"});
}

TEST(LimitsPlan, OtherValuesOfGuardedRegistersPass) {
  const auto device = guarded_drive();
  EXPECT_EQ(Planned(device, "06 0032 0001").requests(), Texts{"06 00 32 00 01"});
  EXPECT_EQ(Planned(device, "06 003C FBFF").requests(), Texts{"06 00 3C FB FF"});
  EXPECT_EQ(Planned(device, "06 003D 000A").requests(), Texts{"06 00 3D 00 0A"});
  EXPECT_EQ(Planned(device, "05 0003 0000").requests(), Texts{"05 00 03 00 00"});
  EXPECT_EQ(Planned(device, "0F 0002 0003 01 05").requests(), Texts{"0F 00 02 00 03 01 05"});
  EXPECT_EQ(Planned(device, "03 0032 0001").requests(), Texts{"03 00 32 00 01"});
}

TEST(LimitsPlan, AGuardedValueIsComparedInItsOrder) {
  auto device = small_drive(WordOrder::little);
  device.profile.guarded = {{{Table::holding_registers, 10, 2}, 0xFFFFFFFC, 8, true}};
  // The client writes big, the drive gets little.
  EXPECT_EQ(Planned(device, "10 000A 0002 04 0000 0009").requests(),
            Texts{"10 00 0A 00 02 04 00 09 00 00"});
  EXPECT_EQ(Planned(device, "10 000A 0002 04 0009 0000").requests(), Texts{kNotAllowed});
  // Without an order of its own the route has the drive's.
  EXPECT_EQ(Planned(device, "10 000A 0002 04 0009 0000", {}).requests(),
            Texts{"10 00 0A 00 02 04 00 09 00 00"});
  EXPECT_EQ(Planned(device, "10 000A 0002 04 0000 0009", {}).requests(), Texts{kNotAllowed});
  // Nobody knows what half a value makes of it, nor what it is in no order.
  EXPECT_EQ(Planned(device, "06 000A 0009").requests(), Texts{kNotAllowed});
  device.word_order.reset();
  EXPECT_EQ(Planned(device, "10 000A 0002 04 0009 0000", {}).requests(), Texts{kNotAllowed});
}

TEST(LimitsPlan, AWriteOfSeveralRegistersNeverCutsAValue) {
  const auto device = small_drive();
  for (const auto seen : {std::optional<WordOrder>{}, std::optional(WordOrder::little),
                          std::optional(WordOrder::big)}) {
    for (const auto* const request :
         {"10 0004 0001 02 0001", "10 0005 0001 02 0001", "10 0003 0002 04 0001 0002",
          "10 0007 0002 04 0001 0002", "10 001E 0002 04 0001 0002",
          "17 0000 0001 0004 0001 02 0001"}) {
      EXPECT_EQ(Planned(device, request, seen).requests(), Texts{kIllegalValue}) << request;
    }
  }
  EXPECT_EQ(Planned(device, "10 0003 0003 06 0001 0002 0003", {}).requests(),
            Texts{"10 00 03 00 03 06 00 01 00 02 00 03"});
  EXPECT_EQ(Planned(device, "06 0004 0001", {}).requests(), Texts{"06 00 04 00 01"});
}

}  // namespace
}  // namespace mbgate::test
