// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "profile_device.hpp"

namespace mbgate::ctl {
namespace {

using modbus::TableRange;
using testing::ElementsAre;
using testing::IsEmpty;
using Units = std::vector<std::uint8_t>;

/// Devices by their unit; nobody else answers.
class Bus {
 public:
  void add(std::uint8_t unit, const std::string& profile) { devices_.emplace(unit, profile); }

  Result<Answer, std::string> ask(std::uint8_t unit, const TableRange& read) {
    ++asked[unit];
    const auto device = devices_.find(unit);
    return device == devices_.end() ? Answer{AnswerKind::silence} : device->second.answer(read);
  }
  AskUnit asker() {
    return [this](std::uint8_t unit, const TableRange& read) { return ask(unit, read); };
  }

  std::map<std::uint8_t, int> asked;

 private:
  std::map<std::uint8_t, ProfileDevice> devices_;
};

ScanResult scan(const Units& units, const AskUnit& ask) {
  return scan_units(units, shipped_catalogue(), ask, [](std::uint8_t, std::size_t) {});
}

Units found_units(const ScanResult& result) {
  Units units;
  for (const auto& found : result.found) {
    units.push_back(found.unit);
  }
  return units;
}

TEST(Scan, FindsTheUnitsThatAnswerAndAsksAbsentOnesOnce) {
  Bus bus;
  bus.add(2, "moons-m3");
  bus.add(4, "autonics-aic");
  const auto result = scan({1, 2, 3, 4, 5}, bus.asker());
  EXPECT_THAT(found_units(result), ElementsAre(2, 4));
  EXPECT_EQ(bus.asked[1], 1);
  EXPECT_EQ(bus.asked[3], 1);
  EXPECT_EQ(bus.asked[5], 1);
  EXPECT_EQ(result.found[0].identification.likely.front()->profile.name, "moons-m3");
  EXPECT_EQ(result.found[0].slowest, std::chrono::milliseconds(4));
  EXPECT_FALSE(result.error);
}

TEST(Scan, CountsAUnitThatTheGatewayHasNoWayToAsAbsent) {
  const auto result = scan({1, 2}, [](std::uint8_t, const TableRange&) {
    return Answer{AnswerKind::no_way, 0x0A};
  });
  EXPECT_THAT(found_units(result), IsEmpty());
  EXPECT_FALSE(result.any_way);
}

TEST(Scan, TellsSilenceFromNoWay) {
  Bus bus;
  EXPECT_TRUE(scan({1}, bus.asker()).any_way);
}

TEST(Scan, AsksABusyUnitAgain) {
  Bus bus;
  bus.add(1, "moons-st");
  int busy = 2;
  const auto result = scan({1}, [&](std::uint8_t unit, const TableRange& read) {
    return busy-- > 0 ? Answer{AnswerKind::busy, 0x06} : *bus.ask(unit, read);
  });
  EXPECT_THAT(found_units(result), ElementsAre(1));
  EXPECT_THAT(result.busy, IsEmpty());
}

TEST(Scan, NamesAUnitThatStaysBusy) {
  int asked = 0;
  const auto result = scan({9}, [&](std::uint8_t, const TableRange&) {
    ++asked;
    return Answer{AnswerKind::busy, 0x06};
  });
  EXPECT_THAT(found_units(result), IsEmpty());
  EXPECT_THAT(result.busy, ElementsAre(9));
  EXPECT_EQ(asked, 3);
}

TEST(Scan, AsksAUnitNoFurtherThatFellSilent) {
  int asked = 0;
  const auto result = scan({1}, [&](std::uint8_t, const TableRange&) {
    return ++asked == 1 ? Answer{AnswerKind::data, 0, {0}} : Answer{AnswerKind::silence};
  });
  EXPECT_THAT(found_units(result), ElementsAre(1));
  EXPECT_TRUE(result.found.front().fell_silent);
  EXPECT_EQ(asked, 4);
}

TEST(Scan, EndsWithAnErrorAndKeepsWhatItHas) {
  Bus bus;
  bus.add(1, "moons-st");
  const auto result = scan(
      {1, 2, 3}, [&](std::uint8_t unit, const TableRange& read) -> Result<Answer, std::string> {
        if (unit == 2) {
          return std::string("the connection is lost");
        }
        return bus.ask(unit, read);
      });
  EXPECT_THAT(found_units(result), ElementsAre(1));
  EXPECT_EQ(result.error, "the connection is lost");
  EXPECT_EQ(bus.asked[3], 0);
}

TEST(Scan, NeverWrites) {
  Bus bus;
  bus.add(1, "autonics-aic");
  scan({1}, [&](std::uint8_t unit, const TableRange& read) {
    EXPECT_GE(read_function(read.table), 1);
    EXPECT_LE(read_function(read.table), 4);
    return bus.ask(unit, read);
  });
}

TEST(Units, AreSinglesAndRanges) {
  EXPECT_EQ(*parse_units("5"), Units({5}));
  EXPECT_EQ(*parse_units("1-3"), Units({1, 2, 3}));
  EXPECT_EQ(*parse_units("17,1-2,2"), Units({1, 2, 17}));
  EXPECT_EQ(parse_units("1-254")->size(), 254U);
}

TEST(Units, AreNotOutsideTheBusNorNothing) {
  for (const std::string text : {"", "0", "255", "3-1", "1-", "-2", "1,,2", "a", "1-2-3", "1 "}) {
    const auto units = parse_units(text);
    ASSERT_FALSE(units) << text;
    EXPECT_EQ(units.error(),
              "\"" + text + "\" is not a list of units: 1 to 254, like 5 or 1-32 or 1-8,17");
  }
}

}  // namespace
}  // namespace mbgate::ctl
