// SPDX-License-Identifier: Apache-2.0
// More registers than a MOONS' drive gives at once (50; manual line 229): the client's request
// becomes three, and its answer is one.
#include "drives/drive_bench.hpp"
#include "drives/simulated_maps.hpp"
#include "sim/drives/moons_drive.hpp"

namespace mbgate::test {
namespace {

using sim::MoonsDrive;

constexpr std::uint16_t kAsked = 125;
constexpr std::uint16_t kLimit = 50;

/// A value that no other register and no other half holds.
std::uint32_t mark_of(const Place& place, std::uint32_t address) {
  return place.part == Part::word ? address + 1
                                  : ((0x8000U + address) << 16U) | (0x4000U + address);
}

void mark_all(MoonsDrive& drive, MoonsSeries series) {
  for (std::uint32_t address = 0;; ++address) {
    const Place place = place_of(sim::moons_registers(series), address);
    if (place.part == Part::none) {
      return;
    }
    if (place.part != Part::second_half) {
      drive.registers().set(static_cast<std::uint16_t>(address), mark_of(place, address));
    }
  }
}

/// What a big-endian client must see of it.
std::string marks(MoonsSeries series, std::uint16_t first) {
  manuals::ByteList frame{1, 3, kAsked * 2};
  for (std::uint32_t address = first; address < std::uint32_t{first} + kAsked; ++address) {
    const Place place = place_of(sim::moons_registers(series), address);
    const std::uint32_t mark =
        mark_of(place, address - (place.part == Part::second_half ? 1U : 0U));
    const std::uint32_t word = place.part == Part::first_half ? mark >> 16U : mark & 0xFFFFU;
    frame.push_back(static_cast<std::uint8_t>(word >> 8U));
    frame.push_back(static_cast<std::uint8_t>(word & 0xFFU));
  }
  return tcp_of(unhex(rtu_of(frame)));
}

/// A drive at unit 1 and another one at unit 2, both low word first.
class LongReads : public testing::TestWithParam<Series> {
 protected:
  LongReads()
      : rig_(routes_to({device_with(GetParam().profile, WordOrder::little, 1),
                        device_with(GetParam().profile, WordOrder::little, 2)},
                       WordOrder::big)),
        drive_(GetParam().series, WordOrder::little) {
    mark_all(drive_, GetParam().series);
    rig_.connect(1, "192.0.2.1");
    rig_.connect(2, "192.0.2.2");
  }

  /// The next frame on the line, for unit 1, which the drive answers: what it asks for.
  modbus::TableRange serve_part() {
    const std::string frame = next_frame(rig_);
    EXPECT_EQ(frame.substr(0, 6), "01 03 ");
    const auto range = range_of(request_of(frame));
    EXPECT_LE(range.count, kLimit);
    rig_.advance(10ms);
    rig_.line(simulated_response(drive_, frame));
    return range;
  }

  void expect_one_answer_of_three_parts(std::uint16_t first) {
    const auto map = sim::moons_registers(GetParam().series);
    std::uint32_t next = first - (place_of(map, first).part == Part::second_half ? 1U : 0U);
    const std::uint32_t end = std::uint32_t{first} + kAsked;
    rig_.receive(1, tcp_of(unhex(rtu_of(
                        manuals::ByteList{1, 3, static_cast<std::uint8_t>(first >> 8U),
                                          static_cast<std::uint8_t>(first & 0xFFU), 0, kAsked}))));
    rig_.receive(2, "0000 0000 0006 02 03 007C 0001");
    for (int part = 0; part < 3; ++part) {
      EXPECT_TRUE(rig_.sent[1].empty());
      const auto range = serve_part();
      EXPECT_EQ(range.first, next);
      EXPECT_FALSE(cuts_value(map, range)) << range.first << ' ' << range.count;
      next = drive::end_of(range);
    }
    EXPECT_GE(next, end);
    EXPECT_EQ(next_adu(rig_, 1), marks(GetParam().series, first));
    EXPECT_TRUE(rig_.sent[1].empty());
    EXPECT_EQ(next_frame(rig_).substr(0, 6), "02 03 ");
    rig_.respond("02 03 02 00 00");
    EXPECT_NE(next_adu(rig_, 2), "");
    rig_.advance(10ms);
  }

  MachineRig rig_;
  MoonsDrive drive_;
};

TEST_P(LongReads, Of125RegistersAreOneAnswerOfThreeTransactionsWithNothingBetween) {
  const auto map = sim::moons_registers(GetParam().series);
  for (std::uint16_t first = 0; place_of(map, first + kAsked - 1U).part != Part::none; ++first) {
    SCOPED_TRACE(first);
    ASSERT_NO_FATAL_FAILURE(expect_one_answer_of_three_parts(first));
  }
}

std::string case_name(const testing::TestParamInfo<Series>& info) {
  return std::string(info.param.profile).substr(6);
}

INSTANTIATE_TEST_SUITE_P(Series, LongReads, testing::Values(kSeries[0], kSeries[5]), case_name);

}  // namespace
}  // namespace mbgate::test
