// SPDX-License-Identifier: Apache-2.0
// The profiles in conf/profiles: every file is right, none is missing, and each has as many values
// as its manual.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "config/profiles/profile_library.hpp"

namespace mbgate::config::profiles_test {
namespace {

namespace fs = std::filesystem;
using modbus::Table;

const fs::path kFolder = fs::path(MBGATE_SOURCE_DIR) / "conf/profiles";

std::vector<std::string> names() { return ProfileLibrary({kFolder}).names(); }

/// Registers of 32-bit values by table, counted by hand in the manuals' tables.
const std::map<std::string, std::size_t> kValues32 = {
    {"moons-st", 34}, {"moons-stb", 34}, {"moons-stf", 35}, {"moons-ssdc", 36},
    {"moons-m2", 34}, {"moons-m3", 246}, {"moons-mdx", 34}, {"moons-bldc", 33}};

TEST(Profiles, AreAllThere) {
  EXPECT_THAT(names(),
              testing::IsSupersetOf({"moons-st", "moons-stb", "moons-stf", "moons-ssdc", "moons-m2",
                                     "moons-m3", "moons-mdx", "moons-bldc", "rs485-stepper",
                                     "autonics-aic", "higen-fda6000", "generic"}));
}

class Profile : public testing::TestWithParam<std::string> {
 public:
  void SetUp() override {
    const auto loaded = load_profile(read_text_file(kFolder / (GetParam() + ".toml")));
    ASSERT_EQ(render(loaded.diagnostics), "");
    file = loaded.file;
    ASSERT_TRUE(file);
  }
  std::optional<ProfileFile> file;
};

TEST_P(Profile, SaysWhereItComesFrom) {
  EXPECT_EQ(file->profile.name, GetParam());
  EXPECT_NE(file->description, "");
  EXPECT_NE(file->manual, "");
  EXPECT_NE(file->section, "");
}

/// Counted register by register, without the rules that the loader itself uses.
TEST_P(Profile, HasNoRegisterInTwoValues) {
  std::set<std::pair<Table, std::uint32_t>> taken;
  for (const auto& value : file->values) {
    for (std::uint32_t i = 0; i < value.value.registers; ++i) {
      EXPECT_TRUE(taken.emplace(value.value.table, value.value.first + i).second)
          << file->number(value.value.table, value.value.first + i);
    }
  }
  for (const auto& string : file->strings) {
    for (std::uint32_t i = 0; i < string.fact.count; ++i) {
      EXPECT_FALSE(taken.contains({string.fact.table, string.fact.first + i}));
    }
  }
}

TEST_P(Profile, HasItsValuesWithinTheMap) {
  std::set<std::pair<Table, std::uint32_t>> mapped;
  for (const auto& range : file->map) {
    for (std::uint32_t i = 0; i < range.fact.count; ++i) {
      mapped.emplace(range.fact.table, range.fact.first + i);
    }
  }
  for (const auto& value : file->values) {
    for (std::uint32_t i = 0; i < value.value.registers; ++i) {
      EXPECT_TRUE(mapped.contains({value.value.table, value.value.first + i}))
          << file->number(value.value.table, value.value.first + i);
    }
  }
}

TEST_P(Profile, HasAsManyValuesAsItsManual) {
  const auto expected = kValues32.find(GetParam());
  if (expected != kValues32.end()) {
    EXPECT_EQ(file->profile.values.all().size(), expected->second);
  }
  EXPECT_EQ(file->profile.values.all().size(), file->values.size());
}

/// What a person looks up must be there: each value and each stop has its name and its line.
TEST_P(Profile, NamesTheManualsLineOfEveryValueAndStop) {
  for (const auto& value : file->values) {
    EXPECT_TRUE(value.source.line) << file->number(value.value.table, value.value.first);
    EXPECT_NE(value.source.name, "") << file->number(value.value.table, value.value.first);
  }
  for (const auto& stop : file->stops) {
    EXPECT_TRUE(stop.source.line) << stop.source.name;
  }
}

/// MOONS' opcode register has five parameters behind it, which no stop uses.
TEST_P(Profile, LetsOnlyMoonsParametersGoAlongWithAStop) {
  const bool moons = GetParam().starts_with("moons-");
  for (const auto& stop : file->profile.stops) {
    EXPECT_EQ(stop.parameters, moons ? 5 : 0) << file->number(stop.table, stop.address);
  }
  EXPECT_TRUE(!moons || file->profile.stops.size() == 3);
}

std::string case_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Files, Profile, testing::ValuesIn(names()), case_name);

TEST(GenericProfile, IsTheSameWithAndWithoutItsFile) {
  ProfileLibrary with_file({kFolder});
  ProfileLibrary built_in({});
  const auto* one = with_file.find("generic");
  const auto* other = built_in.find("generic");
  ASSERT_NE(one, nullptr);
  ASSERT_NE(other, nullptr);
  EXPECT_EQ(one->profile.name, other->profile.name);
  EXPECT_EQ(one->profile.functions, other->profile.functions);
  EXPECT_EQ(one->profile.limits.read, other->profile.limits.read);
  EXPECT_EQ(one->profile.limits.write_registers, other->profile.limits.write_registers);
  EXPECT_EQ(one->profile.broadcast.form, other->profile.broadcast.form);
  EXPECT_EQ(one->profile.last_address, other->profile.last_address);
  EXPECT_TRUE(other->profile.stops.empty());
  EXPECT_TRUE(other->profile.values.all().empty());
}

}  // namespace
}  // namespace mbgate::config::profiles_test
