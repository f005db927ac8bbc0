// SPDX-License-Identifier: Apache-2.0
// The profiles against the register maps of the simulated drives. Both were taken from the same
// manuals, one without the other: where they agree, neither was misread.
#include <gmock/gmock.h>

#include <set>

#include "drives/drive_bench.hpp"
#include "drives/simulated_maps.hpp"
#include "modbus/request.hpp"
#include "sim/drives/aic_drive.hpp"
#include "sim/drives/moons_drive.hpp"
#include "sim/drives/stepper_drive.hpp"

namespace mbgate::test::profiles_against_maps_test {
namespace {

using config::ValueAccess;
using modbus::Table;
using testing::IsEmpty;

constexpr std::array kTables{Table::coils, Table::discrete_inputs, Table::holding_registers,
                             Table::input_registers};

class Maps : public testing::TestWithParam<std::string> {
 protected:
  /// The registers, as the manual numbers them, of which `differs(table, address)` is true.
  template <typename Predicate>
  [[nodiscard]] std::vector<std::string> registers_where(Predicate differs) const {
    std::vector<std::string> numbers;
    for (const Table table : kTables) {
      for (std::uint32_t address = 0; address < 0x10000; ++address) {
        if (differs(table, address)) {
          numbers.push_back(file_.number(table, address));
        }
      }
    }
    return numbers;
  }
  [[nodiscard]] static Place simulated(Table table, std::uint32_t address) {
    return place_of(registers_of(GetParam(), table), address);
  }
  [[nodiscard]] static bool is_simulated(Table table, std::uint32_t address, sim::Access access) {
    const Place place = simulated(table, address);
    return place.part != Part::none && place.run->access == access;
  }
  [[nodiscard]] static bool holds(const config::DocumentedRanges& ranges, Table table,
                                  std::uint32_t address) {
    return std::ranges::any_of(
        ranges, [&](const auto& range) { return drive::contains(range.fact, table, address); });
  }
  /// Which register of a 32-bit value it is; a string is none.
  [[nodiscard]] Part stated(Table table, std::uint32_t address) const {
    const drive::Value* value = file_.profile.values.at(table, address);
    if (value == nullptr) {
      return holds(file_.map, table, address) ? Part::word : Part::none;
    }
    return value->first == address ? Part::first_half : Part::second_half;
  }
  [[nodiscard]] Part simulated_part(Table table, std::uint32_t address) const {
    const Part part = simulated(table, address).part;
    return part != Part::none && holds(file_.strings, table, address) ? Part::word : part;
  }

