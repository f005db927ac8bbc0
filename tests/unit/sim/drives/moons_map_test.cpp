// SPDX-License-Identifier: Apache-2.0
// The tables of MOONS' eight series, and what a drive of each answers.
#include "sim/drives/maps/moons_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "manuals/vectors.hpp"
#include "modbus/frames.hpp"
#include "sim/drives/moons_drive.hpp"
#include "unit/sim/drives/drive_rig.hpp"

namespace mbgate::test::moons_map_test {
namespace {

using drive::WordOrder;
using sim::MoonsDrive;
using sim::MoonsSeries;

struct Table {
  MoonsSeries series;
  unsigned values;     ///< 32-bit values
  unsigned registers;  ///< the last printed number is 40000 and this
};

constexpr std::array kTables{Table{MoonsSeries::st, 34, 130},  Table{MoonsSeries::stb, 34, 200},
                             Table{MoonsSeries::stf, 35, 250}, Table{MoonsSeries::ssdc, 36, 200},
                             Table{MoonsSeries::m2, 34, 200},  Table{MoonsSeries::m3, 246, 590},
                             Table{MoonsSeries::mdx, 34, 196}, Table{MoonsSeries::bldc, 33, 130}};

TEST(MoonsMaps, HaveNoGapsAndTheRightNumberOfValues) {
  for (const Table& table : kTables) {
    unsigned next = 0;
    unsigned values = 0;
    for (const sim::RegisterRun& run : sim::moons_registers(table.series)) {
      EXPECT_EQ(run.first, next);
      next += run.entries * static_cast<unsigned>(run.width);
      values += run.width == sim::Width::value ? run.entries : 0U;
    }
    EXPECT_EQ(values, table.values) << table.registers;
    EXPECT_EQ(next, table.registers);
  }
}

TEST(MoonsMaps, HoldInitialValuesThatMayBeWritten) {
  for (const Table& table : kTables) {
    for (const sim::RegisterRun& run : sim::moons_registers(table.series)) {
      const auto limits = run.limits.value_or(sim::Limits{0, 0xFFFFFFFF});
      EXPECT_TRUE(run.initial >= std::max<std::int64_t>(limits.lowest, 0) &&
                  run.initial <= limits.highest)
          << run.first;
    }
  }
}

/// The drive's answer to a read of `count` registers from `first` on.
std::string read(MoonsDrive& drive, std::uint16_t first, std::uint8_t count) {
  std::vector<std::uint8_t> pdu{3, 0, 0, 0, count};
  modbus::store_be16(pdu, 1, first);
  return answer_of(drive, hex(pdu));
}

TEST(MoonsMaps, ShowTheWordOrderWhereASeriesHasPr) {
  for (const auto& [series, address] :
       {std::pair{MoonsSeries::stb, 0x0095}, std::pair{MoonsSeries::stf, 0x0095},
        std::pair{MoonsSeries::ssdc, 0x0095}, std::pair{MoonsSeries::m2, 0x00B0},
        std::pair{MoonsSeries::mdx, 0x00B0}}) {
    MoonsDrive big(series, WordOrder::big);
    MoonsDrive little(series, WordOrder::little);
    EXPECT_EQ(read(big, static_cast<std::uint16_t>(address), 1), "03 02 00 05");
    EXPECT_EQ(read(little, static_cast<std::uint16_t>(address), 1), "03 02 00 85");
  }
}

TEST(MoonsMaps, ShowItAsAValueInAnM3) {
  MoonsDrive big(MoonsSeries::m3, WordOrder::big);
  MoonsDrive little(MoonsSeries::m3, WordOrder::little);
  EXPECT_EQ(read(big, 0x0120, 2), "03 04 00 00 00 05");
  EXPECT_EQ(read(little, 0x0120, 2), "03 04 00 85 00 00");
  EXPECT_EQ(answer_of(big, "10 01 20 00 02 04 00 00 01 85"), "10 01 20 00 02");  // PR=389
  EXPECT_EQ(read(big, 0x0120, 2), "03 04 01 85 00 00");
  EXPECT_EQ(answer_of(big, "10 01 20 00 02 04 01 05 00 00"), "10 01 20 00 02");  // PR=261
  EXPECT_EQ(read(big, 0x0120, 2), "03 04 00 00 01 05");
}

TEST(MoonsMaps, GiveTheCountersThatAreMisprintedAsValues) {
  for (const MoonsSeries series : {MoonsSeries::stb, MoonsSeries::stf}) {
    MoonsDrive drive(series, WordOrder::little);
    EXPECT_EQ(answer_of(drive, "10 00 35 00 02 04 00 01 00 02"), "10 00 35 00 02");
    EXPECT_EQ(drive.registers().get(0x0035), 0x00020001U);
  }
  MoonsDrive stf(MoonsSeries::stf, WordOrder::little);
  answer_of(stf, "10 00 B8 00 02 04 00 01 00 02");  // homing distance
  EXPECT_EQ(stf.registers().get(0x00B8), 0x00020001U);
  MoonsDrive bldc(MoonsSeries::bldc, WordOrder::little);
  answer_of(bldc, "10 00 35 00 02 04 00 01 00 02");  // two registers there
  EXPECT_EQ(bldc.registers().get(0x0035), 1U);
}

TEST(MoonsMaps, KeepTheRightsOfEachSeries) {
  const auto refusal = [](MoonsSeries series, std::string_view request) {
    MoonsDrive drive(series, WordOrder::big);
    return answer_of(drive, request);
  };
  EXPECT_EQ(refusal(MoonsSeries::bldc, "03 00 08 00 02"), "83 11");
  EXPECT_EQ(refusal(MoonsSeries::m2, "03 00 08 00 01"), "83 11");
  EXPECT_EQ(refusal(MoonsSeries::mdx, "03 00 08 00 02"), "03 04 00 00 00 00");
  EXPECT_EQ(refusal(MoonsSeries::m2, "06 00 3A 00 01"), "86 12");  // accumulator
  EXPECT_EQ(refusal(MoonsSeries::st, "06 00 3B 00 01"), "06 00 3B 00 01");
  EXPECT_EQ(refusal(MoonsSeries::mdx, "06 00 AB 00 01"), "86 12");
  EXPECT_EQ(refusal(MoonsSeries::m2, "06 00 AB 00 01"), "06 00 AB 00 01");
  EXPECT_EQ(refusal(MoonsSeries::ssdc, "10 00 C5 00 02 04 00 01 00 01"), "90 12");
  EXPECT_EQ(refusal(MoonsSeries::st, "03 00 82 00 01"), "83 02");
  EXPECT_EQ(refusal(MoonsSeries::m3, "03 02 4D 00 01"), "03 02 00 00");
  EXPECT_EQ(refusal(MoonsSeries::m3, "03 02 4D 00 02"), "83 02");
  EXPECT_EQ(refusal(MoonsSeries::m3, "03 00 06 00 33"), "83 03");
}

TEST(MoonsMaps, KeepTheRangesOfAnM3) {
  MoonsDrive drive(MoonsSeries::m3, WordOrder::big);
  EXPECT_EQ(answer_of(drive, "10 00 B0 00 02 04 00 00 00 02"), "10 00 B0 00 02");
  EXPECT_EQ(answer_of(drive, "10 00 B0 00 02 04 00 00 00 03"), "90 13");
  EXPECT_EQ(answer_of(drive, "10 01 56 00 02 04 FF FF A2 40"), "10 01 56 00 02");  // -24000
  EXPECT_EQ(answer_of(drive, "10 01 56 00 02 04 FF FF A2 3F"), "90 13");
  EXPECT_EQ(answer_of(drive, "06 01 09 00 00"), "86 13");
}

TEST(MoonsMaps, PutMotionWhereTheSeriesHasIt) {
  MoonsDrive drive(MoonsSeries::m3, WordOrder::big);
  EXPECT_EQ(answer_of(drive, "10 01 5E 00 02 04 00 03 0D 40"), "10 01 5E 00 02");
  EXPECT_EQ(answer_of(drive, "06 00 7C 00 66"), "06 00 7C 00 66");
  EXPECT_EQ(read(drive, 0x0006, 2), "03 04 00 03 0D 40");
  EXPECT_EQ(read(drive, 0x000A, 2), "03 04 00 03 0D 40");
  EXPECT_EQ(read(drive, 0x0020, 2), "03 04 00 03 0D 40");
  EXPECT_EQ(answer_of(drive, "10 01 56 00 02 04 00 00 09 60"), "10 01 56 00 02");
  EXPECT_EQ(answer_of(drive, "06 00 7C 00 96"), "06 00 7C 00 96");
  EXPECT_EQ(read(drive, 0x0010, 2), "03 04 09 60 09 60");
  EXPECT_EQ(read(drive, 0x0002, 2), "03 04 00 00 00 31");
  EXPECT_EQ(answer_of(drive, "06 00 7C 00 E1"), "06 00 7C 00 E1");
  EXPECT_EQ(read(drive, 0x0002, 2), "03 04 00 00 00 09");
}

TEST(MoonsMaps, ShowOnlyTheStatusBitsOfABldc) {
  MoonsDrive drive(MoonsSeries::bldc, WordOrder::big);
  EXPECT_EQ(read(drive, 0x0001, 1), "03 02 00 01");
  answer_of(drive, "06 00 7C 00 96");
  EXPECT_EQ(read(drive, 0x0001, 1), "03 02 00 21");
  answer_of(drive, "06 00 7C 00 D8");
  EXPECT_EQ(read(drive, 0x0001, 1), "03 02 00 01");
}

bool is_for_m3(unsigned line) { return line >= 586 && line <= 680; }

/// The examples with the low word first: 7.1 and 7.3 in parts, 7.4.4 up to its second half.
bool is_little(unsigned line) {
  return line == 481 || line == 621 || line == 667 || (line >= 729 && line < 851);
}

TEST(MoonsMaps, AnswerThePrintedRequests) {
  std::array drives{
      MoonsDrive(MoonsSeries::st, WordOrder::big), MoonsDrive(MoonsSeries::st, WordOrder::little),
      MoonsDrive(MoonsSeries::m3, WordOrder::big), MoonsDrive(MoonsSeries::m3, WordOrder::little)};
  for (MoonsDrive& drive : drives) {
    if (&drive < &drives[2]) {
      drive.registers().set(0x003E, 11);  // what the program of 7.4.1 sets
      drive.registers().set(0x0040, 12);
    }
  }
  unsigned compared = 0;
  for (const auto& [request, response] : manuals::load_transactions()) {
    const std::size_t which =
        (is_for_m3(request.line) ? 2U : 0U) + (is_little(request.line) ? 1U : 0U);
    const auto pdu = modbus::decode_rtu(request.rtu)->pdu;
    const auto answer = *drives[which].answer(pdu).response;
    EXPECT_FALSE(answer.is_exception()) << request.where() << ' ' << hex(answer.bytes());
    // The status that is printed last is that of a running program.
    if (response && response->line != 832) {
      EXPECT_EQ(hex(answer.bytes()), hex(modbus::decode_rtu(response->rtu)->pdu.bytes()))
          << request.where();
      ++compared;
    }
  }
  EXPECT_EQ(compared, 15U);
  EXPECT_EQ(drives[2].registers().get(0x016C), 5000U);
  EXPECT_EQ(drives[3].registers().get(0x016C), 5000U);
  EXPECT_EQ(drives[0].registers().get(0x004A), drives[1].registers().get(0x004A));
}

}  // namespace
}  // namespace mbgate::test::moons_map_test