  const config::ProfileFile& file_ = shipped_profile(GetParam());
};

/// The examples of 6.2 and 6.3 of the FDA6000's manual write registers 1 and 2, which its map does
/// not have; a simulated drive must answer them.
bool is_only_in_an_example(const std::string& profile, std::uint32_t address) {
  return profile == "higen-fda6000" && (address == 1 || address == 2);
}

TEST_P(Maps, HaveTheSameRegistersAndTheSameValues) {
  EXPECT_THAT(registers_where([&](Table table, std::uint32_t address) {
                return stated(table, address) != simulated_part(table, address) &&
                       !is_only_in_an_example(GetParam(), address);
              }),
              IsEmpty());
}

TEST_P(Maps, LetTheSameValuesBeReadAndWritten) {
  for (const config::ProfileValue& value : file_.values) {
    const auto access = value.access == ValueAccess::read    ? sim::Access::read_only
                        : value.access == ValueAccess::write ? sim::Access::write_only
                                                             : sim::Access::read_write;
    EXPECT_TRUE(is_simulated(value.value.table, value.value.first, access))
        << file_.number(value.value.table, value.value.first);
  }
}

TEST_P(Maps, HaveTheSameWriteOnlyRegisters) {
  EXPECT_THAT(registers_where([&](Table table, std::uint32_t address) {
                return is_simulated(table, address, sim::Access::write_only) !=
                       drive::covers(file_.profile.write_only,
                                     {table, static_cast<std::uint16_t>(address), 1});
              }),
              IsEmpty());
}

/// The stepper's position deviation is listed as R/W (line 90), and described as read only (line
/// 546). The manual does not settle it: 0x0012 is described so too (line 565), and written in line
/// 594.
bool is_undecided(const std::string& profile, std::uint32_t address) {
  return profile == "rs485-stepper" && address == 0x0011;
}

// Discrete inputs and input registers are so by their nature.
TEST_P(Maps, HaveTheSameReadOnlyRegisters) {
  EXPECT_THAT(registers_where([&](Table table, std::uint32_t address) {
                return table != Table::discrete_inputs && table != Table::input_registers &&
                       !is_undecided(GetParam(), address) &&
                       is_simulated(table, address, sim::Access::read_only) !=
                           drive::covers(file_.profile.read_only,
                                         {table, static_cast<std::uint16_t>(address), 1});
              }),
              IsEmpty());
}

std::string case_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Profiles, Maps,
                         testing::Values("moons-st", "moons-stb", "moons-stf", "moons-ssdc",
                                         "moons-m2", "moons-m3", "moons-mdx", "moons-bldc",
                                         "rs485-stepper", "autonics-aic", "higen-fda6000"),
                         case_name);

/// What a read of one register gives.
std::uint16_t register_of(sim::MoonsDrive& drive, std::uint16_t address) {
  const auto request = modbus::make_read({Table::holding_registers, address, 1});
  return modbus::load_be16(drive.answer(request.pdu()).response.value().bytes(), 2);
}

TEST(MoonsProfiles, SayWhereADriveShowsItsWordOrder) {
  for (const Series& series : kSeries) {
    const auto& stated = shipped_profile(series.profile).profile.word_order_register;
    ASSERT_EQ(stated.has_value(), sim::moons_places(series.series).protocol.has_value())
        << series.profile;
    if (stated) {
      sim::MoonsDrive big(series.series, WordOrder::big);
      sim::MoonsDrive little(series.series, WordOrder::little);
      EXPECT_THAT(stated->big, testing::Contains(register_of(big, stated->address)));
      EXPECT_THAT(stated->little, testing::Contains(register_of(little, stated->address)));
    }
  }
}

TEST(MoonsProfiles, SayWhereThePositionOfEpAndSpStands) {
  for (const Series& series : kSeries) {
    const auto& stated = shipped_profile(series.profile).profile.position_opcodes.value();
    EXPECT_EQ(stated.address, sim::kMoonsOpcode);
    EXPECT_EQ(stated.position, sim::kMoonsParameters);
    EXPECT_THAT(stated.opcodes, testing::ElementsAre(0x98, 0xA5));
  }
}

/// How a drive gives the value that it holds at `address`.
template <typename Drive>
WordOrder order_of(Drive& drive, sim::RegisterBank& bank, std::uint16_t address) {
  bank.set(address, 0x00010002);
  const auto request = modbus::make_read({Table::holding_registers, address, 2});
  const std::string response = hex(drive.answer(request.pdu()).response.value().bytes());
  return response == "03 04 00 01 00 02" ? WordOrder::big : WordOrder::little;
}

TEST(FixedWordOrders, AreThoseOfTheSimulatedDrives) {
  sim::StepperDrive stepper;
  EXPECT_EQ(shipped_profile("rs485-stepper").profile.word_order,
            order_of(stepper, stepper.registers(), sim::kStepperMicrosteps));
  sim::AicDrive aic;
  EXPECT_EQ(shipped_profile("autonics-aic").profile.word_order,
            order_of(aic, aic.bank(Table::holding_registers), sim::kAicPositionToMove));
  EXPECT_EQ(shipped_profile("higen-fda6000").profile.word_order, std::nullopt);
  for (const Series& series : kSeries) {
    EXPECT_TRUE(shipped_profile(series.profile).profile.word_order_settable);
  }
}

template <typename Drive>
bool finds_too_many(Drive& drive, const modbus::Request& request) {
  const modbus::Pdu response = drive.answer(request.pdu()).response.value();
  return response.is_exception() && response.bytes()[1] == 0x03;
}

/// Does the drive take as many registers from `first` on as the profile says, and no more?
template <typename Drive>
void expect_same_limits(Drive drive, const std::string& profile, modbus::TableRange range) {
  const drive::Limits& limits = shipped_profile(profile).profile.limits;
  range.count = limits.read_from(range.table);
  EXPECT_FALSE(finds_too_many(drive, modbus::make_read(range))) << profile;
  if (++range.count <= 125) {
    EXPECT_TRUE(finds_too_many(drive, modbus::make_read(range))) << profile;
  }
  if (range.table == Table::holding_registers) {
    const std::vector<std::uint8_t> zeros(std::size_t{limits.write_registers} * 2 + 2);
    const modbus::Bytes more(zeros);
    range.count = limits.write_registers;
    EXPECT_FALSE(
        finds_too_many(drive, modbus::make_multiple_write(range, more.subspan(0, more.size() - 2))))
        << profile;
    if (++range.count <= 123) {
      EXPECT_TRUE(finds_too_many(drive, modbus::make_multiple_write(range, more))) << profile;
    }
  }
}

// Of the FDA6000 no limit is stated; its profile keeps to the longest run of its map.
TEST(Limits, AreThoseOfTheSimulatedDrives) {
  for (const Series& series : kSeries) {
    const std::uint16_t first = series.series == MoonsSeries::m3 ? 0x0084 : 0x003C;
    expect_same_limits(sim::MoonsDrive(series.series, WordOrder::big), series.profile,
                       {Table::holding_registers, first, 1});
  }
  expect_same_limits(sim::StepperDrive(), "rs485-stepper", {Table::holding_registers, 300, 1});
  expect_same_limits(sim::StepperDrive(), "rs485-stepper", {Table::input_registers, 0x0015, 1});
  expect_same_limits(sim::AicDrive(), "autonics-aic",
                     {Table::holding_registers, sim::kAicFirstStep, 1});
}

TEST(AicProfile, HasTheParameterGroupsOfTheSimulatedDrive) {
  const auto& file = shipped_profile("autonics-aic");
  std::vector<std::string> different;
  for (const Table table : kTables) {
    for (std::uint32_t address = 0; address < 0xFFFF; ++address) {
      const modbus::TableRange two{table, static_cast<std::uint16_t>(address), 2};
      std::optional<bool> stays;
      for (const auto& group : file.groups) {
        if (drive::contains(group.fact, table, address)) {
          stays = drive::contains(group.fact, table, address + 1);
        }
      }
      if (stays != sim::aic_stays_in_group(two)) {
        different.push_back(file.number(table, address));
      }
    }
  }
  EXPECT_THAT(different, IsEmpty());
}

// 2.13: the command coils and the communication registers.
TEST(AicProfile, HasTheBroadcastsOfTheSimulatedDrive) {
  const drive::Broadcast& broadcast = shipped_profile("autonics-aic").profile.broadcast;
  EXPECT_EQ(broadcast.form, (drive::BroadcastForm{129, 0x80}));
  EXPECT_EQ(broadcast.most_registers, 2);
  const auto in = [](std::uint32_t address, std::uint32_t first, std::uint32_t last) {
    return address >= first && address <= last;
  };
  for (const Table table : kTables) {
    for (std::uint32_t address = 0; address < 0x10000; ++address) {
      const bool simulated =
          (table == Table::coils && in(address, sim::kAicFirstCommand, sim::kAicLastCommand)) ||
          (table == Table::holding_registers &&
           in(address, sim::kAicFirstCommunication, sim::kAicLastCommunication));
      EXPECT_EQ(
          drive::covers(broadcast.allowed.value(), {table, static_cast<std::uint16_t>(address), 1}),
          simulated);
    }
  }
}

TEST(Broadcasts, HaveTheFormThatTheSimulatedDrivesHear) {
  using drive::BroadcastForm;
  const auto form = [](const std::string& profile) {
    return shipped_profile(profile).profile.broadcast.form;
  };
  for (const Series& series : kSeries) {
    EXPECT_EQ(form(series.profile), BroadcastForm{});
  }
  EXPECT_EQ(sim::MoonsDrive::kBroadcastAddress, modbus::kBroadcastAddress);
  EXPECT_EQ(form("rs485-stepper"), BroadcastForm{});
  EXPECT_EQ(sim::StepperDrive::kBroadcastAddress, modbus::kBroadcastAddress);
  EXPECT_EQ(form("higen-fda6000"), std::nullopt);
}

}  // namespace
}  // namespace mbgate::test::profiles_against_maps_test
